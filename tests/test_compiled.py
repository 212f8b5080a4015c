"""Compiled blocks do as the blocks they are made from."""

import functools

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from drake_mobman import signals
from drake_mobman.arm.closed_form_inverse import ClosedFormInverse
from drake_mobman.arm.damped_inverse import DampedInverse
from drake_mobman.arm.end_effector_sensor import EndEffectorSensor
from drake_mobman.arm.oriented_inverse import OrientedInverse
from drake_mobman.base.smoother import CommandSmoother, Smoother
from drake_mobman.base.unsmoothed import CommandPassThrough
from drake_mobman.base.velocity_field import VelocityField, VelocityFieldController
from drake_mobman.compiled import compiled
from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.decomposers.switching import Switching, SwitchingDecomposer
from drake_mobman.guidance.guiding_hand import GraspForce, Hand, Release
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.franka_tiago import FrankaTiago
from drake_mobman.robots.kinematic import KinematicRobot
from drake_mobman.robots.planar import Planar
from drake_mobman.robots.spatial import Spatial
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.guard import CommandGuard, Guard

ROUNDING = 1e-12
"""Of a law's handful of operations, in another order."""

DRIFT = 1e-9
"""Of a minute's 6,000 Euler steps, each with such a rounding."""

MACHINE = 1e-9
"""Of rates near a singularity, where inverses magnify what is rounded."""

PERIOD = 0.01


def decomposer(kind, name, *overrides):
    scenario = load_scenario(name, [f"decomposer={kind}", *overrides])
    return build_decomposer(scenario.decomposer, scenario.setup())


exact_decomposer = functools.partial(decomposer, "exact")


def inverse(robot, by):
    return ClosedFormInverse(robot.arm(), RobotModel(robot).joint_limits, PERIOD, by)


BLOCKS = {
    "smoother": lambda: CommandSmoother(Smoother(), PERIOD),
    "pass-through": CommandPassThrough,
    "field": lambda: VelocityFieldController(VelocityField(), FrankaTiago().reach()),
    "field of an arm with ends": lambda: VelocityFieldController(
        VelocityField(), Planar().reach(), RobotModel(Planar()).joint_limits
    ),
    "field, decomposed": lambda: decomposer("velocityfield", "kwon_1"),
    "blending": lambda: BlendingDecomposer(Blending()),
    "switching": lambda: SwitchingDecomposer(Switching()),
    "planar sensor": lambda: EndEffectorSensor(Planar().arm()),
    "spatial sensor": lambda: EndEffectorSensor(Spatial().arm()),
    "franka sensor": lambda: EndEffectorSensor(FrankaTiago().arm()),
    "free arm's sensor": lambda: EndEffectorSensor(FrankaTiago().arm(), 2.0, PERIOD),
    "exact, planar": lambda: exact_decomposer("kwon_arbitrary"),
    "exact, spatial": lambda: exact_decomposer("kwon_spatial", "smoother=smoother"),
    "planar inverse": lambda: inverse(Planar(), by="positions"),
    "planar inverse by rates": lambda: inverse(Planar(), by="rates"),
    "spatial inverse": lambda: inverse(Spatial(), by="positions"),
    "grasp": lambda: GraspForce(Hand(releases=[Release(0.5, 1.0)]), PERIOD),
    "guard": lambda: CommandGuard(Guard(), PERIOD),
    "robot": lambda: KinematicRobot([0.1, 0.2, 0.3, 0.4, -0.5], PERIOD),
}


@functools.cache
def both(name):
    """Returns a block and the same compiled."""
    block = BLOCKS[name]()
    return block, compiled(block)


def ports(block):
    return (
        [block.get_input_port(i) for i in range(block.num_input_ports())],
        [block.get_output_port(i) for i in range(block.num_output_ports())],
    )


@pytest.mark.parametrize("name", BLOCKS)
def test_ports_are_the_same(name):
    block = BLOCKS[name]()
    for ours, theirs in zip(ports(compiled(block)), ports(block), strict=True):
        assert {p.get_name(): p.size() for p in ours} == {
            p.get_name(): p.size() for p in theirs
        }


@pytest.mark.parametrize("name", BLOCKS)
def test_no_output_depends_on_an_input_that_it_did_not_depend_on(name):
    def feedthrough(block):
        inputs, outputs = ports(block)
        return {
            (u.get_name(), y.get_name())
            for u in inputs
            for y in outputs
            if block.HasDirectFeedthrough(u.get_index(), y.get_index())
        }

    block = BLOCKS[name]()
    assert feedthrough(compiled(block)) <= feedthrough(block)


@pytest.mark.parametrize("name", BLOCKS)
@given(seed=st.integers(0, 2**32 - 1))
def test_outputs_are_the_same_to_rounding(name, seed):
    random = np.random.default_rng(seed)
    block, quick = both(name)
    told = {p.get_name(): random.uniform(-1, 1, p.size()) for p in ports(block)[0]}

    def outputs(system):
        context = system.CreateDefaultContext()
        for port, value in told.items():
            system.GetInputPort(port).FixValue(context, value)
        return {p.get_name(): p.Eval(context) for p in ports(system)[1]}

    wanted, got = outputs(block), outputs(quick)
    for port, value in wanted.items():
        np.testing.assert_allclose(got[port], value, rtol=ROUNDING, atol=ROUNDING)


def test_block_of_one_output_is_one_system():
    # Each costs at every step of a diagram, asked or not.
    assert len(compiled(BLOCKS["smoother"]()).GetSystems()) == 1


@pytest.mark.parametrize("name", BLOCKS)
def test_nothing_of_it_is_left_to_python(name):
    assert not compiled(BLOCKS[name]()).HasSubsystemNamed("rest")


@pytest.mark.parametrize("name", ["smoother", "robot", "grasp", "guard"])
def test_states_go_the_same_way_under_a_held_input(name):
    def logged(system):
        builder = DiagramBuilder()
        builder.AddSystem(system)
        for i, port in enumerate(ports(system)[0]):
            value = (i + 1) * np.linspace(0.1, 0.4, port.size())
            source = builder.AddSystem(ConstantVectorSource(value))
            builder.Connect(source.get_output_port(), port)
        log = LogVectorOutput(ports(system)[1][0], builder, PERIOD)
        simulator = Simulator(builder.Build())
        simulator.AdvanceTo(2.0)
        return log.FindLog(simulator.get_context()).data()

    wanted, got = logged(BLOCKS[name]()), logged(compiled(BLOCKS[name]()))
    np.testing.assert_allclose(got, wanted, rtol=0, atol=ROUNDING)
    assert np.ptp(wanted) > 0.05


@functools.cache
def arm_blocks(name):
    """Returns a block of an arm by its Jacobian, and the same as machine code."""
    setup = load_scenario("kwon_franka").setup()
    arm, limits = setup.arm, setup.joint_limits
    block = {
        "exact": lambda: exact_decomposer("kwon_franka"),
        "along its reach": lambda: DampedInverse(arm, limits, PERIOD),
        "turning": lambda: OrientedInverse(arm, limits, PERIOD, "turning"),
        "held": lambda: OrientedInverse(arm, limits, PERIOD, "held"),
    }[name]()
    quick = compiled(block)
    assert quick is not block
    return block, quick


@settings(max_examples=30, deadline=None, phases=[Phase.generate])
@given(data=st.data())
@pytest.mark.parametrize("name", ["exact", "along its reach", "turning", "held"])
def test_laws_of_a_jacobian_arm_are_the_same_as_machine_code(name, data):
    arm = FrankaTiago().arm()
    limits = RobotModel(FrankaTiago()).joint_limits
    # Anywhere: at joints' ends, stretched or folded, and where the wrist gives way.
    shares = data.draw(
        st.lists(
            st.one_of(st.sampled_from([0.0, 0.5, 1.0]), st.floats(0, 1)),
            min_size=7,
            max_size=7,
        )
    )
    q = [
        low + x * (high - low)
        for low, high, x in zip(limits.lower, limits.upper, shares, strict=True)
    ]
    told = {signals.ARM_POSITION: q, signals.EE_CYLINDRICAL: arm.ee_cylindrical(q)}
    numbers = st.floats(-0.5, 0.5)
    found = []
    blocks = arm_blocks(name)
    block = blocks[0]
    for i in range(block.num_input_ports()):
        port = block.get_input_port(i)
        if port.get_name() not in told:
            size = port.size()
            told[port.get_name()] = data.draw(
                st.lists(numbers, min_size=size, max_size=size)
            )
    for each in blocks:
        context = each.CreateDefaultContext()
        for port_name, value in told.items():
            if each.HasInputPort(port_name):
                each.GetInputPort(port_name).FixValue(context, value)
        found.append(
            np.concatenate(
                [
                    each.get_output_port(i).Eval(context)
                    for i in range(each.num_output_ports())
                ]
            )
        )
    wanted, got = found
    scale = max(1.0, np.abs(wanted).max())
    np.testing.assert_allclose(got, wanted, rtol=0, atol=MACHINE * scale)


@pytest.mark.parametrize("name", ["kwon_arbitrary", "kwon_spatial"])
@pytest.mark.parametrize("decomposer", ["blending", "switching", "exact"])
def test_compiled_scenario_gives_the_same_log_to_rounding(name, decomposer):
    overrides = [f"decomposer={decomposer}"]
    plain = simulate(load_scenario(name, overrides)).log
    quick = simulate(load_scenario(name, [*overrides, "compiled=true"])).log
    assert plain.keys() == quick.keys()
    for signal, values in plain.items():
        np.testing.assert_allclose(quick[signal], values, rtol=0, atol=DRIFT)


def test_compiled_guided_run_gives_the_same_log_to_rounding():
    plain = simulate(load_scenario("petric_guided", ["duration=8"])).log
    overrides = ["duration=8", "compiled=true"]
    quick = simulate(load_scenario("petric_guided", overrides)).log
    for signal, values in plain.items():
        # Forces and jerks of a stiff hand magnify what positions are off by.
        np.testing.assert_allclose(quick[signal], values, rtol=0, atol=1e-6)
