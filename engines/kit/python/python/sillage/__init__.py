"""Engines for Sillage, written in Python.

An engine is a class with a few methods (:class:`FluidEngine`, :class:`ParticleEngine`); the last
line of its program is ``sys.exit(sillage.run_fluid(MyEngine()))`` or ``run_particles``. The README
of this package is the introduction, the protocol's README the contract.
"""

from ._native import (
    PROTOCOL_VERSION,
    NotConverged,
    NotFinite,
    SceneError,
    ViewError,
)
from .engine import FluidEngine, ParticleEngine, Request, run_fluid, run_particles
from .fields import Fields
from .report import FluidReport, ParticleReport
from .state import Grains, Mesh

__all__ = [
    "PROTOCOL_VERSION",
    "Fields",
    "FluidEngine",
    "FluidReport",
    "Grains",
    "Mesh",
    "NotConverged",
    "NotFinite",
    "ParticleEngine",
    "ParticleReport",
    "Request",
    "SceneError",
    "ViewError",
    "run_fluid",
    "run_particles",
]
