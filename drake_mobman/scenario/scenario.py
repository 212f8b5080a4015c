"""What all scenarios say: a robot, where it starts, and for how long."""

import dataclasses as dc
import typing
from typing import Any, ClassVar, Self

from pydrake.common.yaml import yaml_load_typed

from drake_mobman.base import Smoothing
from drake_mobman.parameters import PERIOD, TIME, ParameterError, within
from drake_mobman.robot_model import RobotDescription, RobotSetup, WorkspaceLimits
from drake_mobman.robot_model.base_limits import check_base
from drake_mobman.robots import Fidelity, Robot
from drake_mobman.robots.defaults import Start, default_member, own
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.robots.planar import Planar
from drake_mobman.scenario.fit import REACHED, below, check_joints, check_workspace
from drake_mobman.scenario.layers import with_defaults
from drake_mobman.scenario.schema import NOT_IN_YAML, dump_yaml, plain
from drake_mobman.ticks import last_tick

OF_ROBOT: Any = None
"""Stands for what the robot brings along, until a scenario is made."""


@dc.dataclass
class Scenario:
    """A robot, where it starts, and for how long: what all scenarios say."""

    decided_by: ClassVar[str] = "robot"  # What other keys are by default, that is.

    description: str = ""  # One line for `mobman list`.
    duration: float = 16.0  # How long [s].
    period: float = 0.01  # Control period; at `Kinematic` the Euler step too [s].
    fidelity: Fidelity = dc.field(default_factory=Kinematic)  # With masses or not.
    compiled: bool = False  # Whether blocks run without Python where that goes.
    robot: Robot = dc.field(default_factory=Planar)  # Which robot, and its lengths.
    start: Start = OF_ROBOT  # Of base and end effector.
    workspace: WorkspaceLimits = OF_ROBOT  # That the arm is to keep.
    smoother: Smoothing = OF_ROBOT  # Of the base's command.
    # Of its file, or of the run folder that the file is in.
    name: str = dc.field(default="", compare=False, metadata=NOT_IN_YAML)

    def __post_init__(self) -> None:
        """Takes from the robot what is not given."""
        brought = self.own(self.robot)
        for field in dc.fields(self):
            if getattr(self, field.name) is OF_ROBOT:
                members: Any = typing.get_args(field.type) or (field.type,)
                setattr(self, field.name, default_member(brought, members))

    @classmethod
    def own(cls, robot: RobotDescription) -> dict[type, Any]:
        """Returns what the robot brings to such a scenario, by its class."""
        return own(robot)

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Returns YAML data of such a scenario with what it leaves to its robot."""
        named = {key: value for key, value in data.items() if key == cls.decided_by}
        robot = yaml_load_typed(schema=cls, data=dump_yaml(named)).robot
        given = with_defaults(data, cls, cls.own(robot))
        return plain(cls(robot=robot), cls) | given

    def setup(self) -> RobotSetup:
        """Returns the robot as blocks are built for it; its model is parsed anew."""
        return RobotSetup.of(
            self.robot,
            self.period,
            workspace=self.workspace,
            base_limits=self.smoother.limits(),
            compiled=self.compiled,
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
        setup = self.setup()
        self.start_position(setup)
        check_workspace(self.workspace, self.start, setup)
        with below("smoother"):
            check_base(self.smoother, setup.model.base_limits)
        self.check_fit(setup)
        whole = self.in_whole_steps()
        whole.build_all(dc.replace(setup, period=whole.period))

    def check_fit(self, setup: RobotSetup) -> None:
        """Raises `ParameterError` where such a scenario does not fit its robot."""

    def build_all(self, setup: RobotSetup) -> None:
        """Builds each block that a parameter goes into, to see that it can be built.

        Raises:
            ParameterError: names the parameter that a block cannot work with.
        """
        raise NotImplementedError

    def in_whole_steps(self) -> Self:
        """Returns the same with its period whole steps of the plant to the last bit.

        So it is simulated; the two are a few bits off what was wanted, at most.
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
        # An arm that is out of reach stands at the nearest point that it reaches.
        if max(abs(a - b) for a, b in zip(nearest, place, strict=True)) > REACHED:
            l, psi, z = (round(x, 4) + 0.0 for x in nearest)
            valid = f"out of reach; the nearest is l = {l}, psi = {psi}, z = {z}"
            named = dict(zip(("l", "psi", "z"), place, strict=True))
            raise ParameterError("start", named, valid)
        check_joints(q, "start", setup.model)
        return [at.x, at.y, at.theta, *q]
