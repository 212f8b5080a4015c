"""What all scenarios have: a robot, its start, and a duration."""

import dataclasses as dc
import typing
from typing import Any, ClassVar, Self

from pydrake.common.yaml import yaml_load_typed

from drake_mobman.base import Smoothing
from drake_mobman.engines import Engine
from drake_mobman.engines.drake import Drake
from drake_mobman.parameters import PERIOD, TIME, ParameterError, within
from drake_mobman.robot_model import RobotDescription, RobotSetup, WorkspaceLimits
from drake_mobman.robot_model.base_limits import check_base
from drake_mobman.robots import Fidelity, Robot
from drake_mobman.robots.defaults import Start, default_member, robot_defaults
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.robots.planar import Planar
from drake_mobman.scenario.fit import REACHED, below, check_joints, check_workspace
from drake_mobman.scenario.layers import with_defaults
from drake_mobman.schema import NOT_IN_YAML, dump_yaml, plain
from drake_mobman.ticks import last_tick

OF_ROBOT: Any = None
"""Placeholder for the robot's default, until a scenario is made."""


@dc.dataclass
class Scenario:
    """A robot, its start, and a duration."""

    decided_by: ClassVar[str] = "robot"  # Key that other keys' defaults depend on.

    description: str = ""  # One line for `mobman list`.
    duration: float = 16.0  # Of the run [s].
    period: float = 0.01  # Control period; at `Kinematic` the Euler step too [s].
    fidelity: Fidelity = dc.field(default_factory=Kinematic)  # With masses or not.
    engine: Engine = dc.field(default_factory=Drake)  # Steps the robot, with masses.
    compiled: bool = False  # Whether blocks are compiled, where possible.
    robot: Robot = dc.field(default_factory=Planar)  # The robot, and its lengths.
    start: Start = OF_ROBOT  # Of base and end effector.
    workspace: WorkspaceLimits = OF_ROBOT  # Limits for the arm.
    smoother: Smoothing = OF_ROBOT  # Of the base command.
    # Of its file, or of the run folder that the file is in.
    name: str = dc.field(default="", compare=False, metadata=NOT_IN_YAML)

    def __post_init__(self) -> None:
        """Fills in the robot's defaults."""
        defaults = self.robot_defaults(self.robot)
        for field in dc.fields(self):
            if getattr(self, field.name) is OF_ROBOT:
                members: Any = typing.get_args(field.type) or (field.type,)
                setattr(self, field.name, default_member(defaults, members))

    @classmethod
    def robot_defaults(cls, robot: RobotDescription) -> dict[type, Any]:
        """Returns the robot's defaults for such a scenario, by their class."""
        return robot_defaults(robot)

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Returns YAML data of such a scenario with the robot's defaults filled in."""
        named = {key: value for key, value in data.items() if key == cls.decided_by}
        robot = yaml_load_typed(schema=cls, data=dump_yaml(named)).robot
        given = with_defaults(data, cls, cls.robot_defaults(robot))
        return plain(cls(robot=robot), cls) | given

    def setup(self) -> RobotSetup:
        """Returns the robot's setup; each call parses the model again."""
        return RobotSetup.of(
            self.robot,
            self.period,
            workspace=self.workspace,
            base_limits=self.smoother.limits(),
            compiled=self.compiled,
            engine=self.engine,
        )

    def check(self) -> None:
        """Raises `ParameterError` unless it can be run."""
        within(self, PERIOD, "period")
        within(self, TIME, "duration")
        if last_tick(self.duration, self.period) < 1:
            raise ParameterError(
                "duration", self.duration, f"must be at least period = {self.period!r}"
            )
        with below("fidelity"):
            self.fidelity.check_period(self.period)
        if self.engine.needs_masses and not self.fidelity.has_masses:
            names = (f"!{type(x).__name__}" for x in (self.engine, self.fidelity))
            valid = "needs a fidelity with masses, as !Servo is; fidelity is"
            raise ParameterError("engine", next(names), f"{valid} {next(names)}")
        setup = self.setup()
        self.start_position(setup)
        check_workspace(self.workspace, self.start, setup)
        with below("smoother"):
            check_base(self.smoother, setup.model.base_limits)
        if hasattr(self.fidelity, "check_upright"):
            self.fidelity.check_upright(setup, self.start.z)
        self.check_fit(setup)
        whole = self.in_whole_steps()
        whole.build_all(dc.replace(setup, period=whole.period))

    def check_fit(self, setup: RobotSetup) -> None:
        """Raises `ParameterError` where the scenario does not fit its robot."""

    def build_all(self, setup: RobotSetup) -> None:
        """Builds each block once, to check its parameters.

        Raises:
            ParameterError: names the parameter that a block cannot work with.
        """
        raise NotImplementedError

    def in_whole_steps(self) -> Self:
        """Returns the scenario as it is simulated.

        Its period is an exact multiple of the plant's step; both differ from the given
        ones in the last bits at most.
        """
        period, fidelity = self.fidelity.aligned_with(self.period)
        return dc.replace(self, period=period, fidelity=fidelity)

    def start_position(self, setup: RobotSetup) -> list[float]:
        """Returns the positions (3 + n,) of base and arm at the start.

        Raises:
            ParameterError: where the arm does not reach the start.
        """
        at = self.start
        place = (at.l, at.psi, at.z)
        q = setup.arm.inverse(place)
        nearest = setup.arm.ee_cylindrical(q)
        # Where the start is out of reach, the inverse returns the nearest point.
        if max(abs(a - b) for a, b in zip(nearest, place, strict=True)) > REACHED:
            l, psi, z = (round(x, 4) + 0.0 for x in nearest)
            valid = f"out of reach; the nearest is l = {l}, psi = {psi}, z = {z}"
            named = dict(zip(("l", "psi", "z"), place, strict=True))
            raise ParameterError("start", named, valid)
        check_joints(q, "start", setup.model)
        return [at.x, at.y, at.theta, *q]
