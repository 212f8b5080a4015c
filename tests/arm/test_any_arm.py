"""Arms of any make: their end effector moves as commanded, by Drake's plant."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    JacobianWrtVariable,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
)

from drake_mobman.arm.jacobian_arm import JacobianArm
from drake_mobman.arm.pseudo_inverse import Damping

EXACT = 1e-9
"""[m/s], [rad/s]: what keeps the inverse finite, 1e-14 over the square of a singular
value of 0.01, times rates of about 0.3."""

SAME = 1e-12
"""Of two ways to add up a dozen numbers of about 1 [m] and [1]."""

COMMAND = np.array([0.2, -0.3, 0.1])
UP, DOWN, OBLIQUE = [0, 0, 1], [0, 0, -1], [0.48, -0.36, 0.8]
SLIGHTLY_OFF = [0.0, 1.5e-5, 1.0]

ARMS = {
    "three joints": ("R" * 3, UP),
    "four joints": ("R" * 4, UP),
    "five joints that point down": ("R" * 5, DOWN),
    "five joints on a lift": ("P" + "R" * 5, UP),
    "four joints on a lift that counts down": ("P" + "R" * 4, DOWN),
    "six joints": ("R" * 6, UP),
    "six joints that point down": ("R" * 6, DOWN),
    "six oblique joints": ("R" * 6, OBLIQUE),
    "seven joints": ("R" * 7, SLIGHTLY_OFF),
    "seven oblique joints": ("R" * 7, OBLIQUE),
    "seven joints on a lift": ("P" + "R" * 7, UP),
    "six joints on a lift that count down": ("P" + "R" * 6, DOWN),
    "joints that slide among others": ("RRPRRPRR", UP),
}


class RandomArm:
    """A random arm with joints of given kinds, the first along a given axis."""

    def __init__(self, kinds, first, seed):
        rng = np.random.default_rng(seed)
        self.n = n = len(kinds)
        plant = self.plant = MultibodyPlant(0.0)
        inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        names = "base", *(f"link{i}" for i in range(n))
        bodies = [plant.AddRigidBody(name, inertia) for name in names]
        plant.WeldFrames(plant.world_frame(), bodies[0].body_frame())
        order = []
        for i in range(n):
            # A lift carries a joint of the same axis.
            straight = i == 0 or (i == 1 and kinds[0] == "P")
            rpy = [0, 0, 0] if straight else rng.uniform(-3, 3, 3)
            X = RigidTransform(RollPitchYaw(rpy), rng.uniform(-0.3, 0.3, 3))
            at = plant.AddFrame(FixedOffsetFrame(f"at{i}", bodies[i].body_frame(), X))
            make = PrismaticJoint if kinds[i] == "P" else RevoluteJoint
            axis = first if straight else rng.normal(size=3)
            order.append((make, f"j{i}", at, bodies[i + 1].body_frame(), axis, -2, 2))
        # Declared from the tool inwards.
        for make, *given in reversed(order):
            plant.AddJoint(make(*given))
        tip = RigidTransform(RollPitchYaw(0.3, -0.4, 0.5), [0.1, 0.2, -0.1])
        for name in ("tool", "tee"):
            plant.AddFrame(FixedOffsetFrame(name, bodies[-1].body_frame(), tip))
        plant.Finalize()
        self.context = plant.CreateDefaultContext()
        damping = Damping(threshold=0.01)
        self.arm = JacobianArm(plant, rng.uniform(-1, 1, n), damping)

    def regular(self, count):
        """Yields joint positions at which nothing is damped."""
        rng = np.random.default_rng(0)
        while count:
            q = rng.uniform(-2, 2, self.n)
            if not self.arm.is_near_singular(q):
                count -= 1
                yield q

    def X_BE(self, q):
        self.plant.SetPositions(self.context, q)
        return self.plant.GetFrameByName("tool").CalcPoseInWorld(self.context)

    def V_BE(self, q, rates):
        self.plant.SetPositions(self.context, q)
        B, E = (self.plant.GetFrameByName(name) for name in ("base", "tool"))
        kV = JacobianWrtVariable.kV
        J = self.plant.CalcJacobianSpatialVelocity(
            self.context, kV, E, np.zeros(3), B, B
        )
        return J @ rates

    def commanded(self, q, command):
        """Returns V_BE (6,) of a tool that turns with its reach, from its place."""
        p_SE = self.X_BE(q).translation() - self.arm.p_BS
        along = np.array([*p_SE[:2], 0.0]) / np.hypot(*p_SE[:2])
        v_m, omega_m, v_z = command
        turning = np.cross([0, 0, omega_m], p_SE)
        return np.array([0, 0, omega_m, *(v_m * along + turning + [0, 0, v_z])])


@pytest.fixture(params=ARMS, scope="module")
def tested(request):
    return RandomArm(*ARMS[request.param], seed=len(request.param))


def test_the_end_effector_moves_as_commanded(tested):
    arm = tested.arm
    for q in tested.regular(5):
        ee, posture, damped = arm.ee_and_posture_rates(q, COMMAND)
        assert not damped
        level = arm.oriented_parts(q, COMMAND, arm.ee_cylindrical(q)[1]).level
        expected = tested.commanded(q, COMMAND)
        found = tested.V_BE(q, np.subtract(ee, level))
        rows = slice(0 if tested.n >= 6 else 3, 6)
        np.testing.assert_allclose(found[rows], expected[rows], rtol=0, atol=EXACT)
        for rest in (level, posture):
            moved = tested.V_BE(q, rest)[3:]
            np.testing.assert_allclose(moved, 0.0, rtol=0, atol=EXACT)


def test_undamped_rates_are_the_same_and_linear(tested):
    arm = tested.arm
    for q in tested.regular(3):
        (found, double) = arm.undamped_rates(q, COMMAND, 2 * COMMAND)
        np.testing.assert_allclose(double, np.multiply(2, found), rtol=1e-9)
        rows = slice(0 if tested.n >= 6 else 3, 6)
        expected = tested.commanded(q, COMMAND)[rows]
        np.testing.assert_allclose(tested.V_BE(q, found)[rows], expected, atol=EXACT)


def test_place_and_rates_belong_together(tested):
    arm, h = tested.arm, 1e-6
    for q in tested.regular(5):
        l, psi, z = arm.ee_cylindrical(q)
        place = arm.p_BS + np.array([l * np.cos(psi), l * np.sin(psi), z])
        np.testing.assert_allclose(place, tested.X_BE(q).translation(), atol=SAME)
        rates = np.array(arm.rates(q, COMMAND))
        after, before = (np.array(arm.ee_cylindrical(q + dt * rates)) for dt in (h, -h))
        # By central differences, near a reach of 0 too.
        found = (after - before) / (2 * h)
        np.testing.assert_allclose(found, COMMAND, rtol=0, atol=1e-5)


def test_an_arm_is_inverted_where_it_has_been(tested):
    arm = tested.arm
    step = np.random.default_rng(0).uniform(-0.1, 0.1, tested.n)
    place = arm.ee_cylindrical(arm.posture + step)
    # With six joints, the tool is level again; so the posture's own place is used.
    place = place if tested.n < 6 else arm.ee_cylindrical(arm.posture)
    q = arm.inverse(place)
    np.testing.assert_allclose(arm.ee_cylindrical(q), place, rtol=0, atol=EXACT)
    assert arm.is_in_reach(place)


def test_the_first_vertical_joint_turns_the_arm_and_psi_counts_it():
    for kinds, first, joint, sign in (
        ("R" * 6, UP, 0, 1.0),
        ("R" * 6, DOWN, 0, -1.0),
        ("P" + "R" * 5, DOWN, 1, -1.0),
    ):
        tested = RandomArm(kinds, first, seed=1)
        assert tested.arm.turn == (joint, sign)
        q = tested.arm.posture.copy()
        before = tested.arm.ee_cylindrical(q)[1]
        for turn in (-4.0, 4.0):
            q[joint] = tested.arm.posture[joint] + sign * turn
            after = tested.arm.ee_cylindrical(q)[1]
            assert after - before == pytest.approx(turn, abs=SAME)
    assert RandomArm("R" * 6, OBLIQUE, seed=1).arm.turn is None


@pytest.mark.parametrize("axis", [UP, DOWN])
def test_a_lift_follows_the_end_effector_and_gives_the_arm_its_posture_back(axis):
    tested = RandomArm("P" + "R" * 7, axis, seed=3)
    arm, sign = tested.arm, float(axis[2])
    assert arm.lift == (0, sign)
    q = arm.posture.copy()
    shape = q[1:].copy()
    before = arm.ee_cylindrical(q)
    for _ in range(400):
        q = q + 0.01 * np.array(arm.rates(q, (0.0, 0.0, 0.02)))
    after = arm.ee_cylindrical(q)
    np.testing.assert_allclose(np.subtract(after, before), [0, 0, 0.08], atol=1e-4)
    # At a steady rate, it lags by that over the posture's gain of 1/s.
    lag = 0.08 - sign * (q[0] - arm.posture[0])
    assert lag == pytest.approx(0.02, rel=0.1)
    for _ in range(600):
        q = q + 0.01 * np.array(arm.rates(q, (0.0, 0.0, 0.0)))
    assert sign * (q[0] - arm.posture[0]) == pytest.approx(0.08, abs=1e-3)
    np.testing.assert_allclose(q[1:], shape, atol=5e-3)


def test_a_lift_goes_no_further_than_it_can_and_the_arm_goes_on():
    tested = RandomArm("P" + "R" * 7, UP, seed=3)
    arm = tested.arm
    q = arm.posture.copy()
    q[0] = 2.0
    ee, posture, _ = arm.ee_and_posture_rates(q, (0.0, 0.0, 0.1))
    assert ee[0] == 0.0
    assert posture[0] <= 0.0
    moved = tested.V_BE(q, np.add(ee, posture))[3:]
    assert moved[2] == pytest.approx(0.1, abs=EXACT)
