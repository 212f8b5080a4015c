"""Teleoperation by the field: the block, its ports, and what each depends on."""

import dataclasses as dc
import math

import numpy as np
import pytest
from pydrake.autodiffutils import InitializeAutoDiff

from drake_mobman.base.velocity_field import VelocityField, field_velocity
from drake_mobman.decomposers.arm_compensation import arm_compensation
from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.decomposers.field import FieldDecomposer
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import Reach
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial

ROUNDING = 1e-12
"""Of the same operations on another scalar type, on numbers of up to 4."""

SLOPE = 1e-6
"""Of central differences: a step of 1e-6, squared, times a third derivative of up to
1e3; and rounding over the step."""

WIDE = VelocityField(b_d=0.5, Delta_f=0.4, Delta_r=0.3)
"""For the two robots of Kwon, whose arm is 2 m long."""

ROBOTS = {
    "planar": (Planar(shoulder_ahead=0.2, shoulder_aside=0.1), WIDE),
    "spatial": (Spatial(), WIDE),
    "franka_tiago": (FrankaTiago(mount_aside=-0.1), VelocityField()),
}
BLOCKS = {
    name: FieldDecomposer(params, robot.reach(), robot.arm())
    for name, (robot, params) in ROBOTS.items()
}


def random_inputs(name, seed=0):
    """Returns inputs of a block, the workspace that of the joints."""
    robot, _ = ROBOTS[name]
    rng = np.random.default_rng(seed)
    if name == "franka_tiago":
        q = POSTURE + rng.uniform(-0.4, 0.4, 7)
        q[0] += rng.uniform(-2, 2)
    else:
        q = np.array(
            robot.arm().inverse((rng.uniform(0.5, 1.9), rng.uniform(-2, 2), 0.0))
        )
    return {
        "ee_command": rng.uniform(-0.4, 0.4, 3),
        "ee_cylindrical": np.array(robot.arm().ee_cylindrical(q)),
        "arm_position": q,
        "base_command_smoothed": rng.uniform(-0.5, 0.5, 2),
        "base_estimate": rng.uniform(-0.5, 0.5, 3),
    }


def moving(name):
    """Returns joint angles with the hand far and aside, where the base is to move."""
    hand = (0.75, 0.4, -0.2) if name == "franka_tiago" else (1.9, 0.4, 0.0)
    return np.array(ROBOTS[name][0].arm().inverse(hand))


@pytest.mark.parametrize("name", BLOCKS)
def test_ports_are_those_of_any_other_decomposer(name):
    def ports(block):
        given = map(block.get_input_port, range(block.num_input_ports()))
        made = map(block.get_output_port, range(block.num_output_ports()))
        return [
            [(port.get_name(), port.size()) for port in side] for side in (given, made)
        ]

    block = BLOCKS[name]
    given, made = ports(BlendingDecomposer(Blending(), num_joints=block.arm.num_joints))
    # It can fall short of its command, and says so.
    assert ports(block) == [given, [*made, ("decomposer_status", 1)]]


@pytest.mark.parametrize("name", BLOCKS)
@pytest.mark.parametrize("seed", range(5))
def test_base_command_is_the_fields_where_the_joints_have_the_wrist(
    fed, outputs, name, seed
):
    robot, params = ROBOTS[name]
    inputs = random_inputs(name, seed)
    found = outputs(BLOCKS[name], fed(BLOCKS[name], **inputs))
    p_BT = robot.arm().p_BT(inputs["arm_position"])
    expected = field_velocity(p_BT, params, robot.reach())
    np.testing.assert_array_equal(found["base_command"], expected)


@pytest.mark.parametrize("name", BLOCKS)
def test_arm_gets_exactly_the_rest_of_what_is_sent(fed, outputs, name):
    inputs = random_inputs(name)
    found = outputs(BLOCKS[name], fed(BLOCKS[name], **inputs))
    p_BS = ROBOTS[name][0].arm().p_BS
    expected = arm_compensation(
        inputs["ee_command"],
        inputs["ee_cylindrical"],
        inputs["base_estimate"],
        p_BS,
    )
    np.testing.assert_array_equal(found["arm_command"], expected)


@pytest.mark.parametrize("name", BLOCKS)
def test_share_and_arm_sum_to_the_command_where_the_base_gets_what_it_is_told(
    fed, outputs, name
):
    inputs = random_inputs(name)
    block = BLOCKS[name]
    v, omega = outputs(block, fed(block, **inputs))["base_command"]
    inputs["base_estimate"] = np.array([v, 0.0, omega])
    found = outputs(block, fed(block, **inputs))
    total = found["base_contribution"] + found["arm_command"][:2]
    np.testing.assert_allclose(total, inputs["ee_command"][:2], rtol=0, atol=ROUNDING)
    assert found["arm_command"][2] == inputs["ee_command"][2]


@pytest.mark.parametrize("name", BLOCKS)
def test_what_the_base_does_needs_not_what_it_is_sent(name):
    block = BLOCKS[name]
    moves = block.GetInputPort("base_estimate").get_index()
    needs_it = {
        output: block.HasDirectFeedthrough(
            moves, block.GetOutputPort(output).get_index()
        )
        for output in ("base_command", "base_contribution", "arm_command")
    }
    assert needs_it == {
        "base_command": False,
        "base_contribution": False,
        "arm_command": True,
    }


@pytest.mark.parametrize("name", BLOCKS)
@pytest.mark.parametrize("port", ["ee_command", "base_estimate", "ee_cylindrical"])
def test_base_listens_to_the_joints_alone(fed, name, port):
    # Two signals may be missing altogether, and a third may be anything.
    block = BLOCKS[name]
    inputs = random_inputs(name)
    alone = fed(block, arm_position=inputs["arm_position"])
    together = fed(block, **inputs | {port: np.full(len(inputs[port]), math.nan)})
    base_command = block.GetOutputPort("base_command")
    np.testing.assert_array_equal(base_command.Eval(alone), base_command.Eval(together))


def test_two_contexts_do_not_disturb_each_other(fed, outputs):
    block = BLOCKS["franka_tiago"]
    first, second = (fed(block, **random_inputs("franka_tiago", k)) for k in (1, 2))
    of_first = outputs(block, first)
    of_second = outputs(block, second)
    block.GetInputPort("base_estimate").FixValue(first, [0.25, 0.02, 0.4])
    for name, value in outputs(block, second).items():
        np.testing.assert_array_equal(value, of_second[name])
    found = outputs(block, first)
    np.testing.assert_array_equal(found["base_command"], of_first["base_command"])
    assert (found["arm_command"] != of_first["arm_command"])[:2].all()


@pytest.mark.parametrize("name", BLOCKS)
def test_gradient_by_the_joints_is_that_of_finite_differences(fed, name):
    block = BLOCKS[name]
    q = moving(name)
    twin = block.ToAutoDiffXd()
    context = fed(twin, arm_position=InitializeAutoDiff(q).ravel())
    found = twin.GetOutputPort("base_command").Eval(context)
    found = np.array([value.derivatives() for value in found])
    assert np.abs(found).max(1).min() > 0.1  # Neither of the two stands still.
    h = 1e-6
    for i, one in enumerate(np.eye(len(q))):
        ahead, back = (
            block.GetOutputPort("base_command").Eval(
                fed(block, arm_position=q + d * one)
            )
            for d in (h, -h)
        )
        slope = (ahead - back) / (2 * h)
        np.testing.assert_allclose(found[:, i], slope, rtol=0, atol=SLOPE)


@pytest.mark.parametrize(
    ("params", "says"),
    [
        ({"K_f": -1.0}, "K_f: -1.0 is not valid; must be within [0, 1000] 1/s"),
        ({"law": "guess"}, "law: 'guess' is not valid; must be one of printed, proj"),
        ({"b_d": 0.6}, "b_d: 0.6 is not valid; must be below r_f - Delta_f = 0.55"),
        ({"phi_min": math.nan}, "phi_min: nan is not valid; must be a finite number"),
    ],
)
def test_field_that_is_none_is_refused(params, says):
    reach = Reach(0.733, 0.7)
    with pytest.raises(ParameterError) as refusal:
        FieldDecomposer(
            dc.replace(VelocityField(), **params), reach, FrankaTiago().arm()
        )
    assert says in str(refusal.value)
