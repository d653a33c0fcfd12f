"""A cloud of spheres in MigFlow 1.4 on tetrahedra that Sillage made: one run, one JSON object (README.md).

    python space.py grains.csv fluid_0000.vtu --steps 4 --step 6.873e-3 --out run.json

Grains are those that `sillage plan --out` writes, tetrahedra those of a run's `vtu/`. The scheme is MigFlow's own: one
implicit Euler step of the fluid by a direct solver, then the contacts, once a step.
"""

import argparse
import base64
import csv
import json
import time
import xml.etree.ElementTree as xml

from cloud import DENSITY, GRAIN_DENSITY, VISCOSITY, Pardiso, pin_pressure  # first: it sets the number of threads

import gmsh
import numpy as np
from migflow import fluid, scontact

GRAVITY = np.array([0.0, -9.81, 0.0])  # m/s²
TETRAHEDRON, TRIANGLE = 4, 2  # of Gmsh


def read_grains(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    position = np.array([[float(row[axis]) for axis in "xyz"] for row in rows])
    return position, np.array([float(row["radius"]) for row in rows])


def read_tetrahedra(path):
    """Nodes [m] and tetrahedra of a VTU: each array is its length, 8 bytes, and its numbers, in base64."""
    types = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1", "UInt32": "<u4", "Int32": "<i4", "Float32": "<f4"}

    def numbers(array):
        return np.frombuffer(base64.b64decode(array.text.strip())[8:], types[array.get("type")])

    piece = xml.parse(path).getroot().find(".//Piece")
    points = numbers(piece.find("Points/DataArray")).reshape(-1, 3)
    cells = {array.get("Name"): numbers(array) for array in piece.find("Cells")}
    return points, cells["connectivity"].reshape(-1, 4).astype(np.int64)


def boundary(tetrahedra):
    """Triangles that belong to one tetrahedron alone."""
    facets = np.concatenate([np.delete(tetrahedra, corner, axis=1) for corner in range(4)])
    _, first, count = np.unique(np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True)
    return facets[first[count == 1]]


def show_mesh(points, tetrahedra):
    """The mesh as the model of Gmsh, which MigFlow reads; all of its boundary is "Wall"."""
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("box")
    surface, volume = gmsh.model.addDiscreteEntity(2), gmsh.model.addDiscreteEntity(3)
    mesh = gmsh.model.mesh
    mesh.addNodes(3, volume, np.arange(1, len(points) + 1), points.ravel())
    mesh.addElementsByType(volume, TETRAHEDRON, [], tetrahedra.ravel() + 1)
    mesh.addElementsByType(surface, TRIANGLE, [], boundary(tetrahedra).ravel() + 1)
    gmsh.model.addPhysicalGroup(2, [surface], name="Wall")
    gmsh.model.addPhysicalGroup(3, [volume], name="fluid")


def flow():
    problem = fluid.FluidProblem(3, GRAVITY, [VISCOSITY], [DENSITY], solver="pardiso")
    problem.linear_system_package = Pardiso
    problem.load_msh(None)
    problem.set_wall_boundary("Wall")
    problem.set_strong_boundary("Wall", velocity=[0.0, 0.0, 0.0])
    pin_pressure(problem, mean=False)
    return problem


def particles(position, radius):
    problem = scontact.ParticleProblem(3)
    # The library looks through all bodies for each new one.
    problem._body_uid_max = lambda: problem.n_bodies() - 1
    for x, r in zip(position, radius):
        problem.add_particle(x, r, 4 / 3 * np.pi * r**3 * GRAIN_DENSITY)
    return problem


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("grains", help="CSV with x, y, z, radius [m]")
    parser.add_argument("mesh", help="VTU of the fluid")
    parser.add_argument("--steps", type=int, default=4)
    parser.add_argument("--step", type=float, default=6.873e-3, help="length of a step [s]")
    parser.add_argument("--pardiso", type=json.loads, default={}, help='parameters, e.g. {"3": 61}')
    parser.add_argument("--out", required=True)
    options = parser.parse_args()
    Pardiso.changed = {int(index): value for index, value in options.pardiso.items()}
    position, radius = read_grains(options.grains)
    show_mesh(*read_tetrahedra(options.mesh))
    problem, grains = flow(), particles(position, radius)
    weight = GRAVITY * (4 / 3 * np.pi * radius**3 * GRAIN_DENSITY)[:, None]
    start, mean, steps = position.mean(axis=0), [], []
    for _ in range(options.steps):
        begin, before = time.process_time(), grains.position().mean(axis=0)
        motion = grains.position(), grains.velocity(), grains.omega()
        problem.set_particles(grains.delassus(), grains.volume(), *motion, grains.contact_forces())
        problem.implicit_euler(options.step)
        grains.iterate(options.step, problem.compute_node_force() + weight, tol=0.1 * radius.min(), force_motion=1)
        steps.append(time.process_time() - begin)
        mean.append((grains.position().mean(axis=0)[1] - before[1]) / options.step)
    result = {
        "nodes": problem.n_nodes(), "grains": len(radius), "cpu": time.process_time(), "cpu_of_steps": steps,
        "velocity": mean, "fall": start[1] - grains.position().mean(axis=0)[1],
    }
    with open(options.out, "w") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main()
