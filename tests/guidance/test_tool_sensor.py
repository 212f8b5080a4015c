"""The tool sensor tells where the robot's own model has the tool."""

import numpy as np
import pytest

from drake_mobman.guidance.tool_sensor import ToolSensor
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.planar import Planar


def told(sensor, context, q, v):
    """Position and velocity that the sensor tells of a state."""
    sensor.GetInputPort("robot_state").FixValue(context, np.concatenate((q, v)))
    names = ("tool_position", "tool_velocity")
    return [sensor.GetOutputPort(name).Eval(context).copy() for name in names]


@pytest.mark.parametrize("robot", [FrankaTiago(), Planar()], ids=["franka", "planar"])
def test_tool_is_where_the_model_has_it(robot):
    model, sensor = RobotModel(robot), ToolSensor(RobotModel(robot))
    random = np.random.default_rng(0)
    n = model.plant.num_positions()
    for _ in range(10):
        q, v = random.uniform(-1, 1, (2, n))
        model.set_state(q, v)
        p_WE, v_WE = told(sensor, sensor.CreateDefaultContext(), q, v)
        assert (p_WE == model.p_W("tool")).all()
        assert (v_WE == model.v_W("tool")).all()


def test_velocity_is_the_rate_of_position():
    sensor = ToolSensor(RobotModel(FrankaTiago()))
    random = np.random.default_rng(1)
    context = sensor.CreateDefaultContext()
    q, v = random.uniform(-1, 1, (2, 10))
    h = 1e-6
    before, after = (told(sensor, context, q + s * h * v, v)[0] for s in (-1, 1))
    _, v_WE = told(sensor, context, q, v)
    assert v_WE == pytest.approx((after - before) / (2 * h), abs=1e-8)


def test_two_contexts_do_not_disturb_each_other():
    sensor = ToolSensor(RobotModel(FrankaTiago()))
    one, other = sensor.CreateDefaultContext(), sensor.CreateDefaultContext()
    before = told(sensor, one, np.zeros(10), np.ones(10))
    told(sensor, other, np.ones(10), np.zeros(10))
    again = told(sensor, one, np.zeros(10), np.ones(10))
    np.testing.assert_array_equal(before, again)
