"""What a scenario says, and where it is read from.

Layers, later over earlier: the defaults below, the scenario's file, overrides given as
`key.path=value`.
"""

import dataclasses as dc
import math
import typing
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any, Self

from pydrake.common.yaml import yaml_load_typed

from drake_mobman.arm.closed_form_inverse import INVERSES
from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.decomposers.blending import Blending
from drake_mobman.decomposers.diff_ik import DiffIk
from drake_mobman.decomposers.exact import Exact
from drake_mobman.decomposers.qp import Qp
from drake_mobman.decomposers.share import Projection, WorkspaceLimits
from drake_mobman.decomposers.switching import Switching
from drake_mobman.files import read_file
from drake_mobman.guidance.guiding_hand import Hand, peak_speed
from drake_mobman.parameters import (
    PERIOD,
    SPEED,
    TIME,
    ParameterError,
    one_of,
    quoted,
    within,
)
from drake_mobman.robot_model import Robot, RobotModel
from drake_mobman.robots.defaults import Start, own
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.kinematic import Kinematic
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.servo import Servo
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario.fit import (
    REACHED,
    check_base,
    check_controllers,
    check_joints,
    check_workspace,
)
from drake_mobman.scenario.layers import with_defaults
from drake_mobman.scenario.schema import (
    dump_yaml,
    load_typed,
    load_yaml,
    plain,
    with_override,
)
from drake_mobman.teleop.choice import Transition
from drake_mobman.teleop.drag import Drag
from drake_mobman.teleop.gate import Gate
from drake_mobman.teleop.guard import Guard
from drake_mobman.teleop.live import Operator
from drake_mobman.teleop.recorded import Recording
from drake_mobman.teleop.scripted import Script
from drake_mobman.ticks import aligned, last_tick


@dc.dataclass
class External:
    """The diagram's input port `ee_command` is left to a program."""


@dc.dataclass
class Planned:
    """The hand that pulls goes along its own path."""


OF_ROBOT: Any = None
"""Stands for what the robot brings along, until a scenario is made."""


@dc.dataclass
class Scenario:
    """A robot, where it starts, and for how long: what all scenarios say."""

    description: str = ""  # One line for `mobman list`.
    duration: float = 16.0  # How long [s].
    period: float = 0.01  # Control period; at `Kinematic` the Euler step too [s].
    fidelity: Kinematic | Servo = dc.field(default_factory=Kinematic)
    compiled: bool = False  # Whether blocks run without Python where that goes.
    robot: Planar | Spatial | FrankaTiago = dc.field(default_factory=Planar)
    start: Start = OF_ROBOT
    workspace: WorkspaceLimits = OF_ROBOT
    smoother: Smoother = OF_ROBOT

    def __post_init__(self) -> None:
        """Takes from the robot what is not given."""
        own = self.own(self.robot)
        for field in dc.fields(self):
            if getattr(self, field.name) is OF_ROBOT:
                kind: Any = (typing.get_args(field.type) or (field.type,))[0]
                setattr(self, field.name, own.get(kind) or kind())

    @classmethod
    def own(cls, robot: Robot) -> dict[type, Any]:
        """Returns what the robot brings to such a scenario, by its class."""
        return own(robot)

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Returns YAML data of such a scenario with what it leaves to its robot."""
        named = {key: value for key, value in data.items() if key == "robot"}
        robot = yaml_load_typed(schema=cls, data=dump_yaml(named)).robot
        given = with_defaults(data, cls, cls.own(robot))
        return plain(cls(robot=robot), cls) | given

    def check(self) -> None:
        """Raises `ParameterError` unless it can be run."""
        within(self, PERIOD, "period")
        within(self, TIME, "duration")
        if last_tick(self.duration, self.period) < 1:
            raise ParameterError(
                "duration", self.duration, f"must be at least period = {self.period!r}"
            )
        if isinstance(self.fidelity, Servo):
            try:
                self.fidelity.check_period(self.period)
            except ParameterError as error:
                raise error.below("fidelity") from None
        model = RobotModel(self.robot)
        self.start_position(model)
        check_workspace(self.workspace, self.start, self.robot.arm(), model)
        check_base(self.smoother, "smoother", model)

    def in_whole_steps(self) -> Self:
        """Returns the same with its period whole steps of the plant to the last bit.

        So it is simulated; the two are a few bits off what was asked for, at most.
        """
        if not isinstance(self.fidelity, Servo):
            return self
        period, step = aligned(self.period, self.fidelity.step)
        fidelity = dc.replace(self.fidelity, step=step)
        return dc.replace(self, period=period, fidelity=fidelity)

    def start_position(self, model: RobotModel) -> list[float]:
        """Returns the positions (3 + n,) of base and arm at the start.

        Raises:
            ParameterError: where the arm does not reach the start.
        """
        at = self.start
        arm = self.robot.arm()
        hand = (at.l, at.psi, at.z)
        q = arm.inverse(hand)
        nearest = arm.ee_cylindrical(q)
        # An arm that is out of reach stands at the nearest point that it reaches.
        if max(abs(a - b) for a, b in zip(nearest, hand, strict=True)) > REACHED:
            l, psi, z = (round(x, 4) + 0.0 for x in nearest)
            valid = f"out of reach; the nearest is l = {l}, psi = {psi}, z = {z}"
            named = dict(zip(("l", "psi", "z"), hand, strict=True))
            raise ParameterError("start", named, valid)
        check_joints(q, "start", model)
        return [at.x, at.y, at.theta, *q]


Decomposer = Exact | Blending | Switching | VelocityField | Qp | DiffIk
"""Whatever tells base and arm what to do."""


@dc.dataclass
class Teleop(Scenario):
    """An operator commands the hand; a decomposer tells base and arm what to do."""

    source: Script | External | Operator | Recording = dc.field(default_factory=Script)
    guard: Guard = OF_ROBOT
    gate: Gate = dc.field(default_factory=Gate)  # Of a live or recorded operator.
    decomposer: Decomposer = OF_ROBOT
    # What a live operator may choose instead, while driving.
    alternatives: list[Decomposer] = dc.field(default_factory=list)
    transition: Transition = dc.field(default_factory=Transition)
    projection: Projection = dc.field(default_factory=Projection)
    inverse: str = "positions"  # Of an arm with closed form: "positions" or "rates".

    @property
    def controllers(self) -> list[Any]:
        """Returns what may drive: the decomposer, then its alternatives."""
        return [self.decomposer, *self.alternatives]

    def check(self) -> None:
        """Raises `ParameterError` unless it can be run."""
        one_of(self, "inverse", INVERSES)
        super().check()
        check_controllers(self.controllers, "decomposer", self.robot)
        if any(isinstance(one, Qp) for one in self.controllers) and isinstance(
            self.robot.arm(), JacobianArm
        ):
            valid = "must be another; the arm has no Jacobian in closed form"
            raise ParameterError("decomposer", "!Qp", valid)


@dc.dataclass
class Guided(Scenario):
    """A hand pulls the free arm by its tool, and the base follows by the field."""

    fidelity: Kinematic | Servo = dc.field(default_factory=Servo)
    robot: Planar | Spatial | FrankaTiago = dc.field(default_factory=FrankaTiago)
    source: Planned | Operator | Recording = dc.field(default_factory=Planned)
    guard: Guard = OF_ROBOT  # Of an operator who leads the hand.
    gate: Gate = dc.field(default_factory=Gate)  # The same.
    hand: Hand = OF_ROBOT
    drag: Drag = dc.field(default_factory=Drag)  # Of an operator who pulls elsewhere.
    field: VelocityField = OF_ROBOT
    # What a live operator may choose instead, while driving.
    alternatives: list[VelocityField] = dc.field(default_factory=list)
    transition: Transition = dc.field(default_factory=Transition)

    @classmethod
    def own(cls, robot: Robot) -> dict[type, Any]:
        """Returns what the robot brings to such a scenario, by its class."""
        brought = super().own(robot)
        smoother = brought.get(Smoother) or Smoother()
        # The field jumps where its zones meet.
        return brought | {Smoother: dc.replace(smoother, enabled=True)}

    @property
    def controllers(self) -> list[Any]:
        """Returns what may drive the base: the field, then its alternatives."""
        return [self.field, *self.alternatives]

    def check(self) -> None:
        """Raises `ParameterError` unless it can be run."""
        if not isinstance(self.fidelity, Servo):
            valid = "must be !Servo, a hand pulls by force"
            raise ParameterError("fidelity", "!Kinematic", valid)
        super().check()
        check_controllers(self.controllers, "field", self.robot)
        self._check_hand()
        self._check_path()

    def _check_hand(self) -> None:
        """Raises `ParameterError` where the hand is too fast for base or period."""
        for name, mass in (("hand", _LEAST_MASS), ("drag", _LEAST_DRAGGED)):
            damping, most = getattr(self, name).damping, mass / self.period
            if damping > most:
                valid = f"must be at most {most:g} at a period of {self.period:g} s"
                raise ParameterError(f"{name}.damping", damping, valid)
        speed = peak_speed(self.hand)
        fastest = self.smoother.max_speed if self.smoother.enabled else SPEED.high
        if speed > fastest:
            valid = f"out of reach; the base follows at most {fastest:g} m/s"
            raise ParameterError("hand.path", f"{speed:.3g} m/s", valid)

    def _check_path(self) -> None:
        """Raises `ParameterError` where the arm cannot follow the hand's path."""
        model = RobotModel(self.robot)
        q = self.start_position(model)
        model.set_state(q, [0.0] * len(q))
        x, y, z = model.p_W("tool")
        first = self.hand.path[0]
        gap = math.dist((x, y, z), (first.x, first.y, first.z))
        if gap > _GRASP:
            at_tool = f"x = {x:.4f}, y = {y:.4f}, z = {z:.4f}"
            valid = f"must be where the tool starts, {at_tool}, within {_GRASP:g} m"
            given = {"x": first.x, "y": first.y, "z": first.z}
            raise ParameterError("hand.path[0]", given, valid)
        # The hand's orientation may change, but not by much: T keeps to its height.
        reach = self.robot.reach()
        above = model.p_W("tee")[2] - z
        low, high = reach.l_0 - reach.r_f - above, reach.l_0 + reach.r_f - above
        for i, point in enumerate(self.hand.path):
            if not low <= point.z <= high:
                valid = f"out of reach; must be within [{low:.4g}, {high:.4g}] m"
                raise ParameterError(f"hand.path[{i}].z", point.z, valid)


_LEAST_MASS = 1.2
"""What a hand's damping held for a period may amount to [kg]: three times the least
that the tool weighs in any posture. Above, hand and tool shake each other."""

_LEAST_DRAGGED = 0.45
"""The same [kg] for whatever point of the arm is dragged."""

_GRASP = 0.05
"""How far from the tool a hand may take hold of it [m]."""


AnyScenario = Teleop | Guided
"""A scenario's file says which by a tag at its top; `!Teleop` may be left out."""


def field_of(scenario: AnyScenario) -> VelocityField | None:
    """Returns the velocity field that the base follows, if it follows one."""
    if isinstance(scenario, Guided):
        return scenario.field
    field = scenario.decomposer
    return field if isinstance(field, VelocityField) else None


def played_back(scenario: AnyScenario, folder: Path) -> AnyScenario:
    """Returns a scenario of `folder` with its recording, if it has one, found.

    It runs as long as the recording is, or shorter.

    Raises:
        ParameterError: where the recording cannot be read.
    """
    if not isinstance(scenario.source, Recording):
        return scenario
    source = scenario.source.in_folder(folder)
    try:
        last = len(source.samples(scenario.period)) - 1
    except ParameterError as error:
        raise error.below("source") from None
    duration = min(scenario.duration, last * scenario.period)
    return dc.replace(scenario, source=source, duration=duration)


class ScenarioError(ValueError):
    """A scenario that cannot be run; the message is one line."""


def scenario_paths() -> dict[str, Path]:
    """Returns the scenarios that come with the package, by name."""
    folder = Path(str(resources.files("drake_mobman.scenarios")))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


_LONGEST = 1_000_000
"""Of a scenario's file [bytes]: some thousand segments, and a minute to read."""


def load_scenario(name: str, overrides: Sequence[str] = ()) -> tuple[str, AnyScenario]:
    """Returns a scenario and the name of its run folder.

    Args:
        name: one of `scenario_paths`, or a path. The `scenario.yaml` of a run folder
            goes by the folder's name.
        overrides: `key.path=value` each.

    Raises:
        ScenarioError: says in one line what is wrong, where, and what is valid.
    """
    path = scenario_paths().get(name, Path(name))
    text = _text(name, path)
    stem = path.resolve().parent.name if path.name == "scenario.yaml" else path.stem
    if not stem.isprintable():
        # It becomes a folder's name, a title, and a word in other files.
        raise ScenarioError(f"{stem!r}: a scenario's name must be printable text")
    # A diagram is of a scenario, so that it cannot be imported before.
    from drake_mobman.diagrams import check_buildable  # noqa: PLC0415

    label = path.name
    try:
        data = load_yaml(text)
        data = {} if data is None else data
        for override in overrides:
            label = "--set"
            data = _overridden(data, override)
        label = f"{path.name} with --set" if overrides else path.name
        scenario = played_back(load_typed(AnyScenario, data), path.parent)
        check_buildable(scenario)
    except (ParameterError, ScenarioError) as error:
        raise ScenarioError(f"{label}: {error}") from None
    return stem, scenario


def _text(name: str, path: Path) -> str:
    """Returns what is in a scenario's file, or raises `ScenarioError`."""
    name = quoted(name)
    try:
        return read_file(path, _LONGEST).decode()
    except FileNotFoundError:
        known = ", ".join(scenario_paths())
        why = f"no such scenario; valid names are {known}, or a path"
        raise ScenarioError(f"{name}: {why}") from None
    except OSError as error:
        raise ScenarioError(f"{name}: cannot be read; {error.strerror}") from None
    except ValueError as error:  # Of bytes that are no text, or of a path with a NUL.
        raise ScenarioError(f"{name}: cannot be read; {error}") from None


def _overridden(data: Any, override: str) -> Any:
    """Returns data with `key.path=value` put in, or raises `ParameterError`."""
    key, equals, text = override.partition("=")
    if not equals or not key:
        raise ParameterError("override", override, "must be key.path=value")
    try:
        value = load_yaml(text)
    except ParameterError as error:
        raise ParameterError(f"{key}, {error.key}", error.value, error.valid) from None
    return with_override(data, key, value)
