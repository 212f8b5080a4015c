"""A robot from a file moves as its model says, whatever that is made of."""

import numpy as np
import pinocchio
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant

from drake_mobman.frames import frame
from drake_mobman.robot_model import RobotModel
from drake_mobman.robots.file import File
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate


@pytest.fixture
def robot(folder):
    return File(str(folder.path / "small.robot.yaml"))


def X_BE(model, q):
    """Returns the pose of E in B, by the plant that was made."""
    context = model.plant.CreateDefaultContext()
    model.plant.SetPositions(context, [0.0, 0.0, 0.0, *q])
    return frame(model.plant, "tool").CalcPose(context, frame(model.plant, "base"))


def test_end_effector_is_where_another_library_has_it_by_the_same_urdf(folder, robot):
    model = pinocchio.buildModelFromUrdf(str(folder.path / "small.urdf"))
    data, q = model.createData(), pinocchio.neutral(model)
    arm = np.random.default_rng(1).uniform(-1.0, 1.0, 6)
    q[model.joints[model.getJointId("lift")].idx_q] = 0.2
    for i, angle in enumerate(arm, 1):
        q[model.joints[model.getJointId(f"j{i}")].idx_q] = angle
    pinocchio.framesForwardKinematics(model, data, q)
    there = data.oMf[model.getFrameId("flange")]
    found = X_BE(RobotModel(robot), arm)
    expected = RigidTransform(RotationMatrix(there.rotation), there.translation)
    assert found.IsNearlyEqualTo(expected, 1e-12)


def test_nothing_moves_but_base_and_arm(robot):
    model = RobotModel(robot)
    assert model.plant.num_positions() == 3 + 6
    assert model.arm_joints == ["j1", "j2", "j3", "j4", "j5", "j6"]
    names = [
        model.plant.get_joint_actuator(i).name()
        for i in model.plant.GetJointActuatorIndices()
    ]
    assert names == ["x", "y", "theta", *model.arm_joints]
    assert model.plant.num_constraints() == 0


def test_its_mass_is_that_of_all_its_links(robot):
    model = RobotModel(robot)
    context = model.plant.CreateDefaultContext()
    mass = 20.0 + 2 * 1.0 + 1.0 + 6 * 1.0 + 0.1 + 2 * 0.05
    assert model.plant.CalcTotalMass(context) == pytest.approx(mass, rel=1e-12)


def test_limits_are_the_models_and_what_it_lacks_is_given(folder, robot):
    folder.change(
        "small.robot.yaml", "arm:", "limits: {joint_velocity: {j2: 1.5}}\narm:"
    )
    limits = RobotModel(robot).joint_limits
    assert list(limits.velocity) == [2.0, 1.5, 2.0, 2.0, 2.0, 2.0]
    assert list(limits.acceleration) == [10.0] * 6
    assert list(limits.lower) == [-3.0] * 6


def test_scenario_finds_its_robot_beside_it_and_runs(folder):
    file = folder.write(
        "drive.yaml",
        """\
        duration: 0.3
        fidelity: !Servo {}
        robot: !File {path: small.robot.yaml}
        source: !Script {segments: [!Held {duration: 0.3, v_c: 0.2}]}
        """,
    )
    run = simulate(load_scenario(file))
    assert not run.died
    assert run["base_pose"][-1, 0] >= 0.0
    plant = MultibodyPlant(0.0)
    run.scenario.robot.add_to(plant)
    assert plant.HasBodyNamed("flange")
