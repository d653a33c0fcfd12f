"""Sillage and MigFlow on the same cloud: CPU time at equal error (README.md).

    python compare.py run points.toml [--only TEXT] [--repeats 3]    runs what cloud.csv lacks, in turn
    python compare.py table                                          tables and picture from cloud.csv

A point is a line of `points.toml`; each of its runs is a line of `cloud.csv`, with the CPU time of the whole process
and all its children, as the kernel counts it. Points run one after another, all once and then again, so that a busy
machine disturbs all alike.
"""

import argparse
import csv
import datetime
import json
import os
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import tables

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SILLAGE = ROOT / "target/release/sillage"
RADIUS = 3.708e-3  # m
START = 0.2002  # height of the cloud's centre [m]
END = 0.825  # s, t* = 60
#: Cells of the root of Sillage's meshes.
ROOT_CELLS = [15, 45]
#: Of PARDISO: the factors of an earlier step precondition CGS (to 1e-6) while that is quick enough.
TUNED = {3: 61}
COLUMNS = [
    "date", "program", "version", "point", "repeat", "mesh", "cell", "steps", "scheme", "nodes", "meshes",
    "cpu", "cpu_steps", "fall", "x", "front", "width", "overlap", "load",
]


def measured(command, log):
    """Run a command; its CPU time and that of its children [s], and its exit status."""
    single = {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    child = subprocess.Popen(command, stdout=log, stderr=log, env={**os.environ, **single})
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, child.returncode


def name(point):
    """What a point is called in tables: R/4, 100 steps, path, once."""
    more = [point["more"]] if "more" in point else []
    return ", ".join([f"R/{point['cell']:.3g}", f"{point['steps']} steps", point["mesh"], point["scheme"], *more])


def sillage_command(point, folder):
    near = RADIUS / point["cell"]
    settings = {
        "run.end_time": END, "run.coupling_step": END / point["steps"],
        "output.every": END, "output.frames": "false",
        "fluid.domain.rectangle.cells": ROOT_CELLS, "fluid.refinement.near_grains": near,
        "fluid.refinement.margin": 2 * near, "fluid.refinement.growth": 0.2,
        "fluid.time_scheme": point["scheme"], **point.get("set", {}),
    }
    sets = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    return [SILLAGE, "run", ROOT / "scenes/cloud.toml", "--threads", "1", *sets, "--out", folder]


def sillage_result(folder):
    steps = list(csv.DictReader(open(folder / "steps.csv")))
    last = {key: float(value) for key, value in steps[-1].items()}
    cost = json.load(open(folder / "run.json"))["cost"]
    # Places are half a step ahead of the time; the middle of the last path is not.
    ahead = last["centre_y_mid"] - last["centre_y"]
    return {
        "nodes": int(max(float(row["nodes"]) for row in steps)), "meshes": int(last["epoch"]) + 1,
        "cpu_steps": sum(cost["cpu_" + part] for part in ("fluid", "particles", "coupler")),
        "fall": (START - last["centre_y_mid"]) / RADIUS, "x": last["centre_x"] / RADIUS,
        "front": (START - last["front"] - ahead) / RADIUS, "width": last["width98"] / RADIUS,
        "overlap": max(float(row["penetration_max"]) for row in steps),
    }


def migflow_command(point, grains, out):
    options = {
        "steps": point["steps"], "end": END, "near": RADIUS / point["cell"], "mesh": point["mesh"],
        "contact": point["scheme"].removesuffix(" sub-steps"),
        "pardiso": json.dumps(point.get("pardiso", TUNED)), **point.get("options", {}),
    }
    words = [word for key, value in options.items() if value is not True for word in (f"--{key}", str(value))]
    words += [f"--{key}" for key, value in options.items() if value is True]
    return [sys.executable, HERE / "cloud.py", grains, *words, "--out", out]


def run(point, grains, folder):
    """One run of a point: the numbers of its line."""
    log_path = folder / "log"
    with open(log_path, "w") as log:
        if point["program"] == "sillage":
            cpu, code = measured(sillage_command(point, folder / "run"), log)
            result = sillage_result(folder / "run") if code == 0 else None
        else:
            cpu, code = measured(migflow_command(point, grains, folder / "run.json"), log)
            result = json.load(open(folder / "run.json")) if code == 0 else None
    if result is None:
        print(f"{point['name']}: exit code {code}\n" + log_path.read_text()[-800:], file=sys.stderr)
        return None
    return {**result, "cpu": cpu}


def version(program):
    if program == "migflow":
        from importlib.metadata import version as of

        return of("migflow")
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    return commit.stdout.strip()


def digits(value):
    return f"{value:.6g}" if isinstance(value, float) else value


def keep(path, point, repeat, result):
    """Append the line of a run."""
    row = {
        "date": datetime.date.today().isoformat(), "program": point["program"], "version": version(point["program"]),
        "point": name(point), "repeat": repeat,
        "mesh": point["mesh"], "cell": point["cell"], "steps": point["steps"], "scheme": point["scheme"],
        "load": os.getloadavg()[0], **result,
    }
    with open(path, "a", newline="") as file:
        csv.writer(file).writerow([digits(row[column]) for column in COLUMNS])


def run_all(options):
    points = tomllib.load(open(options.points, "rb"))["point"]
    points = [point for point in points if options.only in name(point)]
    if not options.data.exists():
        options.data.write_text(",".join(COLUMNS) + "\n")
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        plan = [SILLAGE, "plan", ROOT / "scenes/cloud.toml", "--out", scratch / "plan"]
        subprocess.run(plan, check=True, stdout=subprocess.DEVNULL)
        for repeat in range(options.repeats):
            for point in points:
                key = (point["program"], name(point), str(repeat))
                rows = tables.read(options.data)
                there = any((row["program"], row["point"], row["repeat"]) == key for row in rows)
                if there or repeat >= point.get("repeats", options.repeats):
                    continue
                with tempfile.TemporaryDirectory(dir=scratch) as folder:
                    result = run(point, scratch / "plan/grains.csv", Path(folder))
                if result is not None:
                    keep(options.data, point, repeat, result)
                    told = {column: digits(value) for column, value in result.items()}
                    print(point["program"], name(point), told, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["run", "table"])
    parser.add_argument("points", nargs="?", type=Path, default=HERE / "points.toml")
    parser.add_argument("--only", default="", help="points with this in their name")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--data", type=Path, default=HERE / "cloud.csv")
    parser.add_argument("--picture", type=Path, help="where the table's picture goes")
    options = parser.parse_args()
    if options.what == "run":
        run_all(options)
    else:
        points = tomllib.load(open(options.points, "rb"))["point"]
        finest = {(point["program"], name(point)) for point in points if point.get("finest")}
        tables.show(options.data, finest, options.picture)


if __name__ == "__main__":
    main()
