"""What a run puts out is opened by PyVista (VTK), and says what the run says."""

import math
import os
import subprocess

import numpy as np
import pytest
from conftest import ENGINES

pyvista = pytest.importorskip("pyvista", reason="PyVista is not set up: engines/set-up")

ROOT = ENGINES.parent
SILLAGE = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "release" / "sillage"
pytestmark = pytest.mark.skipif(not SILLAGE.exists(), reason="sillage is not built: cargo build --release --workspace")

SPACE = ROOT / "orchestration/sillage/tests/engines/space.toml"
FLUID = {"interstitial_velocity [m/s]": 3, "pressure [Pa]": 1, "porosity": 1}
GRAINS = {
    "grain_radius [m]": 1,
    "grain_velocity [m/s]": 3,
    "grain_spin [rad/s]": 3,
    "grain_contact": 1,
    "grain_mass [kg]": 1,
    "grain_fixed": 1,
}


def states(folder, scene, *settings):
    """Times, and the states of fluid and grains at each."""
    words = ["run.end_time=0.02", "output.every=0.01", "output.frames=false", *settings]
    words = [word for setting in words for word in ("--set", setting)]
    done = subprocess.run([SILLAGE, "run", scene, "--out", folder / "out", *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = []
    for name in ("fluid", "grains"):
        reader = pyvista.get_reader(folder / "out" / f"{name}.pvd")
        found.append(reader.time_values)
        states = []
        for time in reader.time_values:
            reader.set_active_time_value(time)
            states.append(reader.read()[0])
        found.append(states)
    (times, fluid, again, grains) = found
    assert times == again
    return times, fluid, grains


def widths(grid):
    """Fields at the points and how many numbers each has."""
    values = {name: np.asarray(grid.point_data[name]) for name in grid.point_data}
    assert all(np.isfinite(numbers).all() and len(numbers) == grid.n_points for numbers in values.values())
    return {name: numbers.shape[1] if numbers.ndim == 2 else 1 for name, numbers in values.items()}


@pytest.mark.parametrize("refinement", [None, "fluid.refinement={ near_grains = 1.25e-3, margin = 1.25e-3 }"])
def test_tetrahedra_and_spheres_of_a_run_in_space_are_read(refinement, tmp_path):
    times, fluid, grains = states(tmp_path, SPACE, *([refinement] if refinement else []))
    assert np.allclose(times, [0.0, 0.01, 0.02])
    print("\ntime (s)  points  tetrahedra  volume / box − 1  solid in the fluid / spheres − 1  fastest (m/s)")
    for time, grid, spheres in zip(times, fluid, grains):
        assert widths(grid) == FLUID and widths(spheres) == GRAINS
        assert set(grid.celltypes) == {pyvista.CellType.TETRA} and set(spheres.celltypes) == {pyvista.CellType.VERTEX}
        volume = grid.compute_cell_sizes()["Volume"]
        box = 0.01 * 0.01 * 0.005
        radius = spheres["grain_radius [m]"]
        solid = box - float(grid.integrate_data()["porosity"][0])
        share = solid / (4 / 3 * math.pi * (radius**3).sum())
        speed = np.linalg.norm(grid["interstitial_velocity [m/s]"], axis=1)
        print(
            f"{time:8.3f}  {grid.n_points:6}  {grid.n_cells:10}  {volume.sum() / box - 1.0:16.1e}  "
            f"{share - 1.0:32.1e}  {speed.max():.3e}"
        )
        assert (volume > 0.0).all() and abs(volume.sum() / box - 1.0) < 1e-12
        assert np.allclose(grid.bounds, [0.0, 0.01, 0.0, 0.01, 0.0, 0.005]) and abs(share - 1.0) < 1e-9
        at_wall = np.isclose(grid.points[:, 1], 0.0) | np.isclose(grid.points[:, 2], 0.005)
        assert (speed[at_wall] == 0.0).all()
        density = spheres["grain_mass [kg]"] / (4 / 3 * math.pi * radius**3)
        assert spheres.n_points == 28 and np.allclose(density, 2500.0)
        # Spheres as they are drawn: within the box, but for what they overlap a wall.
        drawn = spheres.glyph(geom=pyvista.Sphere(), scale="grain_radius [m]", factor=2.0, orient=False)
        assert np.all(np.array(drawn.bounds[::2]) > -1e-5) and drawn.bounds[5] < 0.005 + 1e-5
    fixed = grains[0]["grain_fixed"] == 1.0
    assert fixed.sum() == 4 and (grains[-1].points[fixed] == grains[0].points[fixed]).all()
    assert speed.max() > 1e-4, "the spheres stir it"


def test_triangles_and_disks_of_a_run_in_the_plane_are_read(tmp_path):
    scene = ENGINES / "rapier-particles/scene.toml"
    _, fluid, grains = states(tmp_path, scene, 'engines.particles.command=["sillage-particles"]')
    for grid, disks in zip(fluid, grains):
        assert widths(grid) == FLUID and (grid.points[:, 2] == 0.0).all()
        assert set(grid.celltypes) == {pyvista.CellType.TRIANGLE}
        assert abs(grid.compute_cell_sizes()["Area"].sum() / 0.06**2 - 1.0) < 1e-12
        assert widths(disks)["grain_spin [rad/s]"] == 1 and disks.n_points == 171
