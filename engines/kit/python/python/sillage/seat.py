"""Between the native loop and an engine: plain data on one side, named fields on the other."""

import json
import math
import traceback

import numpy as np

from . import _native
from .fields import INPUTS, Fields
from .report import FluidReport, ParticleReport
from .state import Grains, Mesh

#: What an engine in each seat may return from ``advance``, and what that is where it returns None.
_REPORTS = {"fluid": (FluidReport, FluidReport()), "particles": (ParticleReport, None)}


def _forget_locals(error):
    """Whoever keeps an exception must not keep the arrays of the frames it went through."""
    while error is not None:
        traceback.clear_frames(error.__traceback__)
        error = error.__cause__ or error.__context__


class Seat:
    """An engine as the native loop sees it."""

    def __init__(self, engine, role):
        for method in ("configure", "advance", "commit"):
            if not callable(getattr(engine, method, None)):
                raise TypeError(f"{type(engine).__name__} has no method {method}")
        self.engine = engine
        self.role = role
        self.name = str(getattr(engine, "name", type(engine).__name__))
        self.version = str(getattr(engine, "version", "0"))
        self.capabilities = list(getattr(engine, "capabilities", ()))
        #: Nodes or grains, and dimensions.
        self.shape = (0, 2)

    def configure_fluid(self, scene):
        scene = json.loads(scene)
        mesh = self.engine.configure(scene)
        if not isinstance(mesh, Mesh):
            raise TypeError(f"configure returned {type(mesh).__name__}, must be a sillage.Mesh")
        self.shape = mesh.nodes.shape
        return mesh

    def adapt_fluid(self, sizes):
        mesh = self.engine.adapt(json.loads(sizes))
        if mesh is None:
            return None
        if not isinstance(mesh, Mesh):
            raise TypeError(f"adapt returned {type(mesh).__name__}, must be a sillage.Mesh or None")
        self.shape = mesh.nodes.shape
        return mesh

    def configure_particles(self, scene, arrays):
        scene = json.loads(scene)
        dimension = scene["dimension"]
        taken = self.engine.configure(scene, Grains._from_bytes(arrays, dimension))
        if taken is None:
            taken = Grains._from_bytes(arrays, dimension)
        if not isinstance(taken, Grains):
            raise TypeError(f"configure returned {type(taken).__name__}, must be sillage.Grains")
        taken.__post_init__()  # it may have been changed since
        self.shape = taken.position.shape
        return taken._arrays()

    def advance(self, numbers, given, filled):
        from .engine import Request

        missing = [name for name in INPUTS[self.role] if name not in given]
        inputs, outputs = Fields(given, missing, self.shape), Fields(filled, (), self.shape)
        try:
            report = self.engine.advance(Request(*numbers), inputs, outputs)
        except BaseException as error:
            _forget_locals(error)
            raise
        finally:
            inputs._close()
            outputs._close()
        kind, nothing = _REPORTS[self.role]
        report = nothing if report is None else report
        if not isinstance(report, kind):
            raise TypeError(f"advance returned {type(report).__name__}, must be a sillage.{kind.__name__}")
        named = report.diagnostics.items()
        return report._numbers(), [(str(name), self._number(name, value)) for name, value in named]

    @staticmethod
    def _number(name, value):
        number = float(value)
        if not math.isfinite(number):
            raise _native.NotFinite(f"diagnostic {name} is {number}")
        return number

    def commit(self):
        self.engine.commit()

    def remove(self, gone):
        left = self.engine.remove(np.array(gone))
        if not isinstance(left, Grains):
            raise TypeError(f"remove returned {type(left).__name__}, must be sillage.Grains")
        left.__post_init__()
        self.shape = left.position.shape
        return left._arrays()

    def save(self, path):
        self.engine.save(path)

    def restore(self, path):
        self.engine.restore(path)
