"""Sillage and MigFlow 1.4 on the same grains, nodes and step: CPU time of a step (README.md).

    python equal.py                 all rows, three runs each of both programs in turn
    python equal.py --only 1000     rows with so many grains

The drop of `scenes/migflow-drop.toml` with more grains of the same sizes in a larger cloud and box, from rest, cells of one
size, one thread. MigFlow as its authors ship it (PARDISO refactors, contacts in sub-steps by the speed of grains) and at
its best (factors of an earlier step precondition CGS, contacts once a step to 0.1 r). Sillage with one pass a step,
which is what MigFlow does.
"""

import argparse
import csv
import json
import math
import random
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from compare import ROOT, SILLAGE, TUNED, measured

HERE = Path(__file__).resolve().parent
#: Grains, cells across and along, step [s], steps.
ROWS = [
    (1000, (58, 87), 2e-3, 100),
    (1000, (58, 87), 1e-2, 20),
    (10000, (82, 123), 5e-4, 10),
    (10000, (163, 245), 5e-4, 10),
    (100000, (163, 245), 1e-4, 10),
]
SMALLEST, LARGEST = 12.5e-6, 25e-6  # radii [m]
CLOUD = 1.352786e-3  # radius of a cloud of 1000 grains [m]


def cloud(grains):
    """Radius of the cloud, and x, y, radius of grains in it: on a jittered triangular lattice, a fifth of the area."""
    chance = random.Random(grains)
    big = CLOUD * math.sqrt(grains / 1000)
    pitch = math.sqrt(math.pi * big**2 / grains * 2 / math.sqrt(3))
    centre, places = (0.0, 20 * big), []
    count = int(2 * big / pitch) + 3
    for i in range(-count, count):
        for j in range(-count, count):
            x, y = pitch * (i + 0.5 * (j % 2)), pitch * j * math.sqrt(3) / 2
            places.append((math.hypot(x, y), x, y))
    room = 0.5 * pitch - LARGEST
    rows = []
    for _, x, y in sorted(places)[:grains]:
        way, turn = room * chance.random(), 2 * math.pi * chance.random()
        radius = SMALLEST + (LARGEST - SMALLEST) * chance.random()
        rows.append((centre[0] + x + way * math.cos(turn), centre[1] + y + way * math.sin(turn), radius))
    return big, rows


def sillage_run(row, big, grains, folder, more):
    """A run with one pass a step: CPU time of everything [s], and its `cost`."""
    _, cells, step, steps = row
    settings = {
        "run.end_time": step * steps, "run.coupling_step": step, "grains[0].file": json.dumps(str(grains)),
        "output.every": step * steps, "output.frames": "false", "coupling.scheme": '"staggered"',
        "fluid.domain.rectangle.lower": [-8 * big, 0.0], "fluid.domain.rectangle.upper": [8 * big, 24 * big],
        "fluid.domain.rectangle.cells": list(cells), "fluid.time_scheme": '"backward-euler"', **more,
    }
    sets = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    scene = ROOT / "scenes/migflow-drop.toml"
    command = [SILLAGE, "run", scene, "--threads", "1", *sets, "--out", folder / "run"]
    with open(folder / "log", "w") as log:
        cpu, code = measured(command, log)
    if code != 0:
        sys.exit((folder / "log").read_text()[-2000:])
    return cpu, json.load(open(folder / "run/run.json"))["cost"]


def sillage(row, big, grains, folder, more):
    cpu, cost = sillage_run(row, big, grains, folder, more)
    return cpu, sum(cost["cpu_" + part] for part in ("fluid", "particles", "coupler")) / row[3]


def write_grains(rows, file):
    """As `grains.file` takes them."""
    with open(file, "w", newline="") as out:
        csv.writer(out).writerows([("x [m]", "y [m]", "radius [m]"), *rows])


def migflow(row, big, grains, folder, options):
    _, cells, step, steps = row
    job = {"grains": str(grains), "big": big, "cells": cells, "step": step, "steps": steps, **options}
    (folder / "job.json").write_text(json.dumps(job))
    command = [sys.executable, HERE / "equal.py", "--job", folder / "job.json"]
    with open(folder / "log", "w") as log:
        cpu, code = measured(command, log)
    if code != 0:
        sys.exit((folder / "log").read_text()[-2000:])
    return cpu, json.load(open(folder / "job.json.out"))["cpu_steps"] / steps


def one_of_migflow(path):
    """The run of a job in this process."""
    import types

    import cloud as drop
    import numpy as np

    job = json.load(open(path))
    big = job["big"]
    drop.LOWER, drop.UPPER = np.array([-8 * big, 0.0]), np.array([8 * big, 24 * big])
    drop.PATH = np.array([drop.LOWER, drop.UPPER])
    drop.Pardiso.changed = {int(key): value for key, value in job["pardiso"].items()}
    position, radius = drop.read_grains(job["grains"])
    # Gmsh's triangles are a little smaller than half a cell of this size
    near = 16 * big / job["cells"][0] * 1.075
    options = types.SimpleNamespace(
        near=near, growth=0.3, largest=near, mesh="uniform", margin=0.5, steps=job["steps"],
        end=job["step"] * job["steps"], contact=job["contact"], p2p1=False, mean_pressure=job["mean_pressure"],
    )
    problem, _, _, cpu = drop.run(options, drop.particles(position, radius), radius)
    assert np.isfinite(problem.solution()).all()
    Path(str(path) + ".out").write_text(json.dumps({"cpu_steps": cpu, "nodes": int(problem.n_nodes())}))


WAYS = {
    "Sillage": (sillage, {}),
    "MigFlow at its best": (migflow, {"pardiso": TUNED, "contact": "once", "mean_pressure": False}),
    "MigFlow as shipped": (migflow, {"pardiso": {}, "contact": "sub-steps", "mean_pressure": True}),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", type=int, help="rows with so many grains")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--job", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.job:
        return one_of_migflow(options.job)
    print("| grains | nodes | step | way | CPU of a step | as much as Sillage | whole process |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for row in ROWS:
        if options.only not in (None, row[0]):
            continue
        found = {way: [] for way in WAYS}
        with tempfile.TemporaryDirectory() as scratch:
            grains = Path(scratch) / "grains.csv"
            big, rows = cloud(row[0])
            write_grains(rows, grains)
            plain = Path(scratch) / "plain.csv"
            plain.write_text(grains.read_text().replace(" [m]", ""))
            for _ in range(options.repeats):
                for way, (run, more) in WAYS.items():
                    with tempfile.TemporaryDirectory(dir=scratch) as folder:
                        file = grains if run is sillage else plain
                        found[way].append(run(row, big, file, Path(folder), more))
        least = statistics.median(step for _, step in found["Sillage"])
        for way, runs in found.items():
            whole, step = (statistics.median(run[k] for run in runs) for k in (0, 1))
            nodes = (row[1][0] + 1) * (row[1][1] + 1)
            print(f"| {row[0]} | {nodes} | {row[2]:g} s | {way} | {1e3 * step:.1f} ms | {step / least:.2f} | {whole:.1f} s |",
                  flush=True)


if __name__ == "__main__":
    main()
