"""Between the native loop and an engine: plain data on one side, named fields on the other."""

import json
import math
import traceback

from . import _native
from .fields import Fields
from .state import Grains, Mesh

_INPUTS = {
    "fluid": (
        "porosity",
        "drag",
        "drag_source",
        "entrained_fraction",
        "solid_flux",
        "solid_mobility",
    ),
    "particles": ("grain_drag", "grain_force"),
}


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
        self.count = 0

    def configure_fluid(self, scene):
        mesh = self.engine.configure(json.loads(scene))
        if not isinstance(mesh, Mesh):
            raise TypeError(f"configure returned {type(mesh).__name__}, must be a sillage.Mesh")
        self.count = len(mesh.nodes)
        return mesh

    def configure_particles(self, scene, arrays):
        grains = Grains._from_bytes(arrays)
        taken = self.engine.configure(json.loads(scene), grains)
        if taken is None:
            taken = Grains._from_bytes(arrays)
        if not isinstance(taken, Grains):
            raise TypeError(f"configure returned {type(taken).__name__}, must be sillage.Grains")
        taken.__post_init__()  # it may have been changed since
        self.count = len(taken)
        return taken._arrays()

    def advance(self, numbers, given, filled):
        from .engine import Request

        missing = [name for name in _INPUTS[self.role] if name not in given]
        inputs, outputs = Fields(given, missing, self.count), Fields(filled, (), self.count)
        try:
            diagnostics = self.engine.advance(Request(*numbers), inputs, outputs)
        except BaseException as error:
            _forget_locals(error)
            raise
        finally:
            inputs._close()
            outputs._close()
        return [(str(name), self._number(name, value)) for name, value in (diagnostics or {}).items()]

    @staticmethod
    def _number(name, value):
        number = float(value)
        if not math.isfinite(number):
            raise _native.NotFinite(f"diagnostic {name} is {number}")
        return number

    def commit(self):
        self.engine.commit()

    def save(self, path):
        self.engine.save(path)

    def restore(self, path):
        self.engine.restore(path)
