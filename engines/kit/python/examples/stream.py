"""A fluid engine in Python: a uniform stream that nothing disturbs, on a rectangle of triangles or a box of tetrahedra.

    python3 stream.py VX VY [VZ]        interstitial velocity (m/s)
"""

import itertools
import sys

import numpy as np
import sillage


def simplices(cells):
    """d! simplices for each of the cells along the axes (Kuhn), as numbers of nodes; the last axis counts fastest."""
    node = np.arange(np.prod(cells + 1)).reshape(cells + 1)
    found = []
    for order in itertools.permutations(range(len(cells))):
        steps = np.eye(len(cells), dtype=int)[list(order)]
        corners = np.vstack([0 * cells, steps.cumsum(axis=0)])
        if np.linalg.det(steps) < 0.0:  # left-handed
            corners[[-2, -1]] = corners[[-1, -2]]
        numbers = [node[tuple(map(slice, corner, corner + cells))].ravel() for corner in corners]
        found.append(np.column_stack(numbers))
    return np.concatenate(found)


class Stream(sillage.FluidEngine):
    name, version = "stream", "1"

    def __init__(self, velocity):
        self.velocity = velocity

    def configure(self, scene):
        if "file" in scene["mesh"]:
            raise sillage.SceneError("fluid.domain.mesh: stream takes rectangles and boxes, no mesh files")
        for side, condition in scene["boundaries"].items():
            if condition == "periodic":
                raise sillage.SceneError(f"fluid.boundaries.{side} is periodic: stream has no periodic sides")
        ((_, part),) = scene["mesh"].items()
        cells = np.array(part["cells"])
        lines = [np.linspace(*ends, count + 1) for *ends, count in zip(part["lower"], part["upper"], cells)]
        self.nodes = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, scene["dimension"])
        self.weight = scene["density"] * np.array(scene["gravity"])
        return sillage.Mesh(self.nodes, simplices(cells))

    def advance(self, request, inputs, outputs):
        outputs.interstitial_velocity[:] = self.velocity[: len(self.weight)]
        outputs.pressure_gradient[:] = self.weight
        outputs.pressure[:] = self.nodes @ self.weight

    def commit(self):
        pass


if __name__ == "__main__":
    given = [float(word) for word in sys.argv[1:]]
    sys.exit(sillage.run_fluid(Stream([*given, 0.0, 0.0, 0.0])))
