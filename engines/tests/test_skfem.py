"""The fluid of scikit-fem against closed forms, and the rules of the protocol."""

import numpy as np
import pytest
from conftest import load

import sillage
from sillage.testing import FluidDriver, fluid_scene

WEIGHT = np.array([0.0, -9810.0])


def driver_of(**changes):
    driver = FluidDriver(load("skfem-fluid").SkfemFluid())
    cells = changes.pop("cells", [12, 12])
    scene = fluid_scene(**changes)
    scene["mesh"]["rectangle"]["cells"] = cells
    mesh = driver.configure(scene)
    return driver, mesh


def random_response(count, seed=1):
    """Porosity, drag, entrained fraction and mobility, far from smooth."""
    random = np.random.default_rng(seed)
    porosity = random.uniform(0.2, 1.0, count)
    return {
        "porosity": porosity,
        "drag": random.uniform(0.0, 1e6, count),
        "entrained_fraction": (1.0 - porosity) * random.uniform(0.0, 1.0, count),
        "solid_mobility": random.uniform(0.0, 1e-6, count),
    }


def at_rest(fields):
    """Sources of grains that rest in a resting fluid: cG + … = s, j⁰ = κG."""
    return fields | {
        "drag_source": fields["entrained_fraction"][:, None] * WEIGHT,
        "solid_flux": fields["solid_mobility"][:, None] * WEIGHT,
    }


def test_rest_stays_rest_whatever_the_grains():
    driver, mesh = driver_of()
    with driver:
        found = driver.advance(0.1, **at_rest(random_response(len(mesh["nodes"]))))
    speed = np.abs(found.interstitial_velocity).max()
    gradient = np.abs(found.pressure_gradient - WEIGHT).max() / 9810.0
    print(f"\nlargest speed {speed:.1e} m/s, largest error of ∇p {gradient:.1e} of ρg")
    assert speed < 1e-11 and gradient < 1e-9


def test_a_developed_channel_flow_is_exact():
    boundaries = {
        "left": {"inflow": {"velocity": [1.0, 0.0], "profile": "parabolic"}},
        "right": {"open": {"pressure": 3.0}},
        "top": "no-slip",
        "bottom": "no-slip",
    }
    driver, mesh = driver_of(density=1.0, gravity=[0.0, 0.0], convection=False, boundaries=boundaries)
    with driver:
        for _ in range(2):
            found = driver.advance(1e4)
            driver.commit()
    error = np.abs(found.pressure - 3.0 - 8.0 * (1.0 - mesh["nodes"][:, 0])).max()
    print(f"\nlargest error of the pressure {error:.1e} of 8")
    assert error < 1e-3


def test_flow_through_a_uniform_bed_drops_its_pressure_exactly():
    """Plug flow through held grains: φ ∇p = −β v + …, v = U/φ, between slip walls."""
    boundaries = {
        "left": {"inflow": {"velocity": [0.02, 0.0], "profile": "uniform"}},
        "right": {"open": {"pressure": 0.0}},
        "top": "slip",
        "bottom": "slip",
    }
    driver, mesh = driver_of(gravity=[0.0, 0.0], boundaries=boundaries)
    count = len(mesh["nodes"])
    with driver:
        found = driver.advance(1e6, porosity=np.full(count, 0.4), drag=np.full(count, 1e5))
    assert np.allclose(found.interstitial_velocity, [0.05, 0.0], atol=1e-9)
    assert np.allclose(found.pressure_gradient[:, 0], -1e5 * 0.05 / 0.4, rtol=1e-6)


def test_the_work_of_the_grains_is_the_sum_over_the_nodes_less_what_mobility_takes():
    """The coupler balances Σ ℓ (v·(s − βv) + j⁰·G): the fluid must have received exactly that."""
    driver, mesh = driver_of(boundaries={side: "slip" for side in ("left", "right", "top", "bottom")}, gravity=[0.0, 0.0])
    random = np.random.default_rng(2)
    count, mass = len(mesh["nodes"]), mesh["nodal_mass"]
    fields = random_response(count)
    # a source without net force on slip walls drives a flow; its work is the grains' power
    fields["drag_source"] = random.normal(0.0, 1e3, (count, 2))
    fields["solid_flux"] = random.normal(0.0, 1e-3, (count, 2))
    with driver:
        found = driver.advance(1e-2, **fields)
        v, gradient = found.interstitial_velocity, found.pressure_gradient
        pull = fields["drag_source"] - fields["drag"][:, None] * v
        nodal = mass @ (v * pull + fields["solid_flux"] * gradient).sum(axis=1)
        power = found.report["solid_power"]
        loss = nodal - power
        del fields["solid_mobility"]
        found = driver.advance(1e-2, **fields)
        v, gradient = found.interstitial_velocity, found.pressure_gradient
        pull = fields["drag_source"] - fields["drag"][:, None] * v
        without = mass @ (v * pull + fields["solid_flux"] * gradient).sum(axis=1) - found.report["solid_power"]
    print(f"\npower {power:.4e} W; taken by mobility {loss:.1e} W, without it {without:.1e} W")
    assert loss > 1e-6 * abs(power)  # ∫κ|∇p|²
    assert abs(without) < 1e-12 * abs(power)


def test_a_repeated_advance_and_a_checkpoint_give_the_same_bits(tmp_path):
    def stir(driver, count):
        fields = at_rest(random_response(count))
        fields["drag_source"] = fields["drag_source"] + 50.0
        return driver.advance(0.05, **fields)

    driver, mesh = driver_of()
    with driver:
        stir(driver, len(mesh["nodes"]))
        driver.commit()
        driver.save(tmp_path / "state")
        first, again = (stir(driver, len(mesh["nodes"])) for _ in range(2))
    other, _ = driver_of()
    with other:
        other.restore(tmp_path / "state")
        restored = stir(other, len(mesh["nodes"]))
    for name in first:
        assert (first[name] == again[name]).all() and (first[name] == restored[name]).all()


def test_the_velocity_that_grains_feel_converges_with_second_order():
    """Stokes flow in a box driven by a smooth force, against a fine mesh."""
    print("\n| cells | error | order |")

    def centre(cells):
        driver, mesh = driver_of(cells=[cells, cells], convection=False, density=1.0, gravity=[0.0, 0.0])
        x, y = mesh["nodes"].T
        force = np.column_stack([np.sin(2 * np.pi * x) * np.sin(np.pi * y), np.cos(np.pi * y) * x])
        with driver:
            found = driver.advance(1e6, drag_source=force)
        near = np.abs(mesh["nodes"] - 0.5).max(axis=1) < 0.26
        keep = near & np.isclose((mesh["nodes"] * 8) % 1.0, 0.0).all(axis=1)
        return found.interstitial_velocity[keep]

    fine, errors = centre(64), []
    for cells in (8, 16, 32):
        errors.append(np.abs(centre(cells) - fine).max())
        order = np.log2(errors[-2] / errors[-1]) if len(errors) > 1 else float("nan")
        print(f"| {cells} | {errors[-1]:.3e} | {order:.2f} |")
    # what grains feel are averages: second order
    assert np.log2(errors[0] / errors[1]) > 1.7 and np.log2(errors[1] / errors[2]) > 1.7


@pytest.mark.parametrize(
    "change, text",
    [
        ({"time_scheme": "bdf2"}, "time_scheme.*bdf2"),
        ({"mesh": {"file": {"path": "a.msh"}}}, "rectangle"),
        ({"boundaries": {"left": "periodic", "right": "periodic", "top": "slip", "bottom": "slip"}}, "left is periodic"),
        ({"nonlinear": {"newton": {"tolerance": 1e-6, "iterations_max": 9}}}, "nonlinear"),
    ],
)
def test_what_cannot_be_done_is_refused_with_its_key(change, text):
    driver = FluidDriver(load("skfem-fluid").SkfemFluid())
    with driver, pytest.raises(sillage.SceneError, match=text):
        driver.configure(fluid_scene(**change))
