"""The same classes in space: shapes of fields, meshes of tetrahedra, spins that are vectors."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

import sillage
from sillage.testing import FluidDriver, ParticleDriver, fluid_scene, particle_scene
from test_views import Falling

STREAM = Path(__file__).resolve().parents[1] / "examples/stream.py"


def stream(velocity):
    """The example, which serves both dimensions."""
    found = importlib.util.spec_from_file_location("stream", STREAM)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module.Stream(velocity)


def spheres(count=5, radius=0.1):
    volume = np.full(count, 4 / 3 * math.pi * radius**3)
    position = np.arange(3.0 * count).reshape(-1, 3)
    return sillage.Grains(position, 0.0 * position, np.full(count, radius), 2500.0 * volume, volume, np.zeros(count, bool))


def test_grains_of_space_have_vectors_of_three_and_spins_too():
    seen = {}

    def look(engine, inputs, outputs):
        seen["force"], seen["spin"] = inputs.grain_force.shape, outputs.grain_spin.shape
        seen["missing"] = inputs.grain_drag.shape
        outputs.grain_spin[:] = [1.0, 2.0, 3.0]

    engine = Falling(look)
    engine.capabilities = ("spin",)
    with ParticleDriver(engine) as driver:
        assert driver.configure(particle_scene(3), spheres()) == 5
        found = driver.advance(0.1, grain_force=np.tile([1.0, 2.0, -4.0], (5, 1)))
        driver.commit()
    mass = spheres().mass[0]
    print(f"\n{seen}, velocity {found.grain_velocity[0]}")
    assert seen == {"force": (5, 3), "spin": (5, 3), "missing": (5,)}
    assert np.allclose(found.grain_velocity, [0.1 / mass, 0.2 / mass - 0.981, -0.4 / mass], rtol=1e-14)
    assert (found.grain_spin == [1.0, 2.0, 3.0]).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_fluid_of_one_source_gives_triangles_or_tetrahedra(dimension):
    with FluidDriver(stream([0.3, -0.1, 0.2])) as driver:
        scene = fluid_scene(dimension)
        ((_, part),) = scene["mesh"].items()
        part["cells"] = [2, 3, 4][:dimension]
        mesh = driver.configure(scene)
        found = driver.advance(0.1)
        driver.commit()
    corners = mesh["nodes"][mesh["simplices"]]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]) / math.factorial(dimension)
    print(f"\n{len(volume)} simplices of {volume.sum():.15f} together, nodes {mesh['nodal_mass'].sum():.15f}")
    assert len(volume) == math.factorial(dimension) * np.prod(part["cells"]) and (volume > 0.0).all()
    assert abs(volume.sum() - 1.0) < 1e-14 and abs(mesh["nodal_mass"].sum() - 1.0) < 1e-14
    assert found.interstitial_velocity.shape == (len(mesh["nodes"]), dimension)
    assert np.allclose(found.pressure, -9810.0 * mesh["nodes"][:, 1])


def test_a_tetrahedron_that_is_turned_is_refused():
    corners = np.vstack([np.zeros(3), np.eye(3)])
    assert np.allclose(sillage.Mesh(corners, [[0, 1, 2, 3]]).nodal_mass, 1 / 24)
    with pytest.raises(ValueError, match=r"simplex 0 has measure -1.667e-01 m\^3"):
        sillage.Mesh(corners, [[0, 2, 1, 3]])
    with pytest.raises(ValueError, match="must be n × 4"):
        sillage.Mesh(corners, [[0, 1, 2]])
