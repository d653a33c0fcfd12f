"""Particle engines against closed forms, and the rules of the protocol."""

import numpy as np
import pytest
from conftest import load

import sillage
from sillage.testing import ParticleDriver, particle_scene

G = 9.81


def scontact(_tmp):
    return load("scontact-particles").Scontact()


def smooth(_tmp):
    return load("lammps-particles").Lammps(overlap=0.02, speed=1.0)


BOTH = pytest.mark.parametrize("make", [scontact, smooth])


def disks(position, radius=0.005, velocity=None, fixed=None):
    position = np.array(position, float)
    count = len(position)
    area = np.full(count, np.pi * radius**2)
    velocity = np.zeros((count, 2)) if velocity is None else np.array(velocity, float)
    fixed = np.zeros(count, bool) if fixed is None else np.array(fixed)
    return sillage.Grains(position, velocity, np.full(count, radius), 2500.0 * area, area, fixed)


def wall(ax, ay, bx, by):
    return {"corners": [[ax, ay], [bx, by]]}


def box(width, height):
    corners = [(0, 0), (width, 0), (width, height), (0, height)]
    return [wall(*corners[k], *corners[(k + 1) % 4]) for k in range(4)]


def scene(**changes):
    return particle_scene(sub_steps_max=10**6) | changes


@BOTH
def test_a_free_grain_falls_as_its_drag_allows(make, tmp_path):
    print("\n| drag Δt/m | speed / exact backward Euler of the sub-steps |")
    grains = disks([[0.0, 0.0]])
    mass = grains.mass[0]
    for follow in (0.0, 0.1, 1.0, 10.0):
        with ParticleDriver(make(tmp_path)) as driver:
            driver.configure(scene(), disks([[0.0, 0.0]]))
            dt, drag = 1e-2, follow * mass / 1e-2
            speed = 0.0
            for _ in range(3):
                found = driver.advance(dt, grain_drag=[drag], grain_force=[[mass, 0.0]])
                driver.commit()
                count = int(found.report["sub_steps"])
                delta = dt / count
                for _ in range(count):
                    speed = (mass * speed - delta * mass * G) / (mass + delta * drag)
            ratio = found.grain_velocity[0, 1] / speed
            print(f"| {follow} | {ratio - 1.0:+.2e} ({count} sub-steps) |")
            assert abs(ratio - 1.0) < (1e-12 if make is scontact else 0.02)


def test_a_pressed_pair_moves_as_one_with_its_whole_drag(tmp_path):
    """Two grains pressed together: v = (f₁ + f₂)/(γ₁ + γ₂) at rest, whatever the drag (scontact)."""
    print("\n| drag | v / exact |")
    for drag in ([1e2, 1.0], [1e4, 10.0], [1e6, 1e3]):
        grains = disks([[0.0, 0.0], [0.01, 0.0]])
        with ParticleDriver(scontact(tmp_path)) as driver:
            driver.configure(scene(gravity=[0.0, 0.0]), grains)
            for _ in range(40):
                found = driver.advance(1e-2, sub_steps=1, grain_drag=drag, grain_force=[[30.0, 0.0], [-10.0, 0.0]])
                driver.commit()
        exact = 20.0 / sum(drag)
        print(f"| {drag} | {found.grain_velocity[:, 0] / exact} |")
        assert np.allclose(found.grain_velocity[:, 0], exact, rtol=1e-6)
        assert (found.grain_contact == 1.0).all()


@BOTH
def test_a_disk_rolls_down_a_slope(make, tmp_path):
    angle = np.radians(30.0)
    gravity = [G * np.sin(angle), -G * np.cos(angle)]
    walls = [wall(-1.0, 0.0, 3.0, 0.0)]
    with ParticleDriver(make(tmp_path)) as driver:
        driver.configure(scene(gravity=gravity, friction=0.3, wall_friction=0.3, walls=walls), disks([[0.0, 0.005]]))
        for _ in range(40):
            found = driver.advance(1e-2)
            driver.commit()
    ratio = found.grain_velocity[0, 0] / (2.0 / 3.0 * G * np.sin(angle) * 0.4)
    print(f"\nrolling speed / exact: {ratio:.6f}")
    assert abs(ratio - 1.0) < 1e-3


def settled(make, tmp_path, steps=60):
    """A small heap of grains in a box, with the driver that runs it."""
    places = [[0.006 + 0.0105 * (k % 5) + 4e-4 * (k // 5 % 2), 0.0055 + 0.0105 * (k // 5)] for k in range(20)]
    driver = ParticleDriver(make(tmp_path))
    driver.configure(scene(friction=0.3, wall_friction=0.3, walls=box(0.056, 0.2)), disks(places))
    found = None
    for _ in range(steps):
        found = driver.advance(2e-3)
        driver.commit()
    return driver, found


@BOTH
def test_a_repeated_advance_gives_the_same_bits(make, tmp_path):
    driver, _ = settled(make, tmp_path, 30)
    with driver:
        first = driver.advance(2e-3)
        driver.advance(1e-3, grain_drag=np.full(20, 3.0))
        again = driver.advance(2e-3)
        assert all((first[name] == again[name]).all() for name in first)


@BOTH
def test_a_small_step_after_a_large_one_has_the_bits_of_a_fresh_process(make, tmp_path):
    driver, _ = settled(make, tmp_path, 30)
    with driver:
        driver.save(tmp_path / "state")
        for dt, drag in ((8e-3, 0.0), (2e-3, 30.0)):
            driver.advance(dt, grain_drag=np.full(20, drag))
        after = driver.advance(5e-4)
    other, _ = settled(make, tmp_path, 0)
    with other:
        other.restore(tmp_path / "state")
        expected = other.advance(5e-4)
    assert (expected.grain_contact > 0.0).sum() >= 10
    assert all((after[name] == expected[name]).all() for name in expected)


@BOTH
def test_a_checkpoint_brings_back_the_same_bits(make, tmp_path):
    driver, _ = settled(make, tmp_path, 30)
    with driver:
        driver.save(tmp_path / "state")
        for _ in range(5):
            expected = driver.advance(2e-3)
            driver.commit()
    # another process of the same engine
    places = np.random.default_rng(0).uniform(0.01, 0.05, (20, 2)) * [1.0, 3.0]
    with ParticleDriver(make(tmp_path)) as other:
        other.configure(scene(friction=0.3, wall_friction=0.3, walls=box(0.056, 0.2)), disks(places))
        other.restore(tmp_path / "state")
        for _ in range(5):
            found = other.advance(2e-3)
            other.commit()
    assert all((found[name] == expected[name]).all() for name in found)


@BOTH
def test_grains_come_to_rest_in_a_box_without_passing_through(make, tmp_path):
    driver, found = settled(make, tmp_path)
    with driver:
        pass
    position, depth = found.grain_position, found.diagnostics["penetration_max"]
    low = (position - 0.005).min()
    print(f"\ndeepest overlap {depth:.1e} r, deepest in a wall {-low / 0.005:.1e} r")
    assert depth < (1e-3 if make is scontact else 2e-2)
    assert low > -1e-4
    assert np.abs(found.grain_velocity).max() < 0.1
    if make is scontact:
        assert (found.grain_contact == 2.0).sum() >= 15


@BOTH
def test_fixed_grains_stay_and_hold(make, tmp_path):
    grains = disks([[0.0, 0.0], [0.0, 0.0102]], fixed=[True, False])
    with ParticleDriver(make(tmp_path)) as driver:
        driver.configure(scene(), grains)
        for _ in range(30):
            found = driver.advance(2e-3)
            driver.commit()
    assert (found.grain_position[0] == 0.0).all()
    assert abs(found.grain_position[1, 1] - 0.01) < 1e-4
    if make is scontact:
        assert (found.grain_contact == 2.0).all()


@BOTH
def test_what_cannot_be_done_is_refused_with_the_reason(make, tmp_path):
    grains = disks([[0.0, 0.0]])
    if make is scontact:
        refused = {"period": [1.0, None]}, "periodic"
    else:
        refused = {"walls": [wall(0.0, 0.0, 1.0, 1.0)]}, "inclined"
    with ParticleDriver(make(tmp_path)) as driver:
        with pytest.raises(sillage.SceneError, match=refused[1]):
            driver.configure(scene(**refused[0]), grains)
    with ParticleDriver(make(tmp_path)) as driver:
        driver.configure(scene(sub_steps_max=1, gravity=[0.0, -1e4]), disks([[0.0, 0.0], [0.1, 0.0]], velocity=[[9, 0], [-9, 0]]))
        with pytest.raises(sillage.NotConverged, match="sub_steps_max"):
            driver.advance(1e-2)


def test_lammps_counts_positions_across_a_period(tmp_path):
    with ParticleDriver(smooth(tmp_path)) as driver:
        grains = disks([[0.05, 0.0], [-0.35, 0.05]], velocity=[[1.0, 0.0], [-2.0, 0.0]])
        driver.configure(scene(gravity=[0.0, 0.0], period=[0.1, None]), grains)
        for _ in range(20):
            found = driver.advance(1e-2)
            driver.commit()
        assert np.allclose(found.grain_position, [[0.25, 0.0], [-0.75, 0.05]])
        assert np.allclose(found.grain_mean_velocity[:, 0], [1.0, -2.0])


def test_lammps_remembers_friction_from_one_advance_to_the_next(tmp_path):
    """A grain wedged between two fixed ones leans on friction: where it rests depends on its history."""
    places = []
    for parts in (1, 10, 100):
        engine = smooth(tmp_path)
        with ParticleDriver(engine) as driver:
            grains = disks([[-0.005, 0.0], [0.005, 0.0], [0.0, 0.00866]], fixed=[True, True, False])
            driver.configure(scene(friction=0.5, gravity=[3.0, -G]), grains)
            dt = 26700 * engine.contact_step * (1.0 - 1e-9)  # the same sub-step in all
            for _ in range(parts):
                found = driver.advance(dt / parts)
                driver.commit()
        places.append(found.grain_position[2])
    apart = np.abs(np.array(places) - places[0]).max() / 0.005
    print(f"\nlargest difference {apart:.1e} r")
    assert apart < 1e-12
