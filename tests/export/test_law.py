"""A controller as C does as its blocks do, and stops where they have no answer."""

import ctypes
import math
import os
import shutil
import subprocess
import sys

import pytest

from drake_mobman.export.law.c_code import number
from drake_mobman.export.law.controller import Controller
from drake_mobman.scenario import ScenarioError, load_scenario

COMPILER = shutil.which("gcc") or shutil.which("clang")

needs_compiler = pytest.mark.skipif(not COMPILER, reason="needs a compiler for C")

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"]

CONTROLLERS = {
    "blending": ("kwon_arbitrary", []),
    "exact": ("kwon_arbitrary", ["decomposer=!Exact {}"]),
    "switching": ("kwon_arbitrary", ["decomposer=!Switching {}"]),
    "field": ("kwon_arbitrary", ["decomposer=!VelocityField {}"]),
    "spatial": ("kwon_spatial", []),
    "jerk limited": ("kwon_spatial", ["smoother=!JerkLimited {}"]),
    "drive that lags": (
        "kwon_spatial",
        ["estimate=!Sent {delay: 0.05, bandwidth: 5.0}"],
    ),
    "franka": ("kwon_franka", ["duration=1.0"]),
    "by odometry": (
        "kwon_franka",
        [
            "robot.orientation=reach",
            "fidelity=!Wheels {}",
            "estimate=!Odometry {}",
            "duration=0.5",
        ],
    ),
}


def controller(name):
    scenario, overrides = CONTROLLERS[name]
    return Controller.of(load_scenario(scenario, overrides))


def written(made, folder):
    for name, content in made.files().items():
        (folder / name).write_bytes(content)
    return folder


def built(made, folder, *flags):
    """Returns the test program of a controller."""
    written(made, folder)
    sources = [f"test_{made.name}.c", f"{made.name}.c"]
    command = [COMPILER, *STRICT, *flags, *sources, "-o", "test", "-lm"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "test"


def ran(*command):
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@needs_compiler
@pytest.mark.parametrize("name", CONTROLLERS)
def test_c_without_a_warning_gives_what_the_blocks_put_out_in_a_run(name, tmp_path):
    said = ran(built(controller(name), tmp_path, "-O1"))
    assert float(said.split()[-1]) < 1e-12


@needs_compiler
def test_a_wrong_number_in_the_vectors_is_found(tmp_path):
    made = controller("exact")
    program = built(made, tmp_path)
    vectors = tmp_path / f"{made.name}_vectors.h"
    head, _, last = vectors.read_text().rpartition(",")
    vectors.write_text(f"{head}, 1.0{last[last.index('}') :]}")
    sources = [f"test_{made.name}.c", f"{made.name}.c"]
    subprocess.run([COMPILER, *sources, "-o", "test", "-lm"], cwd=tmp_path, check=True)
    done = subprocess.run([program], check=False, capture_output=True, text=True)
    assert done.returncode == 1
    assert "tick 499" in done.stdout, done.stdout


@needs_compiler
@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("exact", 200_000),
        ("spatial", 20_000),
        *(
            pytest.param(name, 1_000_000, marks=pytest.mark.slow)
            for name in CONTROLLERS
        ),
    ],
)
def test_no_input_makes_an_output_that_is_not_finite(name, count, tmp_path):
    flags = ["-O1", "-fsanitize=undefined", "-fno-sanitize-recover"]
    program = built(controller(name), tmp_path, *flags)
    said = ran(program, "random", str(count))
    assert f"{count} random inputs" in said
    assert "all outputs finite" in said


def test_two_exports_are_the_same_to_the_last_bit():
    code = (
        "import sys\n"
        "from drake_mobman.export.law.controller import Controller\n"
        "from drake_mobman.scenario import load_scenario\n"
        "for _ in range(2):\n"
        "    made = Controller.of(load_scenario('kwon_1'))\n"
        "for text in made.files().values():\n"
        "    sys.stdout.buffer.write(text)\n"
    )
    texts = {
        subprocess.run(
            [sys.executable, "-c", code],
            check=True,
            capture_output=True,
            env=os.environ | {"PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }
    assert len(texts) == 1
    assert b"_step(" in texts.pop()


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    """Returns a controller as a library, and its state."""
    if not COMPILER:
        pytest.skip("needs a compiler for C")
    folder = tmp_path_factory.mktemp("law")
    made = controller("spatial")
    written(made, folder)
    command = [COMPILER, "-O1", "-shared", "-fPIC", f"{made.name}.c", "-o", "law.so"]
    subprocess.run([*command, "-lm"], cwd=folder, check=True)
    return made, ctypes.CDLL(str(folder / "law.so"))


class Library:
    """A controller in C that is given inputs."""

    def __init__(self, made, library):
        self._step = getattr(library, f"{made.name}_step")
        self._begin = getattr(library, f"{made.name}_start")
        self._state = (ctypes.c_double * 100)()
        self._size = sum(x.size for x in made.law.outputs)

    def start(self, *numbers):
        return self._begin(self._state, (ctypes.c_double * len(numbers))(*numbers))

    def step(self, *numbers):
        out = (ctypes.c_double * self._size)()
        given = (ctypes.c_double * len(numbers))(*numbers)
        return self._step(self._state, given, out), out[:]


def posture(made):
    scenario = made.scenario
    return scenario.start_position(scenario.setup())[3:]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_measurement_that_is_not_finite_is_a_bounded_stop(loaded, bad):
    """The base brakes as it may, and does not jump."""
    made, library = loaded
    law, q = Library(made, library), posture(made)
    assert law.start(0.0, 0.0, 0.0, *q) == 0
    for _ in range(100):
        status, driven = law.step(0.3, 0.1, 0.0, *q)
        assert status == 0
    assert abs(driven[0]) > 0.01 or abs(driven[2]) > 0.01
    steps = round(made.scenario.guard.stop_time / made.law.period) + 60
    lost = [bad, *q[1:]]
    for _ in range(steps):
        status, out = law.step(0.3, 0.1, 0.0, *lost)
        assert status == 1
        assert all(map(math.isfinite, out))
    assert max(map(abs, out[: 2 + len(q)])) < 1e-12


def test_a_start_without_a_measurement_stands_still_until_there_is_one(loaded):
    made, library = loaded
    law, q = Library(made, library), posture(made)
    assert law.start(0.0, 0.0, 0.0, *[math.nan] * len(q)) != 0
    status, out = law.step(0.3, 0.0, 0.0, *[math.nan] * len(q))
    assert (status, set(out)) == (2, {0.0})
    assert law.step(0.3, 0.0, 0.0, *q)[0] == 0


@pytest.mark.parametrize("x", [0.1, -1e-300, 5e-324, 1e308, 3.0, -0.0, 1e22])
def test_numbers_are_written_to_the_last_bit(x):
    text = number(x)
    assert (float.fromhex(text) if "x" in text else float(text)).hex() == x.hex()


def test_a_scenario_that_is_pulled_by_hand_is_refused():
    with pytest.raises(ScenarioError, match="!Guided has no controller as C"):
        Controller.of(load_scenario("petric_guided"))


def test_a_decomposer_that_asks_a_solver_is_refused_by_its_name():
    with pytest.raises(ScenarioError, match="decomposer takes no Expressions"):
        Controller.of(load_scenario("kwon_1", ["decomposer=!Qp {}"]))
