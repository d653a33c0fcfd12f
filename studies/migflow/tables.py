"""Errors, tables and the picture of `cloud.csv`."""

import csv
import itertools
import math
import statistics

GOOD = 0.01
#: Grains that overlap less than this part of a radius are held apart.
HELD = 1e-2
#: What is held to 1 %: the mean position; the mean position and the front.
ERRORS = {"error": "mean position", "both": "mean position and front"}
NAMES = {"sillage": "Sillage", "migflow": "MigFlow"}


def read(path):
    """Lines of the data, without those that say where they come from."""
    with open(path) as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def points(rows):
    """One dictionary a point: medians of what was timed, the rest of the first run."""
    groups = {}
    for row in rows:
        groups.setdefault((row["program"], row["point"]), []).append(row)
    found = []
    for group in groups.values():
        texts = ("program", "version", "point", "mesh", "scheme", "date")
        point = {key: value if key in texts else float(value) for key, value in group[0].items()}
        for column in ("cpu", "cpu_steps"):
            point[column] = statistics.median(float(row[column]) for row in group)
        point["repeats"] = len(group)
        found.append(point)
    return found


def with_errors(found, finest):
    """Errors against the program's own finest run: of the mean position, over the fall, of front and width."""
    for point in found:
        truth = finest[point["program"]]
        apart = math.hypot(point["fall"] - truth["fall"], point["x"] - truth["x"])
        point["error"] = apart / truth["fall"]
        point["sign"] = math.copysign(1.0, point["fall"] - truth["fall"])
        point["front_error"] = point["front"] / truth["front"] - 1.0
        point["both"] = max(point["error"], abs(point["front_error"]))
        point["width_error"] = point["width"] / truth["width"] - 1.0
        point["finest"] = point is truth
    for point in found:
        as_fine = [other for other in found if finer(other, point)]
        point["holds"] = {of: all(other[of] <= GOOD for other in as_fine) for of in ERRORS}
    return found


def finer(one, other):
    """Is a point as fine as another of its kind, in mesh and step? Errors that only offset each other fail then."""
    same = all(one[key] == other[key] for key in ("program", "mesh", "scheme"))
    return same and one["cell"] >= other["cell"] and one["steps"] >= other["steps"]


def rows_of(found):
    for point in sorted(found, key=lambda point: (point["program"], point["cpu"])):
        error = "finest" if point["finest"] else f"{100 * point['sign'] * point['error']:+.2f} %"
        good = ["", "mean", "mean, front"][0 if point["finest"] else sum(point["holds"].values())]
        yield (
            f"| {NAMES[point['program']]} | {point['point']} | {point['nodes']:.0f} | {point['cpu']:.2f} |"
            f" {point['cpu_steps']:.2f} | {point['fall']:.3f} | {error} | {100 * point['front_error']:+.2f} % |"
            f" {100 * point['width_error']:+.2f} % | {point['overlap']:.2g} | {good} |"
        )


def cheapest(found, program, of, column, held):
    """The point of a program that costs least among those within 1 % (and whose grains do not overlap)."""
    good = [
        point for point in found
        if point["program"] == program and point["holds"][of] and not point["finest"]
        and (point["overlap"] < HELD or not held)
    ]
    return min(good, key=lambda point: point[column], default=None)


def ratios(found):
    """Least CPU at 1 % of each program, of the whole process and of the steps alone."""
    yield "| at 1 % of | overlaps | CPU of | MigFlow | Sillage | MigFlow / Sillage |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for of, held, column in itertools.product(ERRORS, (False, True), ("cpu", "cpu_steps")):
        ours, theirs = (cheapest(found, program, of, column, held) for program in ("sillage", "migflow"))
        if ours and theirs:
            costs = [f"{point[column]:.2f} s ({', '.join(point['point'].split(', ')[:2])})" for point in (theirs, ours)]
            what = {"cpu": "the process", "cpu_steps": "the steps"}[column]
            limit = f"< {HELD:g} r" if held else "any"
            ratio = theirs[column] / ours[column]
            yield f"| {ERRORS[of]} | {limit} | {what} | {costs[0]} | {costs[1]} | {ratio:.2f} |"


def show(data, finest, picture):
    found = points(read(data))
    truths = {
        point["program"]: point for point in found if (point["program"], point["point"]) in finest
    }
    found = with_errors(found, truths)
    heads = ["program", "cell, step, mesh, scheme", "nodes", "CPU (s)", "of it steps (s)", "fall / R", "mean position"]
    heads += ["front", "width", "overlap / r", "within 1 %"]
    print("| " + " | ".join(heads) + " |\n" + "| --- " * len(heads) + "|")
    print("\n".join(rows_of(found)))
    print()
    print("\n".join(ratios(found)))
    if picture:
        draw(found, picture)


def draw(found, picture):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    for program, colour in (("migflow", "tab:orange"), ("sillage", "tab:blue")):
        for held, mark in ((False, "o"), (True, "s")):
            shown = [
                p for p in found
                if p["program"] == program and (p["overlap"] < HELD) == held and not p["finest"]
            ]
            label = f"{NAMES[program]}, grains {'held apart' if held else 'may overlap'}"
            fill = colour if held else "none"
            costs, errors = ([p[key] * factor for p in shown] for key, factor in (("cpu", 1), ("error", 100)))
            axes.loglog(costs, errors, mark, color=colour, markerfacecolor=fill, label=label)
    axes.axhline(100 * GOOD, color="grey", linewidth=0.8)
    axes.set_xlabel("CPU of the whole run (s)")
    axes.set_ylabel("mean position at t* = 60, error (%)")
    axes.set_xlim(1.0, 50.0)
    axes.set_ylim(0.1, 2.0)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")
    axes.legend(loc="lower right")
    figure.savefig(picture, dpi=120)
