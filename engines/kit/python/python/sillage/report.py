"""What an engine tells of a candidate beside its fields."""

from dataclasses import dataclass, field


@dataclass
class FluidReport:
    """What a fluid engine tells; all of it may be left out."""

    #: Power of the solid's terms as the equations had them [W; in the plane W/m]: the coupler's energy
    #: balance compares it with its own.
    solid_power: float | None = None
    #: Reynolds number by which the engine judges whether convection matters.
    reynolds: float | None = None
    #: Was v·∇v in the equations?
    convects: bool | None = None
    #: Numbers for people: name to finite number, SI units.
    diagnostics: dict = field(default_factory=dict)

    def _numbers(self):
        convects = None if self.convects is None else bool(self.convects)
        return (_or_none(self.solid_power), _or_none(self.reynolds), convects)


@dataclass
class ParticleReport:
    """What a particle engine tells."""

    #: Sub-steps that were taken: the coupler models the drag over them, so there is no default.
    sub_steps: int
    #: Contacts that carry an impulse.
    touching: int | None = None
    #: Numbers for people: name to finite number, SI units.
    diagnostics: dict = field(default_factory=dict)

    def _numbers(self):
        sub_steps = int(self.sub_steps)
        if sub_steps < 1 or sub_steps != self.sub_steps:
            raise ValueError(f"sub_steps of the report is {self.sub_steps}, must be a whole number from 1 on")
        return (sub_steps, None if self.touching is None else int(self.touching))


def _or_none(value):
    return None if value is None else float(value)
