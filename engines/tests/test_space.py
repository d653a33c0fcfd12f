"""Engines in space: LAMMPS against closed forms and the rules of the protocol; who is of the plane says so."""

import os
import subprocess
import sys

import numpy as np
import pytest
from conftest import ENGINES, load

import sillage
from sillage.testing import FluidDriver, ParticleDriver, fluid_scene, particle_scene

G = 9.81
ROOT = ENGINES.parent
SILLAGE = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "release" / "sillage"
SPACE = ROOT / "orchestration/sillage/tests/engines/space.toml"


def smooth(speed=1.0):
    return load("lammps-particles").Lammps(overlap=0.02, speed=speed)


def spheres(position, radius=0.005, velocity=None, fixed=None):
    position = np.array(position, float)
    count = len(position)
    volume = np.full(count, 4 / 3 * np.pi * radius**3)
    velocity = np.zeros((count, 3)) if velocity is None else np.array(velocity, float)
    fixed = np.zeros(count, bool) if fixed is None else np.array(fixed)
    return sillage.Grains(position, velocity, np.full(count, radius), 2500.0 * volume, volume, fixed)


def rectangle(a, b, c, d):
    """Two triangles with the grains where a, b, c, d are seen clockwise."""
    return [{"corners": [list(map(float, corner)) for corner in corners]} for corners in ((a, b, c), (a, c, d))]


def box(width, height):
    """Walls of a box that is open above."""
    x, y, z = width, height, width
    sides = [
        [(0, 0, 0), (x, 0, 0), (x, 0, z), (0, 0, z)],
        [(0, 0, 0), (0, 0, z), (0, y, z), (0, y, 0)],
        [(x, 0, 0), (x, y, 0), (x, y, z), (x, 0, z)],
        [(0, 0, 0), (0, y, 0), (x, y, 0), (x, 0, 0)],
        [(0, 0, z), (x, 0, z), (x, y, z), (0, y, z)],
    ]
    for a, b, c, _ in np.array(sides, float):
        assert np.cross(c - a, b - a) @ (np.array([x / 2, y / 2, z / 2]) - a) > 0.0
    return [wall for side in sides for wall in rectangle(*side)]


def scene(**changes):
    return particle_scene(3, sub_steps_max=10**6) | changes


def test_a_sphere_falls_as_its_drag_allows():
    print("\n| drag Δt/m | speed / exact backward Euler of the sub-steps |")
    for follow in (0.0, 0.1, 1.0, 10.0):
        grains = spheres([[0.0, 0.0, 0.0]])
        mass, dt, speed = grains.mass[0], 1e-2, np.zeros(3)
        drag = follow * mass / dt
        push = np.array([mass, -mass * G, 2.0 * mass])
        with ParticleDriver(smooth()) as driver:
            driver.configure(scene(), grains)
            for _ in range(3):
                found = driver.advance(dt, grain_drag=[drag], grain_force=[[mass, 0.0, 2.0 * mass]])
                driver.commit()
                count = int(found.report["sub_steps"])
                for _ in range(count):
                    speed = (mass * speed + dt / count * push) / (mass + dt / count * drag)
        ratio = found.grain_velocity[0] / speed
        print(f"| {follow} | {ratio - 1.0} ({count} sub-steps) |")
        assert np.abs(ratio - 1.0).max() < 0.02


@pytest.mark.parametrize("friction, share", [(0.5, 5.0 / 7.0), (0.1, 1.0 - 0.1 / np.tan(np.radians(30.0)))])
def test_a_sphere_on_a_slope_rolls_or_slips_as_its_friction_says(friction, share):
    angle = np.radians(30.0)
    along = np.array([0.6, 0.0, 0.8])  # down the slope, along no axis
    gravity = G * (np.sin(angle) * along - np.cos(angle) * np.array([0.0, 1.0, 0.0]))
    floor = rectangle((-1, 0, -1), (3, 0, -1), (3, 0, 3), (-1, 0, 3))
    with ParticleDriver(smooth()) as driver:
        rough = {"friction": friction, "wall_friction": friction}
        driver.configure(scene(gravity=gravity.tolist(), walls=floor, **rough), spheres([[0.0, 0.005, 0.0]]))
        for _ in range(40):
            found = driver.advance(1e-2)
            driver.commit()
    velocity = found.grain_velocity[0]
    ratio = velocity @ along / (share * G * np.sin(angle) * 0.4)
    print(f"\nspeed / exact at friction {friction}: {ratio:.6f}")
    assert abs(ratio - 1.0) < 1e-2 and abs(velocity @ [0.8, 0.0, -0.6]) < 1e-6


def heap(steps):
    """Layers of three by three spheres in a box, with the driver that runs it."""
    places = [
        [0.0058 + 0.0108 * (k % 3) + 3e-4 * (k // 9 % 2), 0.0055 + 0.0105 * (k // 9), 0.0058 + 0.0108 * (k // 3 % 3)]
        for k in range(27)
    ]
    driver = ParticleDriver(smooth())
    driver.configure(scene(friction=0.3, wall_friction=0.3, walls=box(0.0345, 0.2)), spheres(places))
    found = None
    for _ in range(steps):
        found = driver.advance(2e-3)
        driver.commit()
    return driver, found


def test_spheres_come_to_rest_in_a_box_and_requests_have_the_same_bits(tmp_path):
    driver, found = heap(60)
    with driver:
        driver.save(tmp_path / "state")
        first = driver.advance(2e-3)
        driver.advance(1e-3, grain_drag=np.full(27, 3.0))
        again = driver.advance(2e-3)
    other, _ = heap(0)
    with other:
        other.restore(tmp_path / "state")
        restored = other.advance(2e-3)
    low, high = (found.grain_position - 0.005).min(), (found.grain_position[:, [0, 2]] + 0.005).max()
    depth = found.diagnostics["penetration_max"]
    print(f"\ndeepest overlap {depth:.1e} r, in a wall {max(-low, high - 0.0345) / 0.005:.1e} r")
    assert depth < 2e-2 and low > -1e-4 and high < 0.0345 + 1e-4
    assert np.abs(found.grain_velocity).max() < 0.1
    for name in first:
        assert (first[name] == again[name]).all() and (first[name] == restored[name]).all()


def test_positions_are_counted_across_a_period_of_depth():
    with ParticleDriver(smooth()) as driver:
        grains = spheres([[0.0, 0.0, 0.05], [0.0, 0.05, -0.35]], velocity=[[0.1, 0.0, 1.0], [0.0, 0.0, -2.0]])
        driver.configure(scene(gravity=[0.0] * 3, period=[None, None, 0.1]), grains)
        for _ in range(20):
            found = driver.advance(1e-2)
            driver.commit()
    assert np.allclose(found.grain_position, [[0.02, 0.0, 0.25], [0.0, 0.05, -0.75]])
    assert np.allclose(found.grain_mean_velocity[:, 2], [1.0, -2.0])


def test_an_inclined_triangle_is_refused():
    wall = {"corners": [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.5, 0.0]]}
    with ParticleDriver(smooth()) as driver:
        with pytest.raises(sillage.SceneError, match="inclined"):
            driver.configure(scene(walls=[wall]), spheres([[0.0, 1.0, 0.0]]))


def test_engines_of_the_plane_refuse_space_by_name_with_the_remedy():
    with ParticleDriver(load("scontact-particles").Scontact()) as driver:
        with pytest.raises(sillage.SceneError, match="scontact-particles is for two dimensions.*take sillage-particles"):
            driver.configure(scene(), spheres([[0.0, 0.0, 0.0]]))
    with FluidDriver(load("skfem-fluid").SkfemFluid()) as driver:
        with pytest.raises(sillage.SceneError, match="skfem-fluid is for two dimensions.*take sillage-fluid"):
            driver.configure(fluid_scene(3))


@pytest.mark.skipif(not SILLAGE.exists(), reason="the programs are not built: cargo build --release --workspace")
@pytest.mark.parametrize("seat, name", [("particles", "scontact-particles"), ("fluid", "skfem-fluid")])
def test_a_run_of_space_with_an_engine_of_the_plane_ends_with_exit_code_2(seat, name, tmp_path):
    load(name)
    command = f"engines.{seat}.command=[{str(ENGINES / 'run')!r}, {name!r}]"
    words = [SILLAGE, "run", SPACE, "--set", command, "--out", tmp_path / "out"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    print(done.stderr)
    assert done.returncode == 2 and f"{name} is for two dimensions" in done.stderr


@pytest.mark.skipif(not SILLAGE.exists(), reason="the programs are not built: cargo build --release --workspace")
def test_lammps_passes_every_check_in_space():
    load("lammps-particles")
    engine = [sys.executable, ENGINES / "lammps-particles/main.py", "--overlap", "0.05", "--speed", "0.02"]
    words = [SILLAGE, "conform", "--as", "particles", "--scene", SPACE, "--", *engine]
    done = subprocess.run(words, capture_output=True, text=True, timeout=600)
    print(done.stdout)
    assert done.returncode == 0 and " 0 failed" in done.stdout
