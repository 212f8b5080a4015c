"""A new kind of anything is one new file and one line.

In a copy of the package, one of each is added; then it is listed, run, compared, drawn
and offered in the console without another change.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import drake_mobman
from drake_mobman import diagrams, scenarios

RECIPES = {
    "decomposers/halving": (
        "from drake_mobman.decomposers.halving import Halving",
        '''
        """Base and arm make half of the command each."""

        import dataclasses as dc

        from drake_mobman.blocks import scalar_block
        from drake_mobman.decomposers.decomposer import ShareDecomposer
        from drake_mobman.decomposers.projection import Projection


        @dc.dataclass
        class Halving:
            half: float = 0.5  # The base's share.
            projection: Projection = dc.field(default_factory=Projection)

            def shares(self, limits, command, at):
                return self.half, self.half

            def build(self, setup):
                return HalvingDecomposer(self, setup.workspace, setup.arm.num_joints)


        @scalar_block
        class HalvingDecomposer(ShareDecomposer):
            """Base and arm make half of the command each."""
        ''',
    ),
    "base/turning_only": (
        "from drake_mobman.base.turning_only import TurningOnly",
        '''
        """The base turns towards T, and never drives."""

        import dataclasses as dc

        import numpy as np
        from pydrake.math import atan2
        from pydrake.systems.framework import LeafSystem

        from drake_mobman.blocks import scalar_block


        @dc.dataclass
        class TurningOnly:
            gain: float = 0.5  # Yaw rate per bearing of T [1/s].

            def check_reach(self, reach):
                pass

            def command(self, p_BT, reach, joint):
                return 0.0 * p_BT[0], self.gain * atan2(p_BT[1], p_BT[0]), 0.0

            def build(self, setup):
                return TurningController(self)


        @scalar_block
        class TurningController(LeafSystem):
            def __init__(self, params):
                self.params = params
                self.p_BT = self.DeclareVectorInputPort("p_BT", 3)
                self.DeclareVectorOutputPort("base_command", 2, self.calc)

            def calc(self, context, output):
                v, omega, _ = self.params.command(self.p_BT.Eval(context), None, None)
                output.SetFromVector(np.array([v, omega]))
        ''',
    ),
    "teleop/pushing": (
        "from drake_mobman.teleop.pushing import Pushing",
        '''
        """One push, for good."""

        import dataclasses as dc
        from typing import ClassVar

        from pydrake.systems.framework import DiagramBuilder
        from pydrake.systems.primitives import ConstantVectorSource


        @dc.dataclass
        class Pushing:
            v_c: float = 0.1  # [m/s].
            fed: ClassVar[bool] = False
            finite: ClassVar[bool] = True

            def build(self, period):
                builder = DiagramBuilder()
                push = builder.AddSystem(ConstantVectorSource([self.v_c, 0.0, 0.0]))
                builder.ExportOutput(push.get_output_port(), "ee_command")
                return builder.Build()
        ''',
    ),
    "robots/short": (
        "from drake_mobman.robots.short import Short",
        '''
        """The planar robot with a short arm."""

        import dataclasses as dc

        from drake_mobman.robots.planar import Planar


        @dc.dataclass
        class Short(Planar):
            upper_link: float = 0.5  # [m].
            lower_link: float = 0.5  # [m].
        ''',
    ),
    "robots/slow": (
        "from drake_mobman.robots.slow import Slow",
        '''
        """The kinematic robot by another name."""

        import dataclasses as dc

        from drake_mobman.robots.kinematic import Kinematic


        @dc.dataclass
        class Slow(Kinematic):
            pass
        ''',
    ),
    "engines/telling": (
        "from drake_mobman.engines.telling import Telling",
        '''
        """Drake, and it tells what it steps."""

        import dataclasses as dc
        from typing import ClassVar

        from drake_mobman.engines.drake import Drake


        @dc.dataclass
        class Telling:
            package: ClassVar[str] = "drake"
            needs_masses: ClassVar[bool] = False

            def add_to(self, builder, plant, scene_graph=None):
                print(plant.num_bodies(), "bodies")
                return Drake().add_to(builder, plant, scene_graph)
        ''',
    ),
    "analysis/metrics/way": (
        "from drake_mobman.analysis.metrics.way import Way",
        '''
        """How far the base went."""

        from typing import ClassVar

        import numpy as np

        from drake_mobman.analysis.metrics.metric import Metric


        class Way(Metric):
            group = "base"
            units: ClassVar = {"base_way": "m"}

            def __init__(self):
                self.way = 0.0

            def take(self, window):
                v = window.fresh("base_velocity")[:, 0]
                self.way += window.period * float(np.abs(v).sum())

            def numbers(self):
                return {"base_way": self.way}
        ''',
    ),
    "figures/heading": (
        "from drake_mobman.figures.heading import HEADING",
        '''
        """The base's heading."""

        from drake_mobman.figures.run_figure import RunFigure
        from drake_mobman.figures.style import new_figure


        def draw_heading(run):
            figure = new_figure(2.0)
            figure.subplots().plot(run.log["time"], run.log["base_pose"][:, 2])
            return figure


        HEADING = RunFigure("heading", draw_heading)
        ''',
    ),
}
"""By the new file: the line in its package's `__init__`, and what is in the file."""

SHORT = ["--set", "duration=1"]


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A folder with a copy of the package, one of each kind added to it."""
    folder = tmp_path_factory.mktemp("copy")
    package = folder / "drake_mobman"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(drake_mobman.__file__).parent, package, ignore=ignored)
    for part in (diagrams, scenarios):
        name = part.__name__.rpartition(".")[2]
        source = Path(part.__file__).parent
        shutil.copytree(source, package / name, ignore=ignored, dirs_exist_ok=True)
    for file, (line, text) in RECIPES.items():
        (package / f"{file}.py").write_text(textwrap.dedent(text).lstrip())
        init = (package / file).parent / "__init__.py"
        lines = init.read_text().splitlines()
        # Beside the others of its kind, the last of them.
        kind = line.split(" import ")[0].rpartition(".")[0]
        at = max(
            i for i, x in enumerate(lines) if x.startswith((f"{kind} ", f"{kind}."))
        )
        lines.insert(at + 1, line)
        init.write_text("\n".join(lines) + "\n")
    return folder


@pytest.fixture
def python(copy, tmp_path):
    """A function that runs Python with the copy, and returns what it prints."""

    def run(*arguments):
        command = [sys.executable, *map(str, arguments)]
        ended = subprocess.run(
            command,
            check=False,
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(copy)},
        )
        assert ended.returncode == 0, ended.stderr
        return ended.stdout

    return run


@pytest.fixture
def mobman(python):
    """A function that runs `mobman` of the copy."""
    return lambda *arguments: python("-m", "drake_mobman", *arguments)


def run_of(mobman, tmp_path, *overrides):
    """Runs kwon_1 with overrides; returns its folder and its metrics."""
    settings = [x for override in overrides for x in ("--set", override)]
    mobman("run", "kwon_1", *SHORT, *settings)
    folder = tmp_path / "runs" / "kwon_1"
    return folder, json.loads((folder / "metrics.json").read_text())


def test_a_decomposer_is_run_with_the_metric_and_the_figure(mobman, tmp_path):
    folder, numbers = run_of(mobman, tmp_path, "decomposer=halving", "start.l=1")
    assert "!Halving" in (folder / "scenario.yaml").read_text()
    assert numbers["base_way"] >= 0.0
    assert (folder / "figures" / "heading.png").stat().st_size > 1000


def test_it_is_compared_with_the_others(mobman, tmp_path):
    names = "--decomposers=halving,turningonly,blending"
    mobman("compare", "kwon_1", names, *SHORT)
    page = (tmp_path / "comparison" / "kwon_1" / "comparison.md").read_text()
    for text in ("halving", "turningonly", "base_way"):
        assert text in page


def test_a_robot_a_fidelity_and_a_source_are_run(mobman, tmp_path):
    folder, numbers = run_of(
        mobman, tmp_path, "robot=short", "fidelity=slow", "source=pushing", "start={}"
    )
    text = (folder / "scenario.yaml").read_text()
    assert all(tag in text for tag in ("!Short", "!Slow", "!Pushing"))
    assert numbers["ee_error_rms"] < 1.0


def test_an_engine_is_compared_with_drake(mobman, tmp_path):
    quick = ["--set", "duration=0.1", "--set", "fidelity=wheels"]
    told = mobman("compare", "kwon_franka", "--engine=telling,drake", *quick)
    assert re.search(r"^\d+ bodies$", told, re.MULTILINE)
    numbers = tmp_path / "comparison" / "kwon_franka" / "comparison.json"
    speeds = json.loads(numbers.read_text())["metrics"]["joint_speed_max"]
    assert speeds["telling"] == speeds["drake"]


def test_a_base_controller_guides_and_decomposes(mobman, tmp_path):
    mobman("run", "petric_hold", *SHORT, "--set", "field=turningonly", "--no-figures")
    text = (tmp_path / "runs" / "petric_hold" / "scenario.yaml").read_text()
    assert "!TurningOnly" in text
    run_of(mobman, tmp_path, "decomposer=turningonly", "start.l=1")


def test_all_of_them_are_offered_in_the_console(python):
    program = """
from drake_mobman.console.choices import choice_names, live_scenario
from drake_mobman.scenario import load_scenario
print(choice_names(live_scenario(load_scenario("kwon_1"))))
"""
    offered = python("-c", program)
    assert "halving" in offered
    assert "turningonly" in offered.replace("_", "").replace(" ", "")


def test_what_is_wrong_names_what_is_valid(copy, tmp_path):
    command = [sys.executable, "-m", "drake_mobman", "run", "kwon_1"]
    ended = subprocess.run(
        [*command, "--set", "decomposer=halv"],
        check=False,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(copy)},
    )
    assert ended.returncode == 2
    assert "!Halving" in ended.stderr


def test_a_kind_that_lacks_something_is_refused_at_import(copy, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(copy, broken)
    file = broken / "drake_mobman" / "decomposers" / "halving.py"
    file.write_text(file.read_text().replace("def build(", "def make("))
    ended = subprocess.run(
        [sys.executable, "-c", "import drake_mobman.decomposers"],
        check=False,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(broken)},
    )
    assert "TypeError: Halving lacks build of DecomposerParams" in ended.stderr
