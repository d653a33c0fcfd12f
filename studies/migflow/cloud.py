"""The cloud of `scenes/cloud.toml` in MigFlow 1.4: one run, one JSON object (README.md says how to install it).

    python cloud.py grains.csv --steps 150 --near 6.18e-4 --out run.json

Grains are those that `sillage plan --out` writes. The scheme is MigFlow's own: porosity and drag from the grains of
the step's start, one implicit Euler step of the fluid by a direct solver, then the contacts. Lengths are told in
radii R of the cloud, at the end of the run.
"""

import argparse
import csv
import json
import os
import time

for threads in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import gmsh  # noqa: E402
import numpy as np  # noqa: E402
from migflow import fluid, pardisolsys, scontact, time_integration  # noqa: E402

R = 3.708e-3  # m
LOWER, UPPER = np.array([-0.03708, 0.0]), np.array([0.03708, 0.22248])  # m
CENTRE = np.array([0.0, 0.2002])  # m
GRAVITY = np.array([0.0, -9.81])  # m/s²
DENSITY, VISCOSITY, GRAIN_DENSITY = 1200.0, 0.12, 2400.0  # kg/m³, Pa s, kg/m³
WALLS = ["Bottom", "Right", "Top", "Left"]
#: Where grains are until t* = 60, with a margin of R/3: what a mesh that stays is graded around.
PATH = np.array([[-2.3 * R, 0.1496], [2.3 * R, 0.2052]])


class Pardiso(pardisolsys.LinearSystem):
    """MigFlow's PARDISO with some of its parameters changed: `iparm[k] = v`, counted from 0."""

    changed = {}

    def __init__(self, *arguments, **named):
        super().__init__(*arguments, **named)
        for index, value in self.changed.items():
            self.iparm[index] = value


class Mesh:
    """A rectangle with cells of `near` inside a box and larger ones around it, by Gmsh."""

    def __init__(self, near, growth, largest):
        self.near, self.growth, self.largest = near, growth, max(largest, near)
        self.box = None
        gmsh.option.setNumber("General.Terminal", 0)
        for source in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
            gmsh.option.setNumber("Mesh.MeshSize" + source, 0)
        gmsh.option.setNumber("Mesh.Algorithm", 6)
        gmsh.model.add("box")
        geometry = gmsh.model.geo
        (x0, y0), (x1, y1) = LOWER, UPPER
        corners = [geometry.addPoint(x, y, 0) for x, y in [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]]
        sides = [geometry.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
        surface = geometry.addPlaneSurface([geometry.addCurveLoop(sides)])
        geometry.synchronize()
        for side, name in zip(sides, WALLS):
            gmsh.model.addPhysicalGroup(1, [side], name=name)
        gmsh.model.addPhysicalGroup(2, [surface], name="fluid")

    def make(self, box):
        """Mesh around a box (lower, upper) into the model of Gmsh, which MigFlow reads."""
        self.box = box
        field = gmsh.model.mesh.field
        for tag in field.list():
            field.remove(tag)
        sizes = field.add("Box")
        reach = (self.largest - self.near) / self.growth
        for name, value in [
            ("VIn", self.near), ("VOut", self.largest), ("Thickness", max(reach, 1e-9)),
            ("XMin", box[0][0]), ("YMin", box[0][1]), ("XMax", box[1][0]), ("YMax", box[1][1]),
        ]:
            field.setNumber(sizes, name, value)
        field.setAsBackgroundMesh(sizes)
        gmsh.model.mesh.clear()
        gmsh.model.mesh.generate(2)

    def holds(self, position):
        return (position >= self.box[0]).all() and (position <= self.box[1]).all()


def read_grains(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    position = np.array([[float(row["x"]), float(row["y"])] for row in rows])
    return position, np.array([float(row["radius"]) for row in rows])


def particles(position, radius):
    problem = scontact.ParticleProblem(2)
    # The library looks through all bodies for each new one.
    problem._body_uid_max = lambda: problem.n_bodies() - 1
    for x, r in zip(position, radius):
        problem.add_particle(x, r, np.pi * r**2 * GRAIN_DENSITY)
    (x0, y0), (x1, y1) = LOWER, UPPER
    corners = [np.array(c) for c in [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]]
    for k, name in enumerate(WALLS):
        problem.add_boundary_segment(corners[k], corners[(k + 1) % 4], name)
    return problem


def flow(options):
    problem = fluid.FluidProblem(2, GRAVITY, [VISCOSITY], [DENSITY], solver="pardiso", p2p1=options.p2p1)
    problem.linear_system_package = Pardiso
    problem.load_msh(None)
    for wall in WALLS:
        problem.set_wall_boundary(wall)
        problem.set_strong_boundary(wall, velocity=[0.0, 0.0])
    pin_pressure(problem, options.mean_pressure)
    return problem


def pin_pressure(problem, mean):
    """The pressure's constant: its mean is 0, a full row of the matrix, or one node's value is 0."""
    if mean:
        problem.set_mean_pressure(0)
    else:
        problem.constraint_index = [problem.pressure_index().reshape(-1)[:1]]
        problem.constraint_value = [(np.ones(1), 0.0)]
    problem.sys = None


def show_grains(problem, grains):
    matter = grains.delassus(), grains.volume()
    motion = grains.position(), grains.velocity(), grains.omega()
    problem.set_particles(*matter, *motion, grains.contact_forces())


def box_of(position, margin):
    """The box that holds all grains, with a margin around [m]."""
    return position.min(axis=0) - margin, position.max(axis=0) + margin


def run(options, grains, radius):
    """All steps; the fluid's problem, the middles of the last paths, the number of meshes, the steps' CPU [s]."""
    mesh = Mesh(options.near, options.growth, options.largest if options.mesh != "uniform" else options.near)
    mesh.make(box_of(grains.position(), options.margin * R) if options.mesh == "follow" else PATH)
    problem = flow(options)
    show_grains(problem, grains)
    start, meshes = time.process_time(), 1
    step = options.end / options.steps
    weight = GRAVITY * (np.pi * radius**2 * GRAIN_DENSITY)[:, None]
    for _ in range(options.steps):
        if options.mesh == "follow" and not mesh.holds(grains.position()):
            mesh.make(box_of(grains.position(), options.margin * R))
            problem.adapt_mesh()
            pin_pressure(problem, options.mean_pressure)
            meshes += 1
        before = grains.position()
        advance(options.contact, problem, grains, step, weight, radius.min())
    cpu = time.process_time() - start
    return problem, (before + grains.position()) / 2, meshes, cpu


def advance(contact, problem, grains, step, weight, radius):
    """One step. Contacts as the shipped examples have them, 2d_drop_mono (once) and drop.py (sub-steps, by the speed
    of grains), or in so many sub-steps."""
    show_grains(problem, grains)
    problem.implicit_euler(step)
    force = problem.compute_node_force() + weight
    if contact == "once":
        grains.iterate(step, force, tol=0.1 * radius, force_motion=1)
    elif contact == "sub-steps":
        time_integration._advance_particles(grains, force, step, 1, 1e-3 * radius)
    else:
        for _ in range(int(contact)):
            grains.iterate(step / int(contact), force, tol=1e-3 * radius, force_motion=1)


def overlap(position, radius):
    """Deepest overlap of two grains, in radii."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(position).query_pairs(2 * radius.max(), output_type="ndarray")
    apart = np.linalg.norm(position[pairs[:, 0]] - position[pairs[:, 1]], axis=1)
    return max(float(((radius[pairs].sum(axis=1) - apart) / radius.min()).max(initial=0.0)), 0.0)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("grains", help="CSV with x, y, radius [m]")
    parser.add_argument("--steps", type=int, default=150)
    parser.add_argument("--end", type=float, default=0.825, help="end time [s]")
    parser.add_argument("--mesh", choices=["uniform", "path", "follow"], default="path")
    parser.add_argument("--near", type=float, default=6.18e-4, help="cells at the grains [m]")
    parser.add_argument("--growth", type=float, default=0.3, help="of cells away from there, metres a metre")
    parser.add_argument("--largest", type=float, default=2 * R, help="largest cells [m]")
    parser.add_argument("--margin", type=float, default=0.5, help="how far grains go before a mesh follows, in R")
    parser.add_argument("--contact", default="once", help="once, sub-steps, or how many sub-steps")
    parser.add_argument("--mean-pressure", action="store_true", help="as in the shipped examples: a full row")
    parser.add_argument("--p2p1", action="store_true", help="quadratic velocities, no stabilisation")
    parser.add_argument("--pardiso", type=json.loads, default={}, help='parameters, e.g. {"3": 61}')
    parser.add_argument("--out", required=True)
    return parser.parse_args()


def main():
    options = arguments()
    Pardiso.changed = {int(index): value for index, value in options.pardiso.items()}
    position, radius = read_grains(options.grains)
    grains = particles(position, radius)
    problem, x, meshes, cpu_steps = run(options, grains, radius)
    cpu = time.process_time()
    mean = x.mean(axis=0)
    low, high = np.quantile(x[:, 0], [0.01, 0.99])
    result = {
        "nodes": problem.n_nodes(), "meshes": meshes, "cpu": cpu, "cpu_steps": cpu_steps,
        "x": (mean[0] - CENTRE[0]) / R, "fall": (CENTRE[1] - mean[1]) / R,
        "front": (CENTRE[1] - x[:, 1].min()) / R, "width": (high - low) / R,
        "overlap": overlap(grains.position(), radius),
        "finite": bool(np.isfinite(problem.solution()).all()),
    }
    with open(options.out, "w") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main()
