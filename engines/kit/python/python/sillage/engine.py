"""What an engine implements, and the two functions that run it."""

from dataclasses import dataclass

from . import _native
from .seat import Seat


@dataclass(frozen=True)
class Request:
    """A candidate is asked for: the state at ``time + dt``, from the accepted state at ``time``."""

    #: Coupling step, from 1.
    step: int
    #: Pass within the step; a new pass throws the last candidate away.
    pass_: int
    #: Start of the step [s].
    time: float
    #: Length of the step [s].
    dt: float
    #: Grains: sub-steps to use; 0 lets the engine choose.
    sub_steps: int
    #: Grains: relative accuracy of an inexact contact solve, of \\|g\\| dt.
    tolerance: float


class _Engine:
    #: Name and version, for run.json.
    name = "unnamed"
    version = "0"
    #: What the engine can do beyond the minimum: ``"affine-response"`` (fluid: uses
    #: ``entrained_fraction`` and ``solid_mobility``), ``"implicit-drag"`` (grains: ``grain_drag`` is in
    #: the free velocity and in the contact operator), ``"contact-state"`` (grains: ``grain_contact`` is
    #: 2 where a wall holds a grain), ``"checkpoint"`` (``restore`` brings back the same bits),
    #: ``"convection-as-needed"`` (``scene["convection"]`` may be ``"auto"``: left out while small),
    #: ``"moving-walls"`` (grains: the ``velocity`` of a wall, where it has one, enters the friction),
    #: ``"spin"`` (grains: every candidate has ``grain_spin``),
    #: ``"removes-grains"`` (grains: ``remove`` is there),
    #: ``"adapts"`` (fluid: goes by ``scene["refinement"]``, and ``adapt`` is there).
    capabilities = ()

    def commit(self):
        """Make the last candidate the accepted state."""
        raise NotImplementedError

    def save(self, path):
        """Write the accepted state to the file ``path``."""
        raise NotImplementedError(f"{self.name} writes no checkpoints")

    def restore(self, path):
        """Read the accepted state from the file ``path``, as ``save`` wrote it."""
        raise NotImplementedError(f"{self.name} reads no checkpoints")


class FluidEngine(_Engine):
    """A solver that takes the fluid seat. The equations it solves are in docs/engines.md."""

    def configure(self, scene):
        """Build the mesh and the initial state; return a :class:`sillage.Mesh`.

        ``scene`` is a ``dict`` with the keys of ``FluidScene`` (protocol/src/language/scene), SI units.
        ``scene["dimension"]`` d is 2 or 3; ``scene["mesh"]`` is ``{"rectangle": …}``, ``{"box": …}`` or ``{"file": …}``. Raise :class:`sillage.SceneError` for what this engine cannot do,
        with the key and the value.
        """
        raise NotImplementedError

    def advance(self, request, inputs, outputs):
        """Compute a candidate from the accepted state, which must not change.

        ``inputs`` (:class:`sillage.Fields`, n nodes in d dimensions): ``porosity`` [–], ``drag`` [kg/(m³ s)],
        ``drag_source`` [N/m³, n × d], ``entrained_fraction`` [–], ``solid_flux`` [m/s, n × d],
        ``solid_mobility`` [m³ s/kg], ``fixed_drag`` [kg/(m³ s)]. ``outputs``: ``interstitial_velocity`` [m/s, n × d],
        ``pressure_gradient`` [Pa/m, n × d], ``pressure`` [Pa]; all must be written.

        Returns a :class:`sillage.FluidReport`, or ``None``. Raise
        :class:`sillage.NotConverged` or :class:`sillage.NotFinite` where that is what happened;
        the engine may then be asked again, with a smaller step. Any other exception ends the run.
        """
        raise NotImplementedError


    def adapt(self, sizes):
        """Change to a mesh with cells of these sizes, before a step, and carry the accepted state over to it; return
        the new :class:`sillage.Mesh`, or ``None`` where the mesh stays. ``sizes`` is a ``dict`` with the keys of
        ``Refinement`` (protocol/src/language/scene): h(x) = min(``largest``, size + ``growth`` · distance of each of
        ``regions``) [m]. The mesh must depend on ``sizes`` and the scene alone. Called only where ``capabilities``
        has ``"adapts"``.
        """
        raise NotImplementedError(f"{self.name} keeps its mesh")


class ParticleEngine(_Engine):
    """A solver that takes the particle seat: m dv/dt = m g + q − γ v + contacts."""

    def configure(self, scene, grains):
        """Take the scene's part and the initial :class:`sillage.Grains`; return those that will be
        run, or ``None`` for the same ones. ``scene`` has the keys of ``ParticleScene``; d is ``scene["dimension"]``.
        Each of ``scene["walls"]`` has d ``corners`` of d numbers: a segment with the grains on its left, or a triangle
        with the grains on the side from which its corners are seen clockwise.
        """
        raise NotImplementedError

    def advance(self, request, inputs, outputs):
        """Compute a candidate from the accepted state, which must not change.

        ``inputs`` (:class:`sillage.Fields`, g grains in d dimensions): ``grain_drag`` γ [kg/s, g],
        ``grain_force`` q [N, g × d]. ``outputs``: ``grain_position`` [m, g × d], ``grain_velocity`` at the
        end [m/s, g × d], ``grain_mean_velocity`` (displacement over dt, before periodic wrapping) [m/s, g × d],
        ``grain_contact`` (0 free, 1 touches, 2 held by a wall) [g], with the capability ``"spin"`` also
        ``grain_spin`` [rad/s; g in the plane, counter-clockwise; g × 3 in space]; all must be written.

        Returns a :class:`sillage.ParticleReport` with the sub-steps that were taken (1 where the step is
        not cut): the coupler models the drag over them. Exceptions as in :meth:`FluidEngine.advance`.
        """
        raise NotImplementedError

    def remove(self, gone):
        """Take grains out of the accepted state, between a commit and the next step: ``gone`` are their
        numbers in the present order, ascending. The others keep their order; return them as they are now
        (:class:`sillage.Grains`; :meth:`sillage.Grains.without` helps). Called only where
        ``capabilities`` has ``"removes-grains"``.
        """
        raise NotImplementedError(f"{self.name} keeps all grains")


def run_fluid(engine):
    """Serve the run named by the environment (``SILLAGE_RUN``) until it ends; returns the exit code
    (protocol/README.md). Call it on the main thread: ``sys.exit(sillage.run_fluid(MyEngine()))``."""
    return _native.run("fluid", Seat(engine, "fluid"))


def run_particles(engine):
    """The same for a particle engine."""
    return _native.run("particles", Seat(engine, "particles"))
