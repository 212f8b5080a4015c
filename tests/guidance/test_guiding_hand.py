"""The hand pulls by its law, no harder than it may, and leads the tool."""

import dataclasses as dc
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Demultiplexer, LogVectorOutput

from drake_mobman.guidance.guiding_hand import (
    GraspForce,
    GuidingHand,
    Hand,
    Release,
    Waypoint,
    hand_force,
    holds,
    path_trajectory,
    peak_speed,
)
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.franka_tiago import POSTURE, FrankaTiago

ROUNDING = 1e-12
"""Of a few operations on numbers of about one."""

PERIOD = 0.01
"""Between two renewals of the force [s]."""

STEP = 0.002
"""Of the plant [s]."""

STILL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("p_WE", "v_WE", "p_WH", "v_WH", "force"),
    [
        (STILL, STILL, STILL, STILL, STILL),
        # 600 N/m times 5 cm, towards the hand.
        ((1.0, 2.0, 0.5), STILL, (1.05, 2.0, 0.5), STILL, (30, 0, 0)),
        ((1.0, 2.0, 0.5), STILL, (1.0, 2.0, 0.45), STILL, (0, 0, -30)),
        # 80 Ns/m times 0.25 m/s, towards the hand's velocity.
        (STILL, (0, 0.25, 0), STILL, STILL, (0, -20, 0)),
        (STILL, STILL, STILL, (0, 0.25, 0), (0, 20, 0)),
        (STILL, (0.1, 0, 0), (0.02, 0, 0.01), (0, 0, 0.1), (4, 0, 14)),
        # 30, 40 and none are 50 N; twice that is more than 60 N, which 36 and 48 are.
        (STILL, STILL, (0.05, 0, -1 / 15), STILL, (30, 0, -40)),
        (STILL, STILL, (0.1, 0, -2 / 15), STILL, (36, 0, -48)),
    ],
)
def test_force_is_as_worked_out_by_hand(p_WE, v_WE, p_WH, v_WH, force):
    assert hand_force(p_WE, v_WE, p_WH, v_WH, Hand()) == pytest.approx(force, abs=1e-12)


vectors = st.tuples(*[st.floats(-1e100, 1e100)] * 3)


@given(p_WE=vectors, v_WE=vectors, p_WH=vectors, v_WH=vectors)
def test_force_is_bounded_and_keeps_its_direction(p_WE, v_WE, p_WH, v_WH):
    hand = Hand()
    force = np.array(hand_force(p_WE, v_WE, p_WH, v_WH, hand))
    unbounded = np.array(
        hand_force(p_WE, v_WE, p_WH, v_WH, dc.replace(hand, max_force=1e300))
    )
    assert math.hypot(*force) <= hand.max_force * (1 + ROUNDING)
    share = hand.max_force / max(math.hypot(*unbounded), hand.max_force)
    assert force == pytest.approx(share * unbounded, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("which", range(4))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308])
def test_force_that_is_not_finite_is_refused_by_what_made_it(which, value):
    given_state = [[0.0] * 3 for _ in range(4)]
    given_state[which][1] = value
    name = ("p_WE", "v_WE", "p_WH", "v_WH")[which]
    told = rf"the hand's force is not finite: .*{name} = \[[^\]]*{value}"
    with pytest.raises(RuntimeError, match=told.replace("+", r"\+")):
        hand_force(*given_state, Hand())


TOUR = Hand(
    path=[
        Waypoint(1.0, 0.6, 0.0, 0.5),
        Waypoint(3.0, 1.0, 0.0, 0.5),
        Waypoint(4.0, 1.2, 0.2, 0.5),
        Waypoint(6.5, 1.2, 0.5, 1.1),
        Waypoint(8.0, 0.9, 0.5, 1.0),
    ]
)


def p_and_v(hand, times):
    """The hand's positions and velocities (N, 3) at `times`."""
    path = path_trajectory(hand)
    return path.vector_values(times).T, path.MakeDerivative().vector_values(times).T


def test_path_passes_its_points_in_time_and_rests_before_and_after():
    points = np.array([dc.astuple(point) for point in TOUR.path])
    p, _ = p_and_v(TOUR, points[:, 0])
    assert p == pytest.approx(points[:, 1:], abs=ROUNDING)
    p, v = p_and_v(TOUR, [-1.0, 0.0, 1.0, 8.0, 9.0, 100.0])
    assert p == pytest.approx(np.repeat(points[[0, -1], 1:], 3, axis=0), abs=ROUNDING)
    assert v == pytest.approx(np.zeros((6, 3)), abs=ROUNDING)


def test_path_is_continuous_with_its_velocity_and_does_not_overshoot():
    times = np.linspace(0.0, 9.0, 9001)
    p, v = p_and_v(TOUR, times)
    speed = peak_speed(TOUR)
    assert np.linalg.norm(np.diff(p, axis=0), axis=1).max() <= speed * (1e-3 + 1e-8)
    assert np.abs(np.diff(v, axis=0)).max() < 5e-3  # 5 m/s^2: no jump in velocity.
    for a, b in itertools.pairwise(TOUR.path):
        between = p[(times >= a.time) & (times <= b.time)]
        ends = np.array([dc.astuple(a)[1:], dc.astuple(b)[1:]])
        assert (between >= ends.min(0) - ROUNDING).all()
        assert (between <= ends.max(0) + ROUNDING).all()


def test_from_rest_to_rest_the_peak_is_one_and_a_half_times_the_mean():
    line = Hand(path=[Waypoint(1, 0, 0, 0.5), Waypoint(3, 0.3, 0.4, 0.5)])
    assert peak_speed(line) == pytest.approx(1.5 * 0.5 / 2, rel=1e-6)


def test_peak_speed_is_that_of_the_path():
    _, v = p_and_v(TOUR, np.random.default_rng(0).uniform(0, 9, 20000))
    peak = np.linalg.norm(v, axis=1).max()
    assert peak_speed(TOUR) == pytest.approx(peak, rel=1e-3)
    assert peak_speed(TOUR) >= peak * (1 - 1e-6)


def test_a_path_of_one_point_is_a_hand_held_still():
    p, v = p_and_v(Hand(path=[Waypoint(1, 2, 3, 4)]), [0.0, 1.0, 5.0])
    assert (p == [2, 3, 4]).all()
    assert (v == 0).all()
    assert peak_speed(Hand()) == 0


def test_hand_holds_but_between_letting_go_and_taking_hold():
    releases = [Release(1.0, 2.0), Release(2.0, 3.0), Release(5.0, 6.0)]
    times = [0.0, 1.0, 2.5, 3.0, 4.9, 5.0, 5.9, 6.0]
    expected = [True, False, False, True, True, False, False, True]
    assert [holds(time, releases) for time in times] == expected


def test_ports_have_their_names_and_sizes():
    hand = GuidingHand(Hand(), PERIOD, BodyIndex(1))
    inputs = [hand.get_input_port(i) for i in range(hand.num_input_ports())]
    outputs = [hand.get_output_port(i) for i in range(hand.num_output_ports())]
    assert [(port.get_name(), port.size()) for port in inputs] == [
        ("tool_position", 3),
        ("tool_velocity", 3),
    ]
    assert [(port.get_name(), port.size()) for port in outputs] == [
        ("hand_force", 3),
        ("hand_position", 3),
        ("spatial_forces", 0),
    ]
    assert not hand.HasAnyDirectFeedthrough()


def pulled_once(hand, context, p_WE, v_WE=STILL):
    """The force (3,) after one renewal in `context`."""
    hand.tool_position.FixValue(context, p_WE)
    hand.tool_velocity.FixValue(context, v_WE)
    state = hand.EvalUniquePeriodicDiscreteUpdate(context)
    context.SetDiscreteState(state)
    return hand.GetOutputPort("hand_force").Eval(context)


def pushed(hand, context):
    """The force (3,) that a plant is given."""
    pushes = hand.GetOutputPort("spatial_forces").Eval(context)
    return sum(push.F_Bq_W.translational() for push in pushes)


def test_plant_is_given_the_force_on_the_body_at_the_tool():
    line = Hand(path=[Waypoint(0, 0, 0, 1), Waypoint(2, 0.2, 0, 1)])
    hand = GuidingHand(line, PERIOD, BodyIndex(7), (0.0, 0.1, 0.2))
    context = hand.CreateDefaultContext()
    context.SetTime(1.0)  # Half way, at 0.15 m/s.
    force = pulled_once(hand, context, (0.08, 0, 1))
    assert force == pytest.approx((600 * 0.02 + 80 * 0.15, 0, 0))
    pushes = hand.GetOutputPort("spatial_forces").Eval(context)
    assert {int(push.body_index) for push in pushes} == {7}
    assert all((push.p_BoBq_B == [0, 0.1, 0.2]).all() for push in pushes)
    assert (pushed(hand, context) == force).all()
    assert all((push.F_Bq_W.rotational() == 0).all() for push in pushes)
    position = hand.GetOutputPort("hand_position").Eval(context)
    assert position == pytest.approx((0.1, 0, 1))


def test_two_contexts_do_not_disturb_each_other():
    hand = GuidingHand(Hand(), PERIOD, BodyIndex(1))
    near, far = hand.CreateDefaultContext(), hand.CreateDefaultContext()
    before = pulled_once(hand, near, (0.57, 0, 0.52)).copy()
    pulled_once(hand, far, (0.5, 0, 0.5))
    assert (hand.GetOutputPort("hand_force").Eval(near) == before).all()
    assert (pushed(hand, near) == before).all()


def simulator(hand, plant, add_tool):
    """A simulator of a hand on a plant, and what it logs at every plant step.

    `add_tool(builder)` returns the ports of the tool's position and velocity.
    """
    builder = DiagramBuilder()
    builder.AddSystem(plant)
    builder.AddNamedSystem("hand", hand)
    position, velocity = add_tool(builder)
    builder.Connect(position, hand.tool_position)
    builder.Connect(velocity, hand.tool_velocity)
    builder.Connect(
        hand.GetOutputPort("spatial_forces"),
        plant.get_applied_spatial_force_input_port(),
    )
    logged = {
        "tool": position,
        "hand": hand.GetOutputPort("hand_position"),
        "force": hand.GetOutputPort("hand_force"),
    }
    sinks = {k: LogVectorOutput(port, builder, STEP) for k, port in logged.items()}
    simulation = Simulator(builder.Build())

    def log():
        root = simulation.get_context()
        data = {k: sink.FindLog(root).data().T for k, sink in sinks.items()}
        return data | {"time": sinks["tool"].FindLog(root).sample_times()}

    return simulation, log


def on_a_point_mass(params, mass=1.0):
    """A hand on a free body that starts at the origin."""
    plant = MultibodyPlant(STEP)
    body = plant.AddRigidBody("tool", SpatialInertia.SolidSphereWithMass(mass, 0.05))
    plant.set_gravity_enabled(body.model_instance(), False)
    plant.Finalize()
    hand = GuidingHand(params, PERIOD, body.index())

    def add_tool(builder):
        # Quaternion, position, angular velocity, velocity.
        parts = builder.AddSystem(Demultiplexer([4, 3, 3, 3]))
        builder.Connect(plant.get_state_output_port(), parts.get_input_port())
        return parts.get_output_port(1), parts.get_output_port(3)

    return simulator(hand, plant, add_tool)


def counted(function, calls):
    def counting(*args):
        calls.append(function.__name__)  # Not the arguments, which Drake may free.
        return function(*args)

    return counting


def test_force_is_renewed_at_the_period_and_held_in_between(monkeypatch):
    line = Hand(path=[Waypoint(0, 0, 0, 0), Waypoint(1, 0.2, 0, 0)])
    calls = []
    monkeypatch.setattr(GraspForce, "_renew", counted(GraspForce._renew, calls))
    simulation, log = on_a_point_mass(line)
    simulation.AdvanceTo(1.0)
    data = log()
    changed = data["time"][1:][np.diff(data["force"], axis=0).any(axis=1)]
    # What is logged at an instant comes before its updates.
    ticks = (changed - STEP) / PERIOD
    assert ticks == pytest.approx(np.round(ticks), abs=1e-9)
    assert len(changed) > 90
    # The plant makes 500 steps, and Python is asked for the force but once a period.
    assert calls.count("_renew") == 100


@settings(max_examples=30)  # Of a simulation each.
@given(
    points=st.lists(st.tuples(*[st.floats(-2, 2)] * 3), min_size=2, max_size=4),
    max_force=st.floats(1, 100),
    start=st.floats(0, 0.4),
    length=st.floats(0.05, 0.4),
)
def test_force_never_exceeds_its_bound_and_is_none_while_let_go(
    points, max_force, start, length
):
    path = [Waypoint(0.3 * i, *point) for i, point in enumerate(points)]
    release = Release(start, start + length)
    params = Hand(path=path, max_force=max_force, releases=[release])
    simulation, log = on_a_point_mass(params)
    simulation.AdvanceTo(1.0)
    data = log()
    force = np.linalg.norm(data["force"], axis=1)
    assert force.max() <= max_force * (1 + ROUNDING)
    time = data["time"]
    let_go = (time > release.start + PERIOD) & (time <= release.end)
    assert (force[let_go] == 0).all()


def test_tool_that_was_let_go_drifts_and_is_taken_along_again():
    line = Hand(
        path=[Waypoint(0, 0, 0, 0), Waypoint(4, 0, 0.6, 0)], releases=[Release(2, 3)]
    )
    simulation, log = on_a_point_mass(line)
    simulation.AdvanceTo(6.0)
    data = log()
    time, off = data["time"], np.linalg.norm(data["tool"] - data["hand"], axis=1)
    # Without friction a tool let go at 0.225 m/s keeps its speed, while the hand slows.
    let_go = (time > 2.02) & (time <= 3)
    speed = np.diff(data["tool"][let_go, 1]) / STEP
    assert speed == pytest.approx(np.full(len(speed), speed[0]), abs=1e-9)
    assert speed[0] == pytest.approx(0.225, abs=1e-3)
    assert off[time < 2].max() < 1e-3
    assert off[let_go].max() > 1e-2
    assert off[-1] < 1e-6


def test_run_with_a_tool_that_is_nowhere_ends_with_a_word():
    hand = GuidingHand(Hand(releases=[Release(0, 9)]), PERIOD, BodyIndex(1))
    for p_WE, v_WE, name in (
        ((0.5, math.nan, 0.5), STILL, "p_WE"),
        (STILL, (math.inf, 0, 0), "v_WE"),
    ):
        context = hand.CreateDefaultContext()
        with pytest.raises(RuntimeError, match=rf"force is not finite: .*{name}"):
            pulled_once(hand, context, p_WE, v_WE)


class Tool(LeafSystem):
    """Tells where the robot's tool is, from its positions and velocities (10, 10)."""

    def __init__(self, model):
        super().__init__()
        self.state = self.DeclareVectorInputPort("state", 20)
        for name, of in (("position", model.p_W), ("velocity", model.v_W)):

            def calc(context, output, of=of):
                q, v = np.split(self.state.Eval(context), 2)
                model.set_state(q, v)
                output.SetFromVector(of("tool"))

            self.DeclareVectorOutputPort(name, 3, calc)


@pytest.mark.parametrize("way", [(-0.2, 0, 0), (0, 0.3, 0), (0.1, 0, 0.25)])
def test_free_arm_follows_a_hand_of_30_cm_a_second(way):
    """Gravity-compensated, with 1 Nms/rad in each joint, on a base that stands."""
    model = RobotModel(FrankaTiago())
    start = np.array([0, 0, 0, *POSTURE])
    model.set_state(start, 0 * start)
    p_WE = model.p_W("tool")
    end = 0.2 + 1.5 * math.hypot(*way) / 0.3
    params = Hand(path=[Waypoint(0.2, *p_WE), Waypoint(end, *(p_WE + way))])
    assert peak_speed(params) == pytest.approx(0.3, rel=1e-6)

    plant = MultibodyPlant(STEP)
    (robot,) = FrankaTiago().add_to(plant)
    plant.set_gravity_enabled(robot, False)
    for name in model.arm_joints:
        plant.GetJointByName(name).set_default_damping(1.0)
    plant.Finalize()
    hand = GuidingHand(params, PERIOD, plant.GetBodyByName("tool").index())

    def add_tool(builder):
        tool = builder.AddSystem(Tool(model))
        builder.Connect(plant.get_state_output_port(), tool.state)
        return tool.get_output_port(0), tool.get_output_port(1)

    simulation, log = simulator(hand, plant, add_tool)
    context = plant.GetMyMutableContextFromRoot(simulation.get_mutable_context())
    plant.SetPositions(context, start)
    for name in ("x", "y", "theta"):
        plant.GetJointByName(name).Lock(context)
    simulation.AdvanceTo(end + 1.0)
    data = log()
    assert np.linalg.norm(data["tool"] - data["hand"], axis=1).max() < 0.02
    assert np.linalg.norm(data["force"], axis=1).max() < 15
    assert data["tool"][-1] == pytest.approx(p_WE + way, abs=1e-4)


@pytest.mark.parametrize(
    ("change", "key", "value", "valid"),
    [
        ({"stiffness": 0.0}, "stiffness", 0.0, "must be within [0.1, 1e+06] N/m"),
        ({"damping": -1.0}, "damping", -1.0, "must be within [0.001, 1e+06] N s/m"),
        ({"max_force": 0.0}, "max_force", 0.0, "must be within [0.001, 100000] N"),
        ({"stiffness": math.inf}, "stiffness", math.inf, "must be a finite number"),
        ({"path": []}, "path", [], "must hold one waypoint or more"),
        (
            {"path": [Waypoint(), Waypoint(1, 0, math.inf, 0)]},
            "path[1].y",
            math.inf,
            "must be a finite number",
        ),
        (
            {"path": [Waypoint(0), Waypoint(2), Waypoint(2)]},
            "path[2].time",
            2,
            "must be above path[1].time = 2",
        ),
        (
            {"releases": [Release(1.0, 1.0)]},
            "releases[0].end",
            1.0,
            "must be above start = 1.0",
        ),
        (
            {"releases": [Release(0, 2), Release(1, 3)]},
            "releases[1].start",
            1,
            "must be releases[0].end = 2 or above",
        ),
    ],
)
def test_hand_that_cannot_lead_is_refused(change, key, value, valid):
    with pytest.raises(ParameterError) as refused:
        GuidingHand(dc.replace(Hand(), **change), PERIOD, BodyIndex(1))
    error = refused.value
    assert (error.key, error.value, error.valid) == (key, value, valid)


def test_default_hand_is_valid():
    assert checked(Hand()) == Hand()
