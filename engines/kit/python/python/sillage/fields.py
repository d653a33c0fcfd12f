"""The fields of one ``advance``, as arrays over shared memory."""

import numpy as np

from ._native import FIELDS, ViewError

#: Rank of each field: how many numbers a node or a grain has, see :func:`components`.
RANKS = {name: rank for name, rank, _, _ in FIELDS}

#: What a field is where it is not sent.
DEFAULTS = {name: default for name, _, default, _ in FIELDS if default is not None}

#: Fields that an engine may be sent, by its seat.
INPUTS = {
    seat: tuple(name for name, _, _, sent in FIELDS if f"to {seat}" in sent) for seat in ("fluid", "particles")
}


def components(name, dimension):
    """Numbers of a node or a grain: of a scalar 1, of a vector d, of an angular velocity 1 in the plane and 3
    in space."""
    return {"vector": dimension, "spin": dimension * (dimension - 1) // 2}.get(RANKS[name], 1)


class Fields:
    """Fields by name: ``inputs.porosity``, ``outputs.pressure[:] = p``.

    Each is a :class:`numpy.ndarray` of ``float64`` in SI units, shape ``(n,)``, or ``(n, d)`` for a
    vector in d dimensions (``grain_spin``: ``(n,)`` in the plane, ``(n, 3)`` in space), that looks at the shared memory itself: nothing is copied. Inputs are read-only, outputs
    are writable and filled with NaN until they are written. An input that was not sent is a read-only
    array of its default, see :meth:`given`.

    The memory belongs to Sillage, and only until ``advance`` returns. A field that is asked for later
    raises :class:`sillage.ViewError`; an array (or a slice of one) that is still alive when ``advance``
    returns ends the run with the same error, naming the field: keep ``inputs.porosity.copy()``. What
    arrays cannot tell of is the address of their memory (``.ctypes``): do not give it to a library that
    remembers it.
    """

    __slots__ = ("_buffers", "_missing", "_open")

    def __init__(self, buffers, missing, shape):
        object.__setattr__(self, "_buffers", buffers)
        object.__setattr__(self, "_missing", dict.fromkeys(missing, shape))
        object.__setattr__(self, "_open", True)

    @property
    def given(self):
        """Names of the fields that were sent."""
        return frozenset(self._buffers)

    def __getattr__(self, name):
        buffer = self._buffers.get(name)
        if buffer is not None:
            # Through a memoryview: an array made from the object itself would hide the error of a
            # buffer that is closed.
            return np.asarray(memoryview(buffer))
        if name in self._missing:
            if not self._open:
                raise ViewError(f"{name} was read after its step")
            count, dimension = self._missing[name]
            shape = (count, dimension) if RANKS[name] == "vector" else (count,)
            return np.broadcast_to(np.float64(DEFAULTS.get(name, 0.0)), shape)
        known = ", ".join([*self._buffers, *self._missing])
        raise AttributeError(f"there is no field {name!r} here; there are {known}")

    def __setattr__(self, name, value):
        raise AttributeError(f"write into the array: outputs.{name}[:] = …")

    def __dir__(self):
        return [*self._buffers, *self._missing, "given"]

    def _close(self):
        object.__setattr__(self, "_open", False)
