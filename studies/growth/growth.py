"""CPU time of a step against the number of grains and of nodes (README.md): tables, and a picture of both.

    python growth.py --picture ../../docs/pictures/growth.png

The drop of `scenes/migflow-drop.toml`, one pass a step, one thread, from rest, a few steps each: grains on 9801 nodes,
then nodes with 1000 grains.
"""

import argparse
import math
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "migflow"))
from equal import cloud, sillage_run, write_grains  # noqa: E402

GRAINS = [1000, 3000, 10000, 30000, 100000, 300000, 1000000]
CELLS = [(40, 60), (57, 86), (80, 120), (114, 171), (161, 242), (228, 342)]
STEPS = 4


def step(grains, cells):
    """CPU time of a step of each process [s]: all steps but the first."""
    big, rows = cloud(grains)
    spent = []
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "grains.csv"
        write_grains(rows, file)
        for steps in (1, 1 + STEPS):
            folder = Path(scratch) / str(steps)
            folder.mkdir()
            row = (grains, cells, 1e-4, steps)
            _, cost = sillage_run(row, big, file, folder, {"output.every": 1.0})
            spent.append({part: cost["cpu_" + part] for part in ("fluid", "particles", "coupler")})
    return {part: (spent[1][part] - spent[0][part]) / STEPS for part in spent[0]}


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
