"""MuJoCo's model of a plant has the plant's kinematics and dynamics."""

import mujoco
import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import (
    BallRpyJoint,
    BodyIndex,
    FixedOffsetFrame,
    PrismaticJoint,
    RevoluteJoint,
    RpyFloatingJoint,
    SpatialInertia,
    UnitInertia,
    WeldJoint,
)
from pydrake.systems.analysis import Simulator

from drake_mobman.engines.mujoco.model import make_model
from drake_mobman.engines.mujoco.plant import MujocoPlant
from drake_mobman.parameters import ParameterError
from drake_mobman.robots import FrankaTiago, Planar, Servo, Spatial

CLOSE = 1e-10
"""Between two engines, of numbers from 1 to 100: MuJoCo gives 1e-12 kg and kg m^2 to
bodies that have none."""

STEP = 1e-5
"""Of both engines [s]."""

SOLVED = 1e-8
"""Relative: the solvers' own tolerance of servos."""

FIRST_ORDER = 1e3 * STEP
"""Of accelerations up to some 100 m/s^2 by angles of roll, pitch and yaw: these are
curved, and Drake goes straight in its own velocities in a step, MuJoCo in theirs."""


def random_pose(rng):
    return RigidTransform(RollPitchYaw(rng.uniform(-3, 3, 3)), rng.uniform(-1, 1, 3))


def random_body(plant, rng, name):
    com = rng.uniform(-0.2, 0.2, 3)
    box = UnitInertia.SolidBox(*rng.uniform(0.1, 0.6, 3))
    inertia = box.ShiftFromCenterOfMass(com)
    return plant.AddRigidBody(name, SpatialInertia(rng.uniform(0.5, 5.0), com, inertia))


def add_random_joint(plant, rng, kind, parent, child):
    """Adds a joint somewhere on its parent, to somewhere on its child."""
    name = child.name() + parent.name()
    F, M = (
        plant.AddFrame(
            FixedOffsetFrame(end + name, body.body_frame(), random_pose(rng))
        )
        for end, body in (("F", parent), ("M", child))
    )
    axis = rng.normal(size=3)
    more = {
        WeldJoint: [random_pose(rng)],
        RpyFloatingJoint: [],
    }.get(kind, [axis / np.linalg.norm(axis)])
    joint = plant.AddJoint(kind(name, F, M, *more))
    if kind in {RevoluteJoint, PrismaticJoint}:
        joint.set_default_damping(rng.uniform(0.0, 3.0))
        rotor = plant.AddJointActuator(name, joint)
        rotor.set_default_rotor_inertia(rng.uniform(0.0, 1e-3))
        rotor.set_default_gear_ratio(10.0)


def random_tree(seed, *, floating):
    """Returns a plant of seven bodies; some joints point towards the world."""
    rng = np.random.default_rng(seed)
    plant = MultibodyPlant(STEP)
    plant.SetUseSampledOutputPorts(False)
    bodies = [random_body(plant, rng, f"body{i}") for i in range(7)]
    first = RpyFloatingJoint if floating else RevoluteJoint
    add_random_joint(plant, rng, first, plant.world_body(), bodies[0])
    for i in range(1, 7):
        kind = (RevoluteJoint, PrismaticJoint, WeldJoint)[rng.integers(3)]
        ends = bodies[rng.integers(i)], bodies[i]
        add_random_joint(plant, rng, kind, *(ends if rng.integers(2) else ends[::-1]))
    plant.Finalize()
    return plant


PLANTS = {
    robot.__name__: lambda robot=robot: Servo(step=STEP).plant(robot())
    for robot in (FrankaTiago, Planar, Spatial)
} | {
    f"tree{seed}{'_floating' * floating}": lambda seed=seed, floating=floating: (
        random_tree(seed, floating=floating)
    )
    for seed in range(5)
    for floating in (False, True)
}


def actuators(plant):
    return [*map(plant.get_joint_actuator, plant.GetJointActuatorIndices())]


def served(plant):
    return any(actuator.has_controller() for actuator in actuators(plant))


class Both:
    """A plant in both engines, at the same random state."""

    def __init__(self, plant):
        rng = np.random.default_rng(3)
        self.plant, self.context = plant, plant.CreateDefaultContext()
        self.model, self.mapping = make_model(plant)
        self.data = mujoco.MjData(self.model)
        self.dofs = self.mapping.dofs(self.model)
        ends = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
        self.q = rng.uniform(-1, 1, plant.num_positions()).clip(*ends)
        self.v = rng.uniform(-1, 1, plant.num_velocities())
        plant.SetPositions(self.context, self.q)
        plant.SetVelocities(self.context, self.v)
        self.data.qpos[self.dofs] = self.q
        self.data.qvel[self.dofs] = plant.MapVelocityToQDot(self.context, self.v)
        mujoco.mj_forward(self.model, self.data)


@pytest.fixture(params=PLANTS.values(), ids=PLANTS.keys())
def both(request):
    return Both(request.param())


def test_bodies_are_where_the_plant_has_them_and_move_alike(both):
    for i in both.mapping.bodies:
        body = both.plant.get_body(BodyIndex(i))
        X_WB = both.plant.EvalBodyPoseInWorld(both.context, body)
        V_WB = both.plant.EvalBodySpatialVelocityInWorld(both.context, body)
        at = both.mapping.body(both.model, i)
        assert both.data.xpos[at] == pytest.approx(X_WB.translation(), abs=CLOSE)
        R_WB = both.data.xmat[at].reshape(3, 3)
        assert pytest.approx(X_WB.rotation().matrix(), abs=CLOSE) == R_WB
        velocity = np.zeros(6)
        kind = mujoco.mjtObj.mjOBJ_XBODY
        mujoco.mj_objectVelocity(both.model, both.data, kind, at, velocity, 0)
        assert velocity == pytest.approx(V_WB.get_coeffs(), abs=CLOSE)


def test_the_mass_matrix_is_the_plants(both):
    # The plant's is by its own velocities, MuJoCo's by the rates of its positions.
    rates = np.eye(both.model.nv)[both.dofs]
    N = np.stack(
        [both.plant.MapQDotToVelocity(both.context, rate) for rate in rates.T], 1
    )
    expected = N.T @ both.plant.CalcMassMatrix(both.context) @ N
    found = np.zeros_like(expected)
    mujoco.mj_fullM(both.model, both.data, found)
    assert found == pytest.approx(expected, abs=CLOSE)


def test_the_same_forces_accelerate_it_alike(both):
    rng = np.random.default_rng(0)
    push = ExternallyAppliedSpatialForce()
    push.body_index = BodyIndex(both.plant.num_bodies() - 1)
    push.p_BoBq_B = rng.uniform(-0.3, 0.3, 3)
    push.F_Bq_W = SpatialForce(rng.uniform(-9, 9, 3), rng.uniform(-9, 9, 3))
    tau = rng.uniform(-9, 9, both.plant.num_velocities())
    moved = []
    for system in (both.plant, MujocoPlant(both.plant, both.model, both.mapping)):
        context = system.CreateDefaultContext()
        context.SetDiscreteState(0, np.concatenate([both.q, both.v]))
        system.get_applied_generalized_force_input_port().FixValue(context, tau)
        system.get_applied_spatial_force_input_port().FixValue(context, [push])
        for instance in {x.model_instance() for x in actuators(both.plant)}:
            port = system.get_actuation_input_port(instance)
            port.FixValue(context, np.linspace(-5, 5, port.size()))
            if served(both.plant):
                port = system.get_desired_state_input_port(instance)
                port.FixValue(context, np.linspace(-1, 1, port.size()))
        Simulator(system, context).AdvanceTo(STEP / 2)  # The step at time 0.
        after = system.get_state_output_port().Eval(context)
        moved.append(after - np.concatenate([both.q, both.v]))
    assert np.abs(moved[0]).max() > STEP
    curved = not both.plant.IsVelocityEqualToQDot()
    close = {"abs": FIRST_ORDER} if curved else {"rel": SOLVED, "abs": SOLVED}
    assert moved[1] / STEP == pytest.approx(moved[0] / STEP, **close)


def test_what_is_not_a_tree_of_known_joints_is_refused_by_name():
    plant = MultibodyPlant(0.001)
    body = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    plant.AddJoint(BallRpyJoint("shoulder", plant.world_frame(), body.body_frame()))
    plant.Finalize()
    with pytest.raises(ParameterError, match="cannot simulate BallRpyJoint 'shoulder'"):
        make_model(plant)
