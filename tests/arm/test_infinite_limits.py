"""Joints with and without limits, in all combinations, under every law that keeps them.

An infinite limit does as one that is finite and out of the way.
"""

import contextlib
import dataclasses as dc
import itertools
import math

import numpy as np
import pytest

from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.damped_inverse import rates_within_limits
from drake_mobman.arm.limits import JointLimits, bounded_rates, filled_rates
from drake_mobman.arm.oriented_inverse import oriented_rates
from drake_mobman.base.smoother import Smoother
from drake_mobman.base.unsmoothed import Unsmoothed
from drake_mobman.compiled import compiled
from drake_mobman.decomposers.diff_ik import rates_within_reach
from drake_mobman.decomposers.exact import (
    Exact,
    ExactDecomposer,
    exact_arm_command,
    exact_base_command,
)
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.decomposers.limiter import Limiter
from drake_mobman.decomposers.qp import Qp, QpDecomposer, rate_bounds
from drake_mobman.decomposers.status import DecomposerStatus
from drake_mobman.robot_model import RobotModel, WorkspaceLimits
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario

PERIOD = 0.01

FAR = 1e9
"""Finite, and out of the way [rad], [rad/s], [rad/s^2]."""

SAME = 1e-12
"""Of the same operations, with a number in the place of an infinite one."""

FINITE = JointLimits([-1.0, -2.1], [1.2, -1.0], [0.5, 0.8], [2.0, 3.0])
"""Of two joints; the angles below are near to or past some of these."""

ANGLES = [(0.5, -1.5), (1.199, -1.5), (0.3, -1.0001), (-1.0, -2.1), (-1.3, -0.9)]
COMMANDS = [(0.3, 0.2, 0.0), (-0.4, 0.9, 0.0), (0.05, -0.3, 0.0), (0.0, 0.0, 0.0)]


def with_far(limits, far):
    """Returns the limits with what is infinite at `far` instead."""
    kept = {
        field.name: np.clip(getattr(limits, field.name), -far, far).tolist()
        for field in dc.fields(limits)
    }
    return JointLimits(**kept)


def every_combination(finite):
    """Returns limits of which any may be infinite: each of a joint's four, each joint.

    All combinations of two joints; of more, all of each joint with the others as they
    are, and as they are not.
    """
    limits = (getattr(finite, field.name) for field in dc.fields(finite))
    columns = list(zip(*limits, strict=True))
    endless = (-math.inf, math.inf, math.inf, math.inf)
    kinds = [
        list(itertools.product(*zip(column, endless, strict=True)))
        for column in columns
    ]
    if len(columns) == 2:
        chosen = list(itertools.product(*kinds))
    else:
        chosen = [
            (*others[:i], kind, *others[i + 1 :])
            for others in (columns, [endless] * len(columns))
            for i in range(len(columns))
            for kind in kinds[i]
        ]
    return [JointLimits(*map(list, zip(*joints, strict=True))) for joints in chosen]


COMBINATIONS = every_combination(FINITE)
FRANKA = RobotModel(FrankaTiago()).joint_limits
OF_SEVEN = every_combination(
    JointLimits(FRANKA.lower, FRANKA.upper, FRANKA.velocity, [9.0] * 7)
)


def same(law, limits, *rest):
    """Checks that a law takes infinite limits for far ones; returns what it says."""
    found, expected = (law(one, *rest) for one in (limits, with_far(limits, FAR)))
    for a, b in zip(found, expected, strict=True):
        assert np.isfinite(np.array(a, dtype=float)).all(), (limits, rest)
        np.testing.assert_allclose(a, b, rtol=SAME, atol=SAME, err_msg=str(limits))
    return found


def test_all_256_combinations_of_two_joints_are_there():
    assert len({str(limits) for limits in COMBINATIONS}) == 256


def test_joint_rates_keep_what_limits_there_are():
    for limits, q, rates in itertools.product(
        COMBINATIONS, ANGLES, [(0.4, -0.7), (-3.0, 2.0), (0.0, 1e3)]
    ):
        found, _ = same(
            lambda one, q, rates: bounded_rates(rates, q, one, PERIOD), limits, q, rates
        )
        assert (np.abs(found) <= np.array(limits.velocity) * (1 + SAME)).all()
        same(
            lambda one, q, rates: [filled_rates([0.1, -0.1], rates, q, one, PERIOD)],
            limits,
            q,
            rates,
        )


def test_rates_of_the_programs_keep_what_limits_there_are():
    last = np.array([0.1, -0.1, 0.2, -0.3])
    for limits, q in itertools.product(COMBINATIONS, ANGLES):
        bounds = rate_bounds(q, limits, Qp(), PERIOD)
        expected = rate_bounds(q, with_far(limits, FAR), Qp(), PERIOD)
        np.testing.assert_array_equal(bounds, expected)

        def within_reach(one, q=q):
            largest = np.array([0.5, 1.0, *one.velocity])
            accelerations = np.array([1.0, 2.0, *one.acceleration])
            return rates_within_reach(last, q, largest, accelerations, one, PERIOD)

        found, expected = within_reach(limits), within_reach(with_far(limits, FAR))
        for a, b in zip(found, expected, strict=True):
            # What is not bound at all may be infinite, and is no NaN.
            np.testing.assert_allclose(np.clip(a, -1e6, 1e6), np.clip(b, -1e6, 1e6))


def exact_block(robot, limits, **smoother):
    arm = robot.arm()
    return ExactDecomposer(
        Exact(), WorkspaceLimits(), arm, limits, Smoother(**smoother).limits(), PERIOD
    )


def told(block, q, command):
    """Returns what a decomposer puts out, its arm at `q`."""
    context = block.CreateDefaultContext()
    inputs = {
        "ee_command": command,
        "ee_cylindrical": Planar().arm().ee_cylindrical(q),
        "arm_position": q,
        "base_command_smoothed": (0.1, -0.2),
        "base_estimate": (0.1, 0.0, -0.2),
    }
    for name, value in inputs.items():
        block.GetInputPort(name).FixValue(context, value)
    return [
        block.GetOutputPort(name).Eval(context)
        for name in ("base_command", "arm_command", "decomposer_status")
    ]


@pytest.mark.parametrize("smoother", [Smoother(), Unsmoothed()])
def test_exact_decomposition_keeps_what_limits_there_are(smoother):
    arm, base_limits = Planar().arm(), smoother.limits()
    some_bound = 0
    for limits, q, command in itertools.product(COMBINATIONS, ANGLES, COMMANDS):

        def outputs(one, q, command):
            limiter = Limiter(arm, one, base_limits, WorkspaceLimits(), PERIOD)
            at = arm.ee_cylindrical(q)
            course = exact_base_command(
                command, at, q, Exact(), WorkspaceLimits(), limiter
            )
            rest, status = exact_arm_command(
                command, at, q, (0.1, -0.2), (0.1, 0.01, -0.2), course, limiter
            )
            return course.base, rest, status

        some_bound += bool(same(outputs, limits, q, command)[2])
    assert some_bound > len(COMBINATIONS)


@pytest.mark.parametrize("i", range(0, 256, 15))
def test_compiled_it_keeps_them_too(i):
    block = exact_block(Planar(), COMBINATIONS[i])
    quick = compiled(block)
    assert not quick.HasSubsystemNamed("rest")
    for q, command in itertools.product(ANGLES, COMMANDS):
        for a, b in zip(told(quick, q, command), told(block, q, command), strict=True):
            np.testing.assert_allclose(a, b, rtol=SAME, atol=SAME)


@pytest.mark.parametrize("by", ["positions", "rates"])
def test_the_arms_inverse_keeps_what_limits_there_are(by):
    arm = Planar().arm()
    for limits in COMBINATIONS[::15]:

        def outputs(one):
            block = ClosedFormInverse(arm, one, PERIOD, by)
            for each in (block, compiled(block)):
                context = each.CreateDefaultContext()
                rates, status = (
                    each.GetOutputPort(name)
                    for name in ("arm_velocity_command", "arm_status")
                )
                for q, command in itertools.product(ANGLES, COMMANDS):
                    each.GetInputPort("arm_command").FixValue(context, command)
                    each.GetInputPort("arm_position").FixValue(context, q)
                    yield rates.Eval(context)
                    yield status.Eval(context)

        same(outputs, limits)


def test_an_arm_by_its_jacobian_keeps_what_limits_there_are():
    arm = FrankaTiago().arm()
    turned = np.array(POSTURE)
    turned[6] = FRANKA.upper[6] - 1e-4
    for limits, q in itertools.product(OF_SEVEN, (POSTURE, turned)):

        def hand_along_its_reach(one, q=q):
            return rates_within_limits(arm, q, (0.2, 0.9, -0.1), one, PERIOD)

        def hand_apart_from_it(one, q=q):
            told = (0.2, 0.9, -0.1), -0.4, 0.1
            return oriented_rates(arm, q, *told, one, PERIOD)[:2]

        same(hand_along_its_reach, limits)
        same(hand_apart_from_it, limits)


def test_exact_decomposition_keeps_them_on_an_arm_by_its_jacobian():
    scenario = load_scenario("kwon_franka")
    block = build_decomposer(scenario.decomposer, scenario.setup())
    limiter = block.limiter
    at = limiter.arm.ee_cylindrical(POSTURE)
    for limits in OF_SEVEN:

        def factors(one):
            mine = dc.replace(limiter, joint_limits=one)
            rest, moves = (0.9, 0.5, 0.3), ((0.1, 0.2), (0.1, 0.01, 0.2))
            return [
                [*mine.steady_scaling(POSTURE, rest, 0.2, 0.1).values()],
                [*mine.present_scaling(POSTURE, at, rest, *moves).values()],
            ]

        same(factors, limits)


def test_a_first_joint_without_limits_leaves_the_elbow_its_own(fed, outputs):
    arm = Planar().arm()
    q = arm.inverse((1.0, 0.3, 0.0))
    for first in (
        (-math.inf, math.inf, math.inf, 2.0),
        (-3.4, 4.9, math.inf, math.inf),
        (-math.inf, math.inf, 3.0, 2.0),
    ):
        limits = JointLimits(*map(list, zip(first, (-3.1, 0.0, 0.2, 9.0), strict=True)))
        block = exact_block(Planar(), limits, smoothing=1.0)
        for each in (block, compiled(block)):
            context = fed(
                each,
                ee_command=(0.3, 0.4, 0.0),
                ee_cylindrical=arm.ee_cylindrical(q),
                arm_position=q,
                base_command_smoothed=(0.0, 0.0),
                base_estimate=(0.0, 0.0, 0.0),
            )
            found = outputs(each, context)
            # l = 2 cos(theta_2 / 2): l' = -sin(theta_2 / 2) theta_2', 2 % kept back.
            fastest = 0.98 * 0.2 * math.sin(math.acos(0.5))
            assert found["arm_command"][0] == pytest.approx(fastest)
            assert found["decomposer_status"] == DecomposerStatus.JOINT_RATE


@pytest.mark.parametrize("robot", [Planar(), Spatial()], ids=["planar", "spatial"])
def test_a_joint_that_is_nowhere_makes_no_command_that_looks_like_one(robot, fed):
    block = exact_block(robot, RobotModel(robot).joint_limits)
    quick = compiled(block)
    arm = robot.arm()
    q = np.array(arm.inverse((1.0, 0.3, 0.0)))
    for i, each in itertools.product(range(arm.num_joints), (block, quick)):
        nowhere = q.copy()
        nowhere[i] = math.nan
        context = fed(
            each,
            ee_command=(0.3, 0.4, 0.1),
            ee_cylindrical=(1.0, 0.3, 0.0),
            arm_position=nowhere,
            base_command_smoothed=(0.0, 0.0),
            base_estimate=(0.0, 0.0, 0.0),
        )
        for name in ("base_command", "arm_command"):
            # Compiled, Drake has nothing to do with the square root of NaN.
            found = np.full(3, math.nan)
            with contextlib.suppress(ValueError):
                found = each.GetOutputPort(name).Eval(context)
            assert np.isnan(found).any(), (i, name)


def test_program_of_eq_17_takes_joints_without_limits():
    arm = Planar().arm()
    q = np.array(arm.inverse((1.0, 0.3, 0.0)))
    for limits in COMBINATIONS[::5]:
        block = QpDecomposer(Qp(), arm, with_far(limits, math.inf), PERIOD)
        found = told(block, q, (0.1, 0.1, 0.0))
        expected = told(
            QpDecomposer(Qp(), arm, with_far(limits, FAR), PERIOD), q, (0.1, 0.1, 0.0)
        )
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_allclose(a, b, rtol=0, atol=1e-6)
