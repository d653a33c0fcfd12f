"""What an engine does wrong is told with its place; what the scene does wrong never reaches it."""

import numpy as np
import pytest

import sillage
from sillage.testing import EngineFailed, FluidDriver, ParticleDriver, fluid_scene, particle_scene
from test_views import Falling, advance, driver_of, some_grains

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


class Still(sillage.FluidEngine):
    """A fluid at rest on two triangles."""

    name = "still"
    capabilities = ("affine-response",)

    def configure(self, scene):
        self.weight = scene["density"] * np.array(scene["gravity"])
        return sillage.Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]])

    def advance(self, request, inputs, outputs):
        outputs.interstitial_velocity[:] = 0.0
        outputs.pressure_gradient[:] = self.weight
        outputs.pressure[:] = SQUARE @ self.weight * inputs.porosity

    def commit(self):
        pass


def test_a_fluid_engine_gives_its_mesh_and_its_fields():
    with FluidDriver(Still()) as driver:
        mesh = driver.configure(fluid_scene())
        assert np.allclose(mesh["nodal_mass"], [1 / 3, 1 / 6, 1 / 3, 1 / 6])
        candidate = driver.advance(0.1)
        assert np.allclose(candidate.pressure, [0, 0, -9810, -9810])
        candidate = driver.advance(0.1, porosity=np.full(4, 0.5))
        assert np.allclose(candidate.pressure, [0, 0, -4905, -4905])
        driver.commit()


@pytest.mark.parametrize(
    "raised, expected, text",
    [
        (sillage.NotConverged("9 passes"), sillage.NotConverged, "^9 passes$"),
        (sillage.NotFinite("node 3"), sillage.NotFinite, "^node 3$"),
        (ValueError("no such thing"), EngineFailed, r"^ValueError: no such thing \(test_errors.py:\d+\)$"),
        (KeyboardInterrupt(), EngineFailed, "KeyboardInterrupt"),
        (SystemExit(3), EngineFailed, "SystemExit"),
    ],
)
def test_exceptions_become_failures(raised, expected, text):
    def fail(*_):
        raise raised

    with driver_of(Falling(fail)) as driver:
        with pytest.raises(expected, match=text):
            advance(driver)


def test_a_scene_that_cannot_be_used_is_named():
    class Picky(Falling):
        def configure(self, scene, grains):
            if scene["friction"] > 0.0:
                raise sillage.SceneError("contact.friction is 0.3: this engine has none")

    with ParticleDriver(Picky()) as driver:
        with pytest.raises(sillage.SceneError, match="contact.friction is 0.3"):
            driver.configure(particle_scene(friction=0.3), some_grains())


@pytest.mark.parametrize("forgotten", ["grain_position", "grain_velocity", "grain_mean_velocity", "grain_contact"])
def test_an_output_that_was_not_written_is_refused_with_its_name(forgotten):
    def spoil(_, inputs, outputs):
        getattr(outputs, forgotten)[-1] = np.nan

    with driver_of(Falling(spoil)) as driver:
        with pytest.raises(sillage.NotFinite, match=f"{forgotten}.*grain 4"):
            advance(driver)


def test_a_diagnostic_that_is_not_finite_is_refused():
    class Odd(Falling):
        def advance(self, request, inputs, outputs):
            super().advance(request, inputs, outputs)
            return sillage.ParticleReport(1, diagnostics={"energy": float("inf")})

    with driver_of(Odd()) as driver:
        with pytest.raises(sillage.NotFinite, match="energy is inf"):
            advance(driver)


def test_a_wrong_shape_is_an_exception_of_the_engine():
    def spoil(_, inputs, outputs):
        outputs.grain_position[:] = np.zeros((4, 2))

    with driver_of(Falling(spoil)) as driver:
        with pytest.raises(EngineFailed, match="ValueError.*broadcast"):
            advance(driver)


def test_an_unknown_field_is_named_with_those_that_exist():
    def spoil(_, inputs, outputs):
        inputs.grain_temperature

    with driver_of(Falling(spoil)) as driver:
        with pytest.raises(EngineFailed, match="grain_temperature.*grain_drag"):
            advance(driver)


@pytest.mark.parametrize(
    "nodes, triangles, text",
    [
        (SQUARE, [[0, 2, 1]], "counter-clockwise"),
        (SQUARE, [[0, 1, 4]], "from 0 to 3"),
        (SQUARE.ravel(), [[0, 1, 2]], "n × 2"),
        (SQUARE * np.nan, [[0, 1, 2]], r"nodes\[0, 0\] is nan"),
    ],
)
def test_a_mesh_that_is_none_is_refused(nodes, triangles, text):
    with pytest.raises(ValueError, match=text):
        sillage.Mesh(nodes, triangles)


def test_a_capability_that_does_not_exist_is_refused():
    engine = Falling()
    engine.capabilities = ("telepathy",)
    with pytest.raises(ValueError, match="telepathy.*implicit-drag"):
        ParticleDriver(engine)


def test_without_a_run_the_exit_code_tells_so(monkeypatch, capfd):
    monkeypatch.delenv("SILLAGE_RUN", raising=False)
    assert sillage.run_particles(Falling()) == 3
    assert "SILLAGE_RUN" in capfd.readouterr().err
