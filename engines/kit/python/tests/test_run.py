"""Engines in whole runs: processes, shared memory, exit codes. Needs `cargo build --release`."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
SILLAGE = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "sillage"
pytestmark = pytest.mark.skipif(not SILLAGE.exists(), reason="sillage is not built: cargo build --release")

SCENE = """
[run]
end_time = 0.05
coupling_step = 0.01
[gravity]
acceleration = [0.0, -9.81]
[[grains]]
density = 2500.0
radius = 0.005
lattice = { lower = [0.0, 0.0], upper = [0.1, 0.1], spacing = 0.02, pattern = "square", seed = 1 }
[particles.domain]
lower = [0.0, 0.0]
upper = [0.1, 0.2]
[contact]
friction = 0.0
tolerance = 1e-3
[engines]
particles = { command = %r }
[output]
frames = false
"""


def readme_engine():
    """The example of the README, as it stands there."""
    text = (ROOT / "engines/kit/python/README.md").read_text()
    return text.split("```python\n")[1].split("```")[0]


def run(folder, program):
    program = "import os\nprint('run', os.environ['SILLAGE_RUN'], flush=True)\n" + program
    (folder / "engine.py").write_text(program)
    (folder / "scene.toml").write_text(SCENE % [sys.executable, "engine.py"])
    done = subprocess.run(
        [SILLAGE, "run", folder / "scene.toml", "--out", folder / "out"], capture_output=True, text=True, timeout=60
    )
    log = (folder / "out/logs/particles.log").read_text()
    name = log.split()[1]
    assert not [left for left in os.listdir("/dev/shm") if name in left]
    return done.returncode, done.stderr + done.stdout, log


def test_the_example_of_the_readme_runs(tmp_path):
    code, words, _ = run(tmp_path, readme_engine())
    assert code == 0, words
    rows = (tmp_path / "out/steps.csv").read_text().splitlines()
    last = dict(zip(rows[0].split(","), rows[-1].split(",")))
    assert abs(float(last["fall_speed"]) - 9.81 * 0.05) < 1e-12


@pytest.mark.parametrize(
    "line, code, text",
    [
        ("raise sillage.NotConverged('9 sweeps, residual 0.1')", 8, "9 sweeps, residual 0.1"),
        ("raise sillage.NotFinite('grain 3 is lost')", 7, "grain 3 is lost"),
        ("raise RuntimeError('no such grain')", 4, "RuntimeError: no such grain (engine.py:"),
        ("self.kept = outputs.grain_position", 4, "ViewError: an array over grain_position"),
        ("outputs.grain_contact[7] = float('nan')", 7, "grain_contact"),
        ("import os; os._exit(9)", 4, "exit code 9"),
    ],
)
def test_what_goes_wrong_in_a_step_ends_the_run_with_its_reason(tmp_path, line, code, text):
    # after the candidate is written, in the third step
    program = readme_engine().replace(
        "        self.candidate = ", f"        if request.step == 3:\n            {line}\n        self.candidate = "
    )
    found, words, _ = run(tmp_path, program)
    assert found == code, words
    assert text in words


def test_a_scene_that_the_engine_refuses_has_exit_code_2(tmp_path):
    program = readme_engine().replace(
        "        self.gravity, self.grains", "        raise sillage.SceneError('friction is 0')\n        self.gravity, self.grains"
    )
    code, words, _ = run(tmp_path, program)
    assert code == 2 and "friction is 0" in words, words


def test_an_array_kept_beyond_the_run_can_still_be_read(tmp_path):
    """Its error ended the run; its memory is still mapped in the process that kept it."""
    program = readme_engine().replace(
        "        self.candidate = ", "        self.kept = outputs.grain_position, inputs.grain_force\n        self.candidate = "
    )
    program = program.replace(
        "sys.exit(sillage.run_particles(Falling()))",
        "engine = Falling()\n"
        "code = sillage.run_particles(engine)\n"
        "print('read', engine.kept[0].shape, float(engine.kept[0].sum()) > 0.0, flush=True)\n"
        "sys.exit(code)\n",
    )
    code, words, log = run(tmp_path, program)
    assert code == 4, words
    assert "read (25, 2) True" in log, log
