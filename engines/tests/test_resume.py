"""A run with an engine in Python that was stopped goes on to the bit as one that was not."""

import csv
import os
import shutil
import subprocess

import pytest
from conftest import ENGINES, load

SILLAGE = ENGINES.parent / os.environ.get("CARGO_TARGET_DIR", "target") / "release" / "sillage"


def sillage(*words):
    done = subprocess.run([SILLAGE, *words], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


def physics(folder):
    """steps.csv without what a run costs."""
    with (folder / "steps.csv").open() as table:
        rows = list(csv.reader(table))
    kept = [k for k, name in enumerate(rows[0]) if not name.startswith(("cpu_", "wall_"))]
    return [[row[k] for k in kept] for row in rows]


@pytest.mark.parametrize("name", ["lammps-particles", "scontact-particles", "skfem-fluid"])
def test_a_resumed_run_has_the_bits_of_one_that_was_not_stopped(name, tmp_path):
    if not SILLAGE.exists():
        pytest.skip("the programs are not built: cargo build --release --workspace")
    load(name)
    scene = ENGINES / name / "scene.toml"
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    settings = ["run.end_time=0.033", "output.frames=false", "checkpoint.every_steps=3"]
    sillage("run", scene, "--out", whole, *(word for key in settings for word in ("--set", key)))
    shutil.copytree(whole, halves)
    sillage("resume", halves, "--from", "3")
    assert len(physics(whole)) == 7
    assert physics(halves) == physics(whole)


def test_a_mesh_of_python_follows_the_grains_and_goes_on_to_the_bit(tmp_path):
    if not SILLAGE.exists():
        pytest.skip("the programs are not built: cargo build --release --workspace")
    load("skfem-fluid")
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    settings = [
        "run.end_time=0.11",
        "fluid.domain.rectangle.cells=[8, 12]",
        "fluid.refinement.near_grains=1.2e-3",
        "fluid.refinement.margin=4e-4",
        "output.frames=false",
        "checkpoint.every_steps=10",
    ]
    words = [word for key in settings for word in ("--set", key)]
    sillage("run", ENGINES / "skfem-fluid" / "scene.toml", "--out", whole, *words)
    shutil.copytree(whole, halves)
    sillage("resume", halves, "--from", "10")
    rows = physics(whole)
    epoch, nodes, defect = (rows[0].index(name) for name in ("epoch", "nodes", "volume_defect"))
    print(f"\nepochs {rows[1][epoch]} to {rows[-1][epoch]}, nodes {rows[1][nodes]} to {rows[-1][nodes]}")
    assert int(rows[-1][epoch]) > int(rows[1][epoch])
    assert max(abs(float(row[defect])) for row in rows[1:]) < 1e-6
    assert physics(halves) == rows
