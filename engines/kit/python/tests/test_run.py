"""Engines in whole runs: processes, shared memory, exit codes. Needs `cargo build --release`."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
SILLAGE = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "sillage"
SPACE = ROOT / "orchestration/sillage/tests/engines/space.toml"
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


IN_SPACE = """
[run]
end_time = 0.1
coupling_step = 0.002
[gravity]
acceleration = [0.0, -9.81, 0.0]
[fluid]
density = 1000.0
dynamic_viscosity = 1e-3
domain.box = { lower = [0.0, 0.0, 0.0], upper = [0.02, 0.02, 0.02], cells = [4, 4, 4] }
boundaries.all = "no-slip"
[[grains]]
density = 1000.0
radius = 2e-4
velocity = [0.01, 0.05, -0.02]
lattice = { lower = [2e-3, 1.5e-3, 9e-3], upper = [4e-3, 7e-3, 11e-3], spacing = 1e-3, pattern = "cubic" }
[contact]
friction = 0.0
tolerance = 1e-3
[coupling]
scheme = "staggered"
reaction = false
[engines]
fluid = { command = %r }
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


def test_both_engines_make_a_run_in_space_whose_grains_move_with_the_stream(tmp_path):
    stream = ROOT / "engines/kit/python/examples/stream.py"
    (tmp_path / "falling.py").write_text(readme_engine())
    fluid = [sys.executable, str(stream), "0.01", "0.05", "-0.02"]
    (tmp_path / "scene.toml").write_text(IN_SPACE % (fluid, [sys.executable, "falling.py"]))
    command = [SILLAGE, "run", tmp_path / "scene.toml", "--out", tmp_path / "out"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    names, *rows = [line.split(",") for line in (tmp_path / "out/steps.csv").read_text().splitlines()]
    column = {name: [float(row[k]) for row in rows] for k, name in enumerate(names) if rows[0][k]}
    duration = column["time"][-1] - column["time"][0]
    speed = [(column[f"centre_{axis}"][-1] - column[f"centre_{axis}"][0]) / duration for axis in "xyz"]
    print(f"\nspheres move at {speed} m/s")
    assert max(abs(found - given) for found, given in zip(speed, (0.01, 0.05, -0.02))) < 1e-9


@pytest.mark.parametrize("seat", ["fluid", "particles"])
def test_the_examples_pass_every_check_in_space(seat, tmp_path):
    (tmp_path / "falling.py").write_text(readme_engine())
    stream = ROOT / "engines/kit/python/examples/stream.py"
    words = {"fluid": [stream, "0.01", "0.0", "0.02"], "particles": [tmp_path / "falling.py"]}[seat]
    command = [SILLAGE, "conform", "--as", seat, "--scene", SPACE, "--", sys.executable, *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    print(done.stdout)
    assert done.returncode == 0 and " 0 failed" in done.stdout


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
