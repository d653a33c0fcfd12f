"""Drive an engine in a test, without a coupler: the same loop, messages and buffers as in a run.

    with ParticleDriver(MyEngine()) as driver:
        driver.configure(particle_scene(), grains)
        candidate = driver.advance(dt=1e-3, grain_force=force)
        driver.commit()
"""

import json

import numpy as np

from . import _native
from ._native import EngineFailed
from .fields import components
from .seat import Seat

__all__ = ["Candidate", "EngineFailed", "FluidDriver", "ParticleDriver", "fluid_scene", "particle_scene"]


class Candidate(dict):
    """Copies of the fields by name; ``report`` and ``diagnostics`` by name."""

    def __init__(self, dimension, arrays, report, diagnostics):
        super().__init__()
        self.report = dict(report)
        self.diagnostics = dict(diagnostics)
        for name, data in arrays:
            values = np.frombuffer(data, dtype=np.float64)
            width = components(name, dimension)
            self[name] = values.reshape(-1, width) if width > 1 else values

    __getattr__ = dict.__getitem__


class _Driver:
    role = ""

    def __init__(self, engine):
        self._native = _native.Driver(self.role, Seat(engine, self.role))
        self.step, self.time, self._pass, self._dt = 0, 0.0, 0, 0.0
        self.dimension = 2

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def advance(self, dt, *, sub_steps=0, tolerance=1e-3, **fields):
        """A candidate of length ``dt`` [s] under these fields; a :class:`Candidate`.

        Failures of the engine are raised: :class:`sillage.SceneError`, ``NotConverged``,
        ``NotFinite``, and :class:`EngineFailed` for everything else.
        """
        numbers = (self.step + 1, self._pass, self.time, dt, sub_steps, tolerance)
        given = [
            (name, np.ascontiguousarray(values, dtype=np.float64).ravel())
            for name, values in fields.items()
        ]
        self._pass, self._dt = self._pass + 1, dt
        return Candidate(self.dimension, *self._native.advance(numbers, given))

    def commit(self):
        """Accept the last candidate."""
        self._native.commit(self.step + 1)
        self.step, self.time, self._pass = self.step + 1, self.time + self._dt, 0

    def save(self, path):
        """Let the engine write its accepted state."""
        self._native.save(str(path))

    def restore(self, path):
        """Let the engine read its accepted state."""
        self._native.restore(str(path))

    def close(self):
        """Let the engine leave."""
        self._native.close()


class FluidDriver(_Driver):
    """Drives a fluid engine."""

    role = "fluid"

    def configure(self, scene):
        """The engine's mesh: ``nodes`` (n × d), ``simplices`` (s × (d + 1)), ``nodal_mass`` (n)."""
        self.dimension = scene["dimension"]
        arrays = dict(self._native.configure_fluid(json.dumps(scene)))
        mesh = {name: np.frombuffer(data, dtype=np.float64) for name, data in arrays.items()}
        mesh["nodes"] = mesh["nodes"].reshape(-1, self.dimension)
        mesh["simplices"] = mesh["simplices"].reshape(-1, self.dimension + 1).astype(int)
        return mesh


class ParticleDriver(_Driver):
    """Drives a particle engine."""

    role = "particles"

    def configure(self, scene, grains):
        """Give the engine these :class:`sillage.Grains`; how many it will run."""
        self.dimension = scene["dimension"]
        arrays = [array.ravel() for array in grains._arrays()]
        return self._native.configure_particles(json.dumps(scene), arrays)

    def remove(self, grains):
        """Take grains out after a commit, by their ascending numbers; how many are left."""
        return self._native.remove([int(grain) for grain in grains])


def fluid_scene(dimension=2, **changes):
    """A scene's part for a fluid engine: water-like fluid at rest in a closed unit square, or cube."""
    whole = {"lower": [0.0] * dimension, "upper": [1.0] * dimension, "cells": [8] * dimension}
    rectangle = whole | {"diagonals": "alternate", "grading": [1.0, 1.0]}
    sides = ("left", "right", "bottom", "top", "back", "front")[: 2 * dimension]
    scene = {
        "dimension": dimension,
        "density": 1000.0,
        "dynamic_viscosity": 1.0,
        "gravity": [0.0, -9.81, 0.0][:dimension],
        "mesh": {"rectangle": rectangle} if dimension == 2 else {"box": whole},
        "boundaries": {side: "no-slip" for side in sides},
        "convection": True,
        "time_scheme": "backward-euler",
        "nonlinear": "picard",
        "viscous_form": "symmetric",
        "grad_div": 1.0,
        "initial_velocity": [0.0] * dimension,
        "threads": 1,
    }
    return scene | changes


def particle_scene(dimension=2, **changes):
    """A scene's part for a particle engine of disks, or of spheres: gravity, no walls, no friction."""
    scene = {
        "dimension": dimension,
        "gravity": [0.0, -9.81, 0.0][:dimension],
        "walls": [],
        "period": [None] * dimension,
        "friction": 0.0,
        "wall_friction": 0.0,
        "inertia_factor": 0.5 if dimension == 2 else 0.4,
        "tolerance": 1e-3,
        "sweeps_max": 10000,
        "sub_steps_max": 10000,
        "threads": 1,
    }
    return scene | changes
