"""CPU time of a step against the number of grains and of nodes (README.md): tables, and a picture of both.

    python growth.py --picture ../../docs/pictures/growth.png

The drop of `scenes/migflow-drop.toml`, one pass a step, one thread, from rest, a few steps each: grains on 9801 nodes,
then nodes with 1000 grains.
"""

import argparse
import csv
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE.parent / "migflow"))
from equal import cloud  # noqa: E402

SILLAGE = ROOT / "target/release/sillage"
GRAINS = [1000, 3000, 10000, 30000, 100000, 300000, 1000000]
CELLS = [(40, 60), (57, 86), (80, 120), (114, 171), (161, 242), (228, 342)]
STEPS = 4


def step(grains, cells):
    """CPU time of a step of each process [s]: all steps but the first."""
    big, rows = cloud(grains)
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "grains.csv"
        with open(file, "w", newline="") as out:
            csv.writer(out).writerows([("x [m]", "y [m]", "radius [m]"), *rows])
        spent = [cost(file, big, cells, steps, Path(scratch) / str(steps)) for steps in (1, 1 + STEPS)]
    return {part: (spent[1][part] - spent[0][part]) / STEPS for part in spent[0]}


def cost(file, big, cells, steps, out):
    dt = 1e-4
    settings = {
        "run.end_time": dt * steps, "run.coupling_step": dt, "grains[0].file": json.dumps(str(file)),
        "output.every": 10 * dt * steps, "output.frames": "false", "coupling.scheme": '"staggered"',
        "fluid.domain.rectangle.lower": [-8 * big, 0.0], "fluid.domain.rectangle.upper": [8 * big, 24 * big],
        "fluid.domain.rectangle.cells": list(cells), "fluid.time_scheme": '"backward-euler"',
    }
    sets = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    command = [SILLAGE, "run", ROOT / "scenes/migflow-drop.toml", "--threads", "1", *sets, "--out", out]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    found = json.load(open(out / "run.json"))["cost"]
    return {part: found["cpu_" + part] for part in ("fluid", "particles", "coupler")}


def table(what, counts, costs):
    """A table, and how costs grow from one row to the next."""
    print(f"| {what} | fluid | grains' engine | coupler | all | grows as n to the |")
    print("| --- | --- | --- | --- | --- | --- |")
    last = None
    for count, found in zip(counts, costs):
        total = sum(found.values())
        power = "" if last is None else f"{math.log(total / last[1]) / math.log(count / last[0]):.2f}"
        parts = " | ".join(f"{1e3 * found[part]:.1f}" for part in ("fluid", "particles", "coupler"))
        print(f"| {count} | {parts} | {1e3 * total:.1f} ms | {power} |", flush=True)
        last = count, total


def draw(path, axes):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullFormatter

    figure, panels = plt.subplots(1, 2, figsize=(9, 3.8))
    for panel, (what, counts, costs) in zip(panels, axes):
        for part in ("fluid", "particles", "coupler"):
            panel.loglog(counts, [1e3 * max(found[part], 1e-5) for found in costs], "o-", label=part)
        panel.set_xlabel(what)
        panel.set_ylabel("CPU of a step [ms]")
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.grid(alpha=0.3)
        panel.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--picture", type=Path, help="where the picture goes")
    parser.add_argument("--most", type=int, default=GRAINS[-1], help="no more grains than this")
    options = parser.parse_args()
    counts = [count for count in GRAINS if count <= options.most]
    grains = [step(count, (80, 120)) for count in counts]
    table("grains, 9801 nodes", counts, grains)
    print()
    nodes = [(x + 1) * (y + 1) for x, y in CELLS]
    meshes = [step(1000, cells) for cells in CELLS]
    table("nodes, 1000 grains", nodes, meshes)
    if options.picture:
        draw(options.picture, [("grains", counts, grains), ("nodes", nodes, meshes)])


if __name__ == "__main__":
    main()
