"""What an engine tells about itself when it is configured: its mesh, or its grains."""

from dataclasses import dataclass, field

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
    """The mesh of a fluid engine: linear shape functions on triangles; SI units.

    The engine keeps the arrays, Sillage takes a copy.
    """

    #: Coordinates [m], n × 2.
    nodes: np.ndarray
    #: Corners of the triangles, t × 3, counter-clockwise, from 0.
    triangles: np.ndarray
    #: Coordinates of the corners [m], t × 3 × 2; needed where a triangle crosses a periodic boundary.
    triangle_position: np.ndarray | None = None
    #: ∫N of each node [m²], n; computed when left out.
    nodal_mass: np.ndarray | None = None
    #: Period in x and y [m].
    period: tuple[float | None, float | None] = field(default=(None, None))

    def __post_init__(self):
        self.nodes = _numbers("nodes", self.nodes, None, 2)
        corners = np.asarray(self.triangles)
        self.triangles = _numbers("triangles", corners, None, 3)
        corners = self.triangles.astype(np.int64)
        if (corners != self.triangles).any() or corners.min() < 0 or corners.max() >= len(self.nodes):
            raise ValueError(f"triangles must hold whole numbers from 0 to {len(self.nodes) - 1}")
        if self.triangle_position is None:
            self.triangle_position = self.nodes[corners]
        position = _numbers("triangle_position", self.triangle_position, len(corners), 3, 2)
        self.triangle_position = position
        a, b, c = position[:, 0], position[:, 1], position[:, 2]
        area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        if (area <= 0.0).any():
            worst = int(area.argmin())
            raise ValueError(
                f"triangle {worst} has area {area[worst]:.3e} m²: corners must be counter-clockwise"
            )
        if self.nodal_mass is None:
            thirds = np.repeat(area / 3.0, 3)
            self.nodal_mass = np.bincount(corners.ravel(), thirds, minlength=len(self.nodes))
        self.nodal_mass = _numbers("nodal_mass", self.nodal_mass, len(self.nodes))
        self.period = tuple(None if p is None else float(p) for p in self.period)


@dataclass
class Grains:
    """Grains as they are when a run begins; SI units, disks per metre of depth.

    The arrays are the engine's own: it may keep and change them.
    """

    #: Centres [m], g × 2.
    position: np.ndarray
    #: Velocities [m/s], g × 2.
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
        self.position = _numbers("position", self.position, None, 2)
        count = len(self.position)
        self.velocity = _numbers("velocity", self.velocity, count, 2)
        self.radius = _numbers("radius", self.radius, count)
        self.mass = _numbers("mass", self.mass, count)
        self.volume = _numbers("volume", self.volume, count)
        self.fixed = np.asarray(self.fixed, dtype=bool)
        if self.fixed.shape != (count,):
            raise ValueError(f"fixed has shape {self.fixed.shape}, must be {count}")

    def __len__(self):
        return len(self.radius)

    @classmethod
    def _from_bytes(cls, arrays):
        position, velocity, radius, mass, volume, fixed = (
            np.frombuffer(array, dtype=np.float64) for array in arrays
        )
        return cls(position.reshape(-1, 2), velocity.reshape(-1, 2), radius, mass, volume, fixed != 0.0)

    def _arrays(self):
        fixed = self.fixed.astype(np.float64)
        return [self.position, self.velocity, self.radius, self.mass, self.volume, fixed]


def require(condition, why):
    """Raise :class:`sillage.SceneError` unless ``condition`` holds."""
    if not condition:
        raise SceneError(why)
