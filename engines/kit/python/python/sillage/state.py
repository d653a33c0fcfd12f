"""What an engine tells about itself when it is configured: its mesh, or its grains."""

import math
from dataclasses import dataclass

import numpy as np

from ._native import SceneError


def _numbers(name, values, *shape):
    """``values`` as a contiguous array of float64 with this shape (``None``: any length)."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    fits = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape)
    )
    if not fits:
        wanted = " × ".join("n" if want is None else str(want) for want in shape)
        raise ValueError(f"{name} has shape {array.shape}, must be {wanted}")
    if not np.isfinite(array).all():
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name}{list(place)} is {array[place]}")
    return array


@dataclass
class Mesh:
    """The mesh of a fluid engine: linear shape functions on simplices (triangles in the plane, tetrahedra in space); SI units.

    The engine keeps the arrays, Sillage takes a copy.
    """

    #: Coordinates [m], n × d.
    nodes: np.ndarray
    #: Corners of the simplices, s × (d + 1), from 0, positively oriented: in the plane counter-clockwise, in space so
    #: that (x₁ − x₀) × (x₂ − x₀) points to the side of x₃.
    simplices: np.ndarray
    #: Coordinates of the corners [m], s × (d + 1) × d; needed where one crosses a periodic boundary.
    simplex_position: np.ndarray | None = None
    #: ∫N of each node [m²; m³], n; computed when left out.
    nodal_mass: np.ndarray | None = None
    #: Period along each axis [m]; left out: none.
    period: tuple[float | None, ...] | None = None

    def __post_init__(self):
        shape = np.shape(self.nodes)
        if len(shape) != 2 or shape[1] not in (2, 3):
            raise ValueError(f"nodes has shape {shape}, must be n × 2 or n × 3")
        self.nodes = _numbers("nodes", self.nodes, None, None)
        d = self.dimension
        self.simplices = _numbers("simplices", np.asarray(self.simplices), None, d + 1)
        corners = self.simplices.astype(np.int64)
        if (corners != self.simplices).any() or corners.min() < 0 or corners.max() >= len(self.nodes):
            raise ValueError(f"simplices must hold whole numbers from 0 to {len(self.nodes) - 1}")
        if self.simplex_position is None:
            self.simplex_position = self.nodes[corners]
        position = _numbers("simplex_position", self.simplex_position, len(corners), d + 1, d)
        self.simplex_position = position
        measure = np.linalg.det(position[:, 1:] - position[:, :1]) / math.factorial(d)
        if (measure <= 0.0).any():
            worst = int(measure.argmin())
            raise ValueError(
                f"simplex {worst} has measure {measure[worst]:.3e} m^{d}: corners must be positively "
                "oriented (in the plane counter-clockwise)"
            )
        if self.nodal_mass is None:
            shares = np.repeat(measure / (d + 1), d + 1)
            self.nodal_mass = np.bincount(corners.ravel(), shares, minlength=len(self.nodes))
        self.nodal_mass = _numbers("nodal_mass", self.nodal_mass, len(self.nodes))
        period = (None,) * d if self.period is None else self.period
        self.period = [None if p is None else float(p) for p in period]

    @property
    def dimension(self):
        """Of the space."""
        return self.nodes.shape[1]


@dataclass
class Grains:
    """Grains as they are when a run begins: spheres, or disks per metre of depth; SI units.

    The arrays are the engine's own: it may keep and change them.
    """

    #: Centres [m], g × d.
    position: np.ndarray
    #: Velocities [m/s], g × d.
    velocity: np.ndarray
    #: Radii [m], g.
    radius: np.ndarray
    #: Masses [kg], g.
    mass: np.ndarray
    #: Volumes [m³] (disk: m²), g.
    volume: np.ndarray
    #: True for a grain that never moves, g.
    fixed: np.ndarray

    def __post_init__(self):
        self.position = _numbers("position", self.position, None, None)
        count, dimension = self.position.shape
        self.velocity = _numbers("velocity", self.velocity, count, dimension)
        self.radius = _numbers("radius", self.radius, count)
        self.mass = _numbers("mass", self.mass, count)
        self.volume = _numbers("volume", self.volume, count)
        self.fixed = np.asarray(self.fixed, dtype=bool)
        if self.fixed.shape != (count,):
            raise ValueError(f"fixed has shape {self.fixed.shape}, must be {count}")

    def __len__(self):
        return len(self.radius)

    def without(self, gone):
        """The same without these."""
        arrays = (self.position, self.velocity, self.radius, self.mass, self.volume, self.fixed)
        return Grains(*(np.delete(array, gone, axis=0) for array in arrays))

    @classmethod
    def _from_bytes(cls, arrays, dimension):
        position, velocity, radius, mass, volume, fixed = (
            np.frombuffer(array, dtype=np.float64) for array in arrays
        )
        vectors = (vector.reshape(-1, dimension) for vector in (position, velocity))
        return cls(*vectors, radius, mass, volume, fixed != 0.0)

    def _arrays(self):
        fixed = self.fixed.astype(np.float64)
        return [self.position, self.velocity, self.radius, self.mass, self.volume, fixed]


def require(condition, why):
    """Raise :class:`sillage.SceneError` unless ``condition`` holds."""
    if not condition:
        raise SceneError(why)
