"""Errors, tables and the picture of `cloud.csv`."""

import csv
import math
import statistics

GOOD = 0.01
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
        point["width_error"] = point["width"] / truth["width"] - 1.0
        point["finest"] = point is truth
    for point in found:
        point["holds"] = all(other["error"] <= GOOD for other in found if finer(other, point))
    return found


def finer(one, other):
    """Is a point as fine as another of its kind, in mesh and step? Errors that only offset each other fail then."""
    same = all(one[key] == other[key] for key in ("program", "mesh", "scheme"))
    return same and one["cell"] >= other["cell"] and one["steps"] >= other["steps"]


def rows_of(found):
    for point in sorted(found, key=lambda point: (point["program"], point["scheme"], point["cpu"])):
        error = "finest" if point["finest"] else f"{100 * point['sign'] * point['error']:+.2f} %"
        good = "yes" if point["holds"] and not point["finest"] else ""
        yield (
            f"| {NAMES[point['program']]} | {point['point']} | {point['nodes']:.0f} | {point['cpu']:.2f} |"
            f" {point['cpu_steps']:.2f} | {point['fall']:.3f} | {error} | {100 * point['front_error']:+.2f} % |"
            f" {100 * point['width_error']:+.2f} % | {point['overlap']:.2g} | {good} |"
        )


def cheapest(found, program, column, schemes=None):
    good = [
        point for point in found
        if point["program"] == program and point["holds"] and not point["finest"]
        and (schemes is None or point["scheme"] in schemes)
    ]
    return min(good, key=lambda point: point[column], default=None)


def ratios(found):
    """Least CPU at 1 % of each program, of the whole process and of the steps alone."""
    for schemes in (["once"], ["sub-steps"]):
        for column in ("cpu", "cpu_steps"):
            ours, theirs = cheapest(found, "sillage", column), cheapest(found, "migflow", column, schemes)
            if ours and theirs:
                yield (
                    f"{column}, contacts of MigFlow {schemes[0]}: MigFlow {theirs[column]:.2f} s ({theirs['point']}),"
                    f" Sillage {ours[column]:.2f} s ({ours['point']}): {theirs[column] / ours[column]:.2f}"
                )


def show(data, finest, picture):
    found = points(read(data))
    truths = {
        point["program"]: point for point in found if (point["program"], point["point"]) in finest
    }
    found = with_errors(found, truths)
    print("| program | cell, step, mesh, scheme | nodes | CPU (s) | of it steps (s) | fall / R | mean position | front |"
          " width | overlap / r | at 1 % |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
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
    kinds = sorted({(point["program"], point["scheme"]) for point in found})
    for (program, scheme), mark in zip(kinds, "osD^v"):
        shown = [p for p in found if (p["program"], p["scheme"]) == (program, scheme) and not p["finest"]]
        axes.loglog(
            [p["cpu"] for p in shown], [100 * p["error"] for p in shown], mark, label=f"{NAMES[program]}, {scheme}"
        )
    axes.axhline(100 * GOOD, color="grey", linewidth=0.8)
    axes.set_xlabel("CPU of the whole run (s)")
    axes.set_ylabel("mean position at t* = 60, error (%)")
    axes.legend()
    figure.savefig(picture, dpi=120)
