"""Fields are views of the transport's memory; none can be used, or kept, beyond its step."""

import gc
import time
import weakref

import numpy as np
import pytest

import sillage
from sillage.testing import EngineFailed, ParticleDriver, particle_scene


class Falling(sillage.ParticleEngine):
    """Grains that fall and meet nobody; ``on_advance`` may do harm before the answer is written."""

    name = "falling"

    def __init__(self, on_advance=None):
        self.on_advance = on_advance
        self.kept = []

    def configure(self, scene, grains):
        self.gravity, self.grains = np.array(scene["gravity"]), grains

    def advance(self, request, inputs, outputs):
        g, dt = self.grains, request.dt
        mass, drag = g.mass[:, None], inputs.grain_drag[:, None]
        pulled = mass * g.velocity + dt * (mass * self.gravity + inputs.grain_force)
        velocity = pulled / (mass + dt * drag)
        outputs.grain_velocity[:] = velocity
        outputs.grain_mean_velocity[:] = velocity
        outputs.grain_position[:] = g.position + dt * velocity
        outputs.grain_contact[:] = 0.0
        self.candidate = (g.position + dt * velocity, velocity)
        if self.on_advance:
            self.on_advance(self, inputs, outputs)
        energy = 0.5 * (g.mass * (velocity**2).sum(1)).sum()
        return sillage.ParticleReport(1, diagnostics={"kinetic_energy": energy})

    def commit(self):
        self.grains.position, self.grains.velocity = self.candidate


def some_grains(count=5):
    ones = np.ones(count)
    rest = np.zeros((count, 2))
    return sillage.Grains(np.arange(2.0 * count).reshape(-1, 2), rest, 0.1 * ones, 2 * ones, ones, 0 * ones)


def driver_of(engine):
    driver = ParticleDriver(engine)
    assert driver.configure(particle_scene(), some_grains()) == 5
    return driver


def advance(driver):
    return driver.advance(0.1, grain_drag=np.full(5, 3.0), grain_force=np.ones((5, 2)))


def test_a_step_gives_what_the_engine_wrote():
    with driver_of(Falling()) as driver:
        for _ in range(3):
            candidate = advance(driver)
            driver.commit()
        assert candidate.grain_position.shape == (5, 2)
        assert candidate.diagnostics["kinetic_energy"] > 0.0
        assert {"cpu_seconds", "wall_seconds"} <= set(candidate.diagnostics)
        v = 0.0
        for _ in range(3):
            v = (2.0 * v + 0.1 * (2.0 * -9.81 + 1.0)) / 2.3
        assert np.allclose(candidate.grain_velocity[:, 1], v, rtol=1e-15)


def test_spins_are_asked_of_engines_that_declare_them():
    def spin(engine, inputs, outputs):
        outputs.grain_spin[:] = np.arange(5.0)

    engine = Falling(spin)
    engine.capabilities = ("spin",)
    with driver_of(engine) as driver:
        assert (advance(driver).grain_spin == np.arange(5.0)).all()
    with driver_of(Falling()) as driver:
        assert "grain_spin" not in advance(driver)


def test_fields_are_views_without_a_copy():
    seen = {}

    def look(_, inputs, outputs):
        seen["same"] = np.shares_memory(inputs.grain_force, inputs.grain_force)
        seen["own"] = inputs.grain_force.flags.owndata or outputs.grain_contact.flags.owndata
        seen["type"] = type(inputs.grain_force), inputs.grain_force.dtype
        seen["shape"] = inputs.grain_force.shape, inputs.grain_drag.shape
        seen["aligned"] = inputs.grain_force.ctypes.data % 64

    with driver_of(Falling(look)) as driver:
        advance(driver)
    assert seen["same"] and not seen["own"]
    assert seen["type"] == (np.ndarray, np.float64)
    assert seen["shape"] == ((5, 2), (5,))


def test_inputs_cannot_be_written():
    raised = []

    def write(_, inputs, outputs):
        force = inputs.grain_force
        for attempt in (
            lambda: force.__setitem__(0, 1.0),
            lambda: force.setflags(write=True),
            lambda: memoryview(force).__setitem__((0, 0), 1.0),
        ):
            with pytest.raises((ValueError, TypeError)) as error:
                attempt()
            raised.append(str(error.value))
            error = None
        with pytest.raises(AttributeError, match=r"outputs.grain_contact\[:\]"):
            outputs.grain_contact = 0.0

    with driver_of(Falling(write)) as driver:
        advance(driver)
    assert len(raised) == 3


def test_absent_inputs_have_their_default():
    seen = {}

    def look(_, inputs, outputs):
        seen["given"] = inputs.given
        seen["drag"] = inputs.grain_drag.copy()
        with pytest.raises(ValueError):
            inputs.grain_drag[0] = 1.0

    with driver_of(Falling(look)) as driver:
        driver.advance(0.1, grain_force=np.ones((5, 2)))
    assert seen["given"] == {"grain_force"}
    assert (seen["drag"] == 0.0).all() and seen["drag"].shape == (5,)


def test_fields_asked_for_after_their_step_are_an_exception():
    engine = Falling(lambda self, inputs, outputs: self.kept.append((inputs, outputs)))
    with driver_of(engine) as driver:
        advance(driver)
        driver.commit()
        inputs, outputs = engine.kept[0]
        for name in ("grain_force", "grain_drag"):
            with pytest.raises(sillage.ViewError, match=name):
                getattr(inputs, name)
        with pytest.raises(sillage.ViewError, match="grain_position"):
            outputs.grain_position
        advance(driver)  # and nothing is broken


@pytest.mark.parametrize(
    "keep, name",
    [
        (lambda i, o: i.grain_force, "grain_force"),
        (lambda i, o: i.grain_drag[1:3], "grain_drag"),
        (lambda i, o: i.grain_force.T.reshape(2, 5)[0], "grain_force"),
        (lambda i, o: o.grain_position, "grain_position"),
        (lambda i, o: memoryview(o.grain_contact), "grain_contact"),
        (lambda i, o: iter(o.grain_velocity[:, 0]), "grain_velocity"),
    ],
)
def test_an_array_kept_beyond_its_step_is_an_error_and_its_memory_stays(keep, name):
    engine = Falling(lambda self, inputs, outputs: self.kept.append(keep(inputs, outputs)))
    driver = driver_of(engine)
    with pytest.raises(EngineFailed, match=f"ViewError.*{name}"):
        advance(driver)
    # asked again it says so instead of crashing
    with pytest.raises(EngineFailed):
        advance(driver)
    driver.close()
    del driver
    gc.collect()
    kept = engine.kept[0]
    values = np.fromiter(kept, float) if hasattr(kept, "__next__") else np.array(kept)
    assert np.isfinite(values).all()
    if name == "grain_force":
        assert (values == 1.0).all()


def test_a_copy_may_be_kept():
    engine = Falling(lambda self, inputs, outputs: self.kept.append(inputs.grain_force.copy()))
    with driver_of(engine) as driver:
        advance(driver)
        driver.commit()
        advance(driver)
    assert (engine.kept[0] == 1.0).all()


def test_garbage_in_a_cycle_is_no_kept_array():
    def cycle(_, inputs, outputs):
        loop = [inputs.grain_force]
        loop.append(loop)

    gc.disable()
    try:
        with driver_of(Falling(cycle)) as driver:
            advance(driver)
            driver.commit()
            advance(driver)
    finally:
        gc.enable()


def test_an_exception_that_holds_arrays_in_its_traceback_is_no_kept_array():
    calls = []

    def fail(_, inputs, outputs):
        force = inputs.grain_force
        calls.append(force.sum())
        if len(calls) == 1:
            raise sillage.NotConverged("residual 1e-2 after 30 sweeps, asked 1e-3")

    with driver_of(Falling(fail)) as driver:
        with pytest.raises(sillage.NotConverged, match="30 sweeps"):
            advance(driver)
        advance(driver)
        driver.commit()
    assert len(calls) == 2


def test_an_engine_is_freed_with_its_driver():
    engine = Falling()
    driver = driver_of(engine)
    advance(driver)
    driver.close()
    watch = weakref.ref(engine)
    del engine, driver
    # its thread is about to end
    for _ in range(100):
        gc.collect()
        if watch() is None:
            return
        time.sleep(0.02)
    pytest.fail("the engine is still there")


class Leaving(Falling):
    """The same, and grains may leave."""

    capabilities = ("removes-grains",)

    def remove(self, gone):
        self.grains = self.grains.without(gone)
        return self.grains


def test_grains_leave_and_the_others_go_on():
    driver = driver_of(Leaving())
    before = advance(driver).grain_position
    driver.commit()
    assert driver.remove([1, 4]) == 3
    after = driver.advance(0.1, grain_drag=np.full(3, 3.0), grain_force=np.ones((3, 2)))
    fallen = after.grain_position - 0.1 * after.grain_mean_velocity
    np.testing.assert_allclose(fallen, before[[0, 2, 3]])
    driver.commit()
    assert driver.remove([0]) == 2


def test_an_engine_that_keeps_all_fails_when_grains_leave():
    driver = driver_of(Falling())
    advance(driver)
    driver.commit()
    with pytest.raises(EngineFailed, match="falling keeps all grains"):
        driver.remove([0])
