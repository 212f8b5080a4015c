"""What holds for every block that is a template of its scalar."""

import functools
import inspect
import pydoc

import numpy as np
import pytest
from pydrake.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
)
from pydrake.symbolic import Evaluate, Expression, MakeVectorVariable
from pydrake.systems.framework import LeafSystem

from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.damped_inverse import DampedInverse
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.arm.limits import JointLimits
from drake_mobman.arm.oriented_inverse import OrientedInverse
from drake_mobman.base.smoother import CommandSmoother, Smoother
from drake_mobman.base.unsmoothed import CommandPassThrough
from drake_mobman.blocks import cached, scalar_block
from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.decomposers.switching import Switching, SwitchingDecomposer
from drake_mobman.estimation.base_estimator import BaseEstimator
from drake_mobman.estimation.measured import Measured
from drake_mobman.estimation.odometry import Odometry
from drake_mobman.estimation.sent import Sent
from drake_mobman.guidance.guiding_hand import GraspForce
from drake_mobman.robots.kinematic import KinematicRobot
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial
from drake_mobman.teleop.guard import CommandGuard

PERIOD = 0.01

PLANAR = Planar(upper_link=1.0, lower_link=0.8, shoulder_ahead=0.1).arm()
SPATIAL = Spatial().arm()
WIDE = {2: JointLimits([-4.0] * 2, [5.0] * 2, [3.0] * 2)}
WIDE[6] = JointLimits([-4.0] * 6, [4.0] * 6, [3.0] * 6)

BEND = {2: [0.4, -1.2], 6: [0.3, 0.9, -1.3, 0.0, 0.4, 0.0]}
"""Joint angles of both arms away from every limit and singularity."""

OTHER_BEND = {2: [-0.2, -0.8], 6: [-0.5, 1.2, -1.6, 0.0, 0.4, 0.0]}

STEP = 1e-6
"""Of central differences."""

DIFFERENCES = 5e-8
"""Central differences: STEP^2 f''' / 6 with f''' up to 1e4 where the share turns from
0 to 1 within 5 cm or rates are asked of positions 0.01 s apart, and rounding of such
rates, 1e-14, over STEP."""

ROUNDING = 1e-13
"""An Expression is evaluated in an order of its own; rates by positions divide the
rounding of angles, 2e-16, by the period."""


class Case:
    """A block, and values of its inputs and its state at which the law is smooth."""

    def __init__(self, name, make, inputs, outputs, state=None):
        self.name, self.make = name, make
        self.inputs = inputs  # Two values by port name, in the order of the ports.
        self.outputs = outputs  # Sizes by port name, in the order of the ports.
        self.state = state  # Two values, or None.

    def values(self, which):
        """Returns inputs by port name and the state, first or second of each."""
        inputs = {name: np.array(pair[which]) for name, pair in self.inputs.items()}
        state = None if self.state is None else np.array(self.state[which])
        return inputs, state


def decomposer(name, make, joints):
    return Case(
        f"{name}, {joints} joints",
        functools.partial(make, num_joints=joints),
        {
            "ee_command": ([0.3, -0.2, 0.1], [-0.1, 0.4, -0.2]),
            "ee_cylindrical": ([1.57, -0.66, 0.1], [0.43, 0.68, 0.3]),
            "arm_position": (BEND[joints], OTHER_BEND[joints]),
            "base_command_smoothed": ([0.1, 0.05], [-0.2, 0.3]),
            "base_estimate": ([0.1, 0.01, 0.05], [-0.2, 0.02, 0.3]),
        },
        {"base_command": 2, "base_contribution": 2, "arm_command": 3},
    )


def inverse(arm, by):
    n = arm.num_joints
    return Case(
        f"ClosedFormInverse, {type(arm).__name__}, by {by}",
        functools.partial(ClosedFormInverse, arm, WIDE[n], PERIOD, by),
        {
            "arm_command": ([0.3, -0.2, 0.1], [-0.1, 0.4, -0.2]),
            "arm_position": (BEND[n], OTHER_BEND[n]),
        },
        {"arm_velocity_command": n, "arm_status": 1},
    )


def sensor(arm, *at_start):
    n = arm.num_joints
    return Case(
        f"EndEffectorSensor, {type(arm).__name__}{', free' if at_start else ''}",
        functools.partial(EndEffectorSensor, arm, *at_start),
        {"arm_position": (BEND[n], OTHER_BEND[n])},
        {"ee_cylindrical": 3, "p_BT": 3},
        ([2.0], [9.0]) if at_start else None,
    )


def smoother(make, *args, state):
    return Case(
        make.__name__,
        functools.partial(make, *args),
        {"base_command": ([0.12, -0.11], [-0.3, 0.2])},
        {"base_command_smoothed": 2},
        state,
    )


def estimator(params, *, state, **measured):
    told = {"base_command_smoothed": ([0.3, -0.2], [-0.1, 0.4])}
    outputs = {"base_estimate": 3} | ({"base_astray": 1} if measured else {})
    return Case(
        f"BaseEstimator, {type(params).__name__}",
        functools.partial(BaseEstimator, params, PERIOD),
        told | measured,
        outputs,
        state,
    )


def robot(n):
    start = [1.0, -2.0, 0.3, *BEND[n]]
    return Case(
        f"KinematicRobot, {n} joints",
        functools.partial(KinematicRobot, start, PERIOD),
        {
            "base_command_smoothed": ([0.3, -0.2], [-0.1, 0.4]),
            "arm_velocity_command": ([0.1] * n, [-0.2] * n),
        },
        {"base_pose": 3, "base_velocity": 3, "arm_position": n, "arm_velocity": n},
        (start, [0.0, 0.5, -2.0, *OTHER_BEND[n]]),
    )


BLENDING = functools.partial(BlendingDecomposer, Blending())
SWITCHING = functools.partial(SwitchingDecomposer, Switching())

CASES = [
    *(decomposer("BlendingDecomposer", BLENDING, n) for n in (2, 6)),
    *(decomposer("SwitchingDecomposer", SWITCHING, n) for n in (2, 6)),
    smoother(CommandSmoother, Smoother(), PERIOD, state=([0.1, -0.1], [0.0, 0.4])),
    smoother(CommandPassThrough, state=None),
    *(inverse(arm, by) for arm in (PLANAR, SPATIAL) for by in ("positions", "rates")),
    *(sensor(arm) for arm in (PLANAR, SPATIAL)),
    sensor(SPATIAL, 2.0, PERIOD),
    estimator(
        Sent(delay=0.02, bandwidth=5.0),
        state=([0.1, 0.2, 0.3, 0.1, -0.2, 0.1], [0.4, 0.2, -0.3, 0.1, 0.0, 0.5]),
    ),
    estimator(
        Odometry(),
        state=([0.1, 0.2, 3.0], [0.4, 0.2, 70.0]),
        base_odometry=([0.1, 0.2], [0.0, -0.3]),
    ),
    estimator(
        Measured(latency=0.01),
        state=([0.1, 0.2, -0.1, 0.3, 3.0], [0.4, 0.2, 0.1, 0.0, 70.0]),
        base_measured=([0.1, 0.01, 0.2], [0.0, -0.02, -0.3]),
    ),
    *(robot(n) for n in (2, 6)),
]

every_block = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)


@pytest.fixture(scope="module")
def results(fed, outputs):
    """A function that returns outputs and next state of a block by name."""

    def results_of(block, inputs, state):
        context = fed(block, state, **inputs)
        found = outputs(block, context)
        if state is not None:
            update = block.EvalUniquePeriodicDiscreteUpdate(context)
            found["next state"] = update.get_vector().CopyToVector()
        return found

    return results_of


def assert_same(found, expected, *, atol=0.0):
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        np.testing.assert_allclose(found[name], value, rtol=0, atol=atol, err_msg=name)


@every_block
def test_ports_are_those_of_the_contract(case):
    block = case.make()
    ports = [block.get_input_port(i) for i in range(block.num_input_ports())]
    sizes = {name: len(first) for name, (first, _) in case.inputs.items()}
    assert [(p.get_name(), p.size()) for p in ports] == list(sizes.items())
    ports = [block.get_output_port(i) for i in range(block.num_output_ports())]
    found = [(p.get_name(), p.size()) for p in ports]
    assert found == list(case.outputs.items())


NEEDED = {
    "base_command": {"ee_command", "ee_cylindrical"},
    "base_contribution": {"ee_command", "ee_cylindrical"},
    "arm_command": {
        "ee_command",
        "ee_cylindrical",
        "base_command_smoothed",
        "base_estimate",
    },
    "base_command_smoothed": {"base_command"},
    "arm_velocity_command": {"arm_command", "arm_position"},
    "arm_status": {"arm_command", "arm_position"},
    "ee_cylindrical": {"arm_position"},
    "p_BT": {"arm_position"},
    "base_estimate": {"base_command_smoothed"},
    "base_astray": set(),
    "base_pose": set(),
    "arm_position": set(),
    "base_velocity": {"base_command_smoothed"},
    "arm_velocity": {"arm_velocity_command"},
}
"""Inputs that each output is to look at; a decomposer may look at more."""


@every_block
def test_outputs_depend_on_no_input_that_would_close_a_loop(case):
    block = case.make()
    may = {"arm_position"} if "ee_command" in case.inputs else set()
    for output in case.outputs:
        found = {
            name
            for name in case.inputs
            if block.HasDirectFeedthrough(
                block.GetInputPort(name).get_index(),
                block.GetOutputPort(output).get_index(),
            )
        }
        seen = {"base_odometry", "base_measured"} if output == "base_estimate" else may
        assert NEEDED[output] <= found <= NEEDED[output] | seen, output


@every_block
def test_converted_there_and_back_it_does_the_same(case, results):
    block = case.make()
    back = block.ToAutoDiffXd().ToScalarType[float]()
    for which in (0, 1):
        values = case.values(which)
        assert_same(results(back, *values), results(block, *values))


@every_block
def test_autodiff_agrees_with_finite_differences(case, results):
    block = case.make()
    inputs, state = case.values(0)
    names = list(inputs)
    parts = [*inputs.values(), *([] if state is None else [state])]
    ends = np.cumsum([len(part) for part in parts])[:-1]

    def at(x, block):
        *given, last = np.split(x.ravel(), ends)
        rest = [last] if state is None else []
        return results(
            block,
            dict(zip(names, given + rest, strict=True)),
            None if state is None else last,
        )

    x = np.concatenate(parts)
    smooth = at(InitializeAutoDiff(x), block.ToAutoDiffXd())
    nominal = at(x, block)
    differences = {
        name: np.zeros((len(value), len(x))) for name, value in nominal.items()
    }
    for i in range(len(x)):
        dx = STEP * np.eye(len(x))[i]
        above, below = at(x + dx, block), at(x - dx, block)
        for name, column in differences.items():
            column[:, i] = (above[name] - below[name]) / (2 * STEP)
    for name, expected in differences.items():
        value = smooth[name].reshape(-1, 1)
        np.testing.assert_allclose(ExtractValue(value).ravel(), nominal[name])
        gradient = ExtractGradient(value)
        gradient = gradient if gradient.size else np.zeros_like(expected)
        scale = max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(
            gradient, expected, rtol=0, atol=DIFFERENCES * scale, err_msg=name
        )


@every_block
@pytest.mark.parametrize("which", [0, 1])
# numpy looks at the processor's flags after products of Expressions, and finds those
# that Drake left on its way there.
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
def test_expressions_evaluate_to_the_floats(case, results, which):
    block = case.make()
    inputs, state = case.values(which)
    variables = {name: MakeVectorVariable(len(x), name) for name, x in inputs.items()}
    symbolic = {name: expressions(v) for name, v in variables.items()}
    env = {
        variable: x
        for name in inputs
        for variable, x in zip(variables[name], inputs[name], strict=True)
    }
    symbolic_state = None
    if state is not None:
        last = MakeVectorVariable(len(state), "state")
        env |= dict(zip(last, state, strict=True))
        symbolic_state = expressions(last)
    found = results(block.ToSymbolic(), symbolic, symbolic_state)
    evaluated = {
        name: Evaluate(value.reshape(-1, 1), env).ravel()
        for name, value in found.items()
    }
    assert_same(evaluated, results(block, inputs, state), atol=ROUNDING)


def expressions(variables):
    return np.array([Expression(v) for v in variables])


@every_block
def test_two_contexts_do_not_disturb_each_other(case, results, fed, outputs, step):
    block = case.make()
    alone = [results(case.make(), *case.values(which)) for which in (0, 1)]
    contexts = []
    for which in (0, 1):
        inputs, state = case.values(which)
        contexts.append(fed(block, state, **inputs))
    for _ in range(2):  # Twice, for what is kept from the last call.
        for context, expected in zip(contexts, alone, strict=True):
            found = outputs(block, context)
            assert_same(found, {name: expected[name] for name in found})
    if case.state is not None:
        for context in contexts:
            step(block, context)
        for context, expected in zip(contexts, alone, strict=True):
            state = context.get_discrete_state_vector().value()
            np.testing.assert_array_equal(state, expected["next state"])


# How a block is written.


@scalar_block
class Gain(LeafSystem):
    """Multiplies its input.

    Args:
        k: the gain.
        offset: added to it.
    """

    def __init__(self, k: float, offset: float = 0.0) -> None:
        self.k, self.offset, self.count = k, offset, 0
        self.u = self.DeclareVectorInputPort("u", 1)
        self.scaled = cached(self, self._calc_scaled)
        for name in ("y", "z"):
            self.DeclareVectorOutputPort(
                name, 1, self._calc, prerequisites_of_calc={self.scaled.ticket}
            )

    def _calc_scaled(self, context):
        self.count += 1
        return self.k * self.u.Eval(context) + self.offset

    def _calc(self, context, output):
        output.SetFromVector(self.scaled(context))


class Base(LeafSystem):
    """Declares one output, which a block defines."""

    def __init__(self, size):
        self.DeclareVectorOutputPort("y", size, self._calc)

    def _calc(self, context, output):
        raise NotImplementedError


@scalar_block
class Two(Base):
    """Puts out its scalar type's two; it knows no Expressions."""

    scalars = float, AutoDiffXd

    def __init__(self):
        Base.__init__(self, 1)

    def _calc(self, _context, output):
        output.SetFromVector(np.array([self.scalar(2.0)]))


def test_a_block_shows_its_name_arguments_and_docstring():
    for block in (Gain, Gain(1.0).__class__):
        assert block.__name__ == block.__qualname__ == "Gain"
        assert block.__module__ == __name__
        signature = "(k: float, offset: float = 0.0) -> None"
        assert str(inspect.signature(block)) == signature
        shown = pydoc.render_doc(block, renderer=pydoc.plaintext)
        assert f"Gain{signature}" in shown
        assert "k: the gain." in shown


@pytest.mark.parametrize(
    ("block", "arguments"),
    [
        (ClosedFormInverse, ["arm", "joint_limits", "period", "by"]),
        (DampedInverse, ["arm", "joint_limits", "period"]),
        (OrientedInverse, ["arm", "joint_limits", "period", "orientation"]),
        (EndEffectorSensor, ["arm", "psi", "period"]),
        (GraspForce, ["params", "period"]),
        (BaseEstimator, ["params", "period"]),
        (CommandGuard, ["params", "period", "watched"]),
        (KinematicRobot, ["start", "period"]),
    ],
)
def test_every_block_says_what_it_takes(block, arguments):
    assert list(inspect.signature(block).parameters) == arguments
    documented = block.__doc__.partition("Args:")[2]
    assert all(f"{name}: " in documented for name in arguments)
    assert f"name: {block.__name__}\n" in block.__doc__


VALUE = {AutoDiffXd: AutoDiffXd.value, Expression: Expression.Evaluate}


@pytest.mark.parametrize("made", [Gain(3.0, 0.5), Gain(3.0, offset=0.5)])
@pytest.mark.parametrize("scalar", VALUE)
def test_a_conversion_is_built_with_the_same_arguments(made, scalar):
    block = made.ToScalarType[scalar]()
    assert type(block) is Gain.template[scalar]
    assert block.scalar is scalar
    assert (block.k, block.offset) == (3.0, 0.5)
    context = block.CreateDefaultContext()
    block.get_input_port().FixValue(context, [scalar(2.0)])
    (y,) = block.GetOutputPort("y").Eval(context)
    assert VALUE[scalar](y) == 6.5


def test_a_cached_value_is_computed_once_for_all_outputs(fed, outputs):
    block = Gain(3.0)
    context = fed(block, u=[1.0])
    outputs(block, context)
    outputs(block, context)
    assert block.count == 1
    block.get_input_port().FixValue(context, [2.0])
    assert outputs(block, context) == {"y": [6.0], "z": [6.0]}
    assert block.count == 2


def test_a_block_has_the_methods_of_its_base_and_its_own_scalars(outputs):
    block = Two()
    assert outputs(block, block.CreateDefaultContext()) == {"y": [2.0]}
    assert block.ToAutoDiffXd().scalar is AutoDiffXd
    with pytest.raises(RuntimeError, match="Expression"):
        block.ToSymbolic()


def test_a_missing_argument_is_refused_by_name():
    with pytest.raises(TypeError, match="'k'"):
        Gain()
