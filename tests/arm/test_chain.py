"""A chain read from a plant moves as the plant does, for any scalar."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BallRpyJoint,
    FixedOffsetFrame,
    JacobianWrtVariable,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    WeldJoint,
)
from pydrake.symbolic import Expression, MakeVectorVariable

from drake_mobman.arm.chain import chain_of
from drake_mobman.tracing import tracing

SAME = 1e-12
"""Of two ways to add up a dozen numbers of about 1 [m] and [1]."""

MOST = 8
"""Joints of an arm."""

coordinates = st.floats(-0.5, 0.5)
angles = st.floats(-3.0, 3.0)
squares = st.sampled_from([-np.pi / 2, 0.0, np.pi / 2, np.pi])
rotations = st.tuples(*[st.one_of(angles, squares)] * 3)
poses = st.builds(
    lambda rpy, p: RigidTransform(RollPitchYaw(rpy), p),
    rotations,
    st.tuples(*[st.one_of(st.just(0.0), coordinates)] * 3),
)
units = st.sampled_from([*np.eye(3), *-np.eye(3)])
oblique = st.tuples(*[coordinates] * 3).filter(lambda a: np.linalg.norm(a) > 0.1)
joints = st.tuples(
    st.sampled_from(["revolute", "prismatic", "weld"]),
    st.one_of(units, oblique),
    poses,  # Of the joint on its parent.
    poses,  # And on its child.
)
arms = st.lists(joints, min_size=1, max_size=MOST)


def arm_plant(arm, tee, order, branches=()):
    """Returns a finalized plant of an arm on a base that slides and turns.

    Args:
        arm: joints from the base to the tool.
        tee: index of the body of the arm that has T; -1 for the base.
        order: in which the joints are declared.
        branches: indices of bodies of the arm that carry one more that turns.
    """
    plant = MultibodyPlant(0.0)
    inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    rail, base, *links = (
        plant.AddRigidBody(name, inertia)
        for name in ("rail", "base", *(f"link{i}" for i in range(len(arm))))
    )
    plant.AddJoint(
        PrismaticJoint("x", plant.world_frame(), rail.body_frame(), [1, 0, 0])
    )
    plant.AddJoint(
        RevoluteJoint("theta", rail.body_frame(), base.body_frame(), [0, 0, 1])
    )
    bodies = [base, *links]
    for i in order:
        kind, axis, on_parent, on_child = arm[i]
        P = plant.AddFrame(FixedOffsetFrame(f"P{i}", bodies[i].body_frame(), on_parent))
        C = plant.AddFrame(
            FixedOffsetFrame(f"C{i}", bodies[i + 1].body_frame(), on_child)
        )
        if kind == "weld":
            plant.AddJoint(WeldJoint(f"j{i}", P, C, RigidTransform()))
        else:
            made = RevoluteJoint if kind == "revolute" else PrismaticJoint
            plant.AddJoint(made(f"j{i}", P, C, axis))
    for i in branches:
        twig = plant.AddRigidBody(f"twig{i}", inertia)
        at = bodies[i + 1].body_frame()
        plant.AddJoint(RevoluteJoint(f"twig{i}", at, twig.body_frame(), [1, 0, 0]))
    ahead = RigidTransform([0.1, -0.2, 0.3])
    plant.AddFrame(FixedOffsetFrame("tool", links[-1].body_frame(), ahead))
    plant.AddFrame(FixedOffsetFrame("tee", bodies[tee + 1].body_frame(), ahead))
    plant.Finalize()
    return plant


def of_plant(plant, q):
    """Returns R_BE, p_BE, p_BT, J_V_BE and J_v_BT by Drake's plant."""
    B, T, E = (plant.GetFrameByName(name) for name in ("base", "tee", "tool"))
    names = {joint: plant.GetJointByName(joint) for joint in joint_names(plant)}
    columns = [joint.velocity_start() for joint in names.values()]
    context = plant.CreateDefaultContext()
    everything = plant.GetPositions(context)
    everything[columns] = q
    plant.SetPositions(context, everything)
    wrt, here = JacobianWrtVariable.kV, np.zeros(3)
    X_BE = E.CalcPose(context, B)
    J_E = plant.CalcJacobianSpatialVelocity(context, wrt, E, here, B, B)
    J_T = plant.CalcJacobianTranslationalVelocity(context, wrt, T, here, B, B)
    p_BT = T.CalcPose(context, B).translation()
    return (
        X_BE.rotation().matrix(),
        X_BE.translation(),
        p_BT,
        J_E[:, columns],
        J_T[:, columns],
    )


def joint_names(plant):
    """Returns the names of the arm's joints that move, in the plant's order."""
    found = [plant.get_joint(i) for i in plant.GetJointIndices()]
    moving = [j for j in found if j.num_positions() and j.name().startswith("j")]
    return [j.name() for j in sorted(moving, key=lambda j: j.position_start())]


def of_chain(chain, q):
    """Returns the same by the chain's law."""
    at = chain.at(q)
    return at.X_BE.R, at.X_BE.p, at.p_BT, chain.J_V_BE(at), chain.J_v_BT(at)


def moves(arm):
    return any(kind != "weld" for kind, *_ in arm)


@st.composite
def plants(draw):
    arm = draw(arms.filter(moves))
    indices = range(len(arm))
    return arm_plant(
        arm,
        draw(st.integers(-1, len(arm) - 1)),
        draw(st.permutations(indices)),
        draw(st.sets(st.sampled_from(indices))),
    )


@settings(max_examples=100, deadline=None)
@given(plants(), st.lists(angles, min_size=MOST, max_size=MOST))
def test_any_arm_moves_as_in_the_plant(plant, many):
    chain = chain_of(plant)
    q = many[: chain.num_joints]
    assert chain.num_joints == len(joint_names(plant))
    for ours, theirs in zip(of_chain(chain, q), of_plant(plant, q), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=SAME)


ARM = [
    ("revolute", (0, 0, 1), RigidTransform([0.1, 0, 0.4]), RigidTransform()),
    ("prismatic", (0, 0, 1), RigidTransform(), RigidTransform([0, 0, 0.2])),
    ("revolute", (0.6, 0, 0.8), RigidTransform([0, 0.1, 0]), RigidTransform()),
    ("revolute", (0, -1, 0), RigidTransform([0.3, 0, 0]), RigidTransform()),
]
Q = [0.3, 0.1, -0.7, 1.1]


@pytest.fixture(scope="module")
def chain():
    return chain_of(arm_plant(ARM, 2, range(4)))


def test_derivatives_of_its_positions_are_its_jacobians(chain):
    at = chain.at(list(InitializeAutoDiff(Q).ravel()))
    for p, J in (
        (at.X_BE.p, chain.J_V_BE(chain.at(Q))[3:]),
        (at.p_BT, chain.J_v_BT(chain.at(Q))),
    ):
        assert [x.derivatives().tolist() for x in p] == pytest.approx(
            np.array(J), abs=SAME
        )


def test_traced_on_expressions_it_gives_the_same_numbers(chain):
    q = MakeVectorVariable(4, "q")
    with tracing() as trace:
        symbolic = of_chain(chain, [Expression(x) for x in q])
    env = dict(zip(q, Q, strict=True))
    for variable, law in zip(trace.variables, trace.laws, strict=True):
        env[variable] = law.Evaluate(env)
    for laws, floats in zip(symbolic, of_chain(chain, Q), strict=True):
        numbers = [
            x if isinstance(x, float) else x.Evaluate(env) for x in np.ravel(laws)
        ]
        assert numbers == pytest.approx(np.ravel(floats), abs=SAME)


def test_right_angles_leave_no_rounding_in_its_numbers():
    turned = RigidTransform(RollPitchYaw(np.pi / 2, -np.pi / 2, np.pi), [0, 0, 0.1])
    chain = chain_of(
        arm_plant([("revolute", (1, 0, 0), turned, turned)] * 3, 0, range(3))
    )
    axes = [axis for joint in chain.joints for axis in joint.X.axes]
    assert all(len(axis) == 1 and abs(axis[0][1]) == 1 for axis in axes)


def test_joint_that_neither_turns_nor_slides_is_refused():
    plant = arm_plant(ARM[:1], 0, range(1))
    with pytest.raises(ValueError, match="T is not between base and end effector"):
        chain_of(with_tee_on_a_twig())
    assert chain_of(plant).num_joints == 1
    with pytest.raises(ValueError, match="joint 'ball' is ball_rpy; one of an arm"):
        chain_of(with_ball())


def with_ball():
    return two_bodies(lambda P, C: BallRpyJoint("ball", P, C), tee="link")


def with_tee_on_a_twig():
    return two_bodies(lambda P, C: RevoluteJoint("j", P, C, [0, 0, 1]), tee="twig")


def two_bodies(joint, tee):
    plant = MultibodyPlant(0.0)
    inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    base, link, twig = (
        plant.AddRigidBody(x, inertia).body_frame() for x in ("base", "link", "twig")
    )
    plant.AddJoint(joint(base, link))
    plant.AddJoint(RevoluteJoint("twig", base, twig, [0, 0, 1]))
    for name, on in (("tool", link), ("tee", {"link": link, "twig": twig}[tee])):
        plant.AddFrame(FixedOffsetFrame(name, on, RigidTransform()))
    plant.Finalize()
    return plant
