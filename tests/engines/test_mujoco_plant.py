"""MuJoCo in the plant's place: servos, contacts and whole scenarios as in Drake."""

import numpy as np
import pytest
from pydrake.geometry import (
    AddContactMaterial,
    Box,
    Convex,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_mobman.engines import Drake, Mujoco
from drake_mobman.parameters import ParameterError

ENGINES = {"drake": Drake(), "mujoco": Mujoco()}

SAME_STEPS = Drake(), Mujoco(substeps=1)
"""Both engines at the step of the plant: then they differ by rounding alone."""

STEP = 0.002
"""Of both engines [s]."""

SOLVED = 1e-6
"""Relative: Drake's solver stops there."""

LIFTED = 0.01
"""Relative: MuJoCo lifts what slips, by less the slower it slips, and bears it less."""

G = 9.81
"""[m/s^2]."""


def new_plant():
    plant = MultibodyPlant(STEP)
    plant.SetUseSampledOutputPorts(False)
    return plant


def add_axis(plant, kind, name, parent, axis, mass, radius):
    """Adds a ball that moves along or about an axis; returns body and joint."""
    body = plant.AddRigidBody(name, SpatialInertia.SolidSphereWithMass(mass, radius))
    frames = parent.body_frame(), body.body_frame()
    return body, plant.AddJoint(kind(name, *frames, axis))


def stepped(engine, plant, inputs, times, scene_graph=None):
    """Returns the plant's state (N, nq + nv) at some times, from its default state."""
    builder = DiagramBuilder()
    system = engine.add_to(builder, plant, scene_graph)
    builder.ExportOutput(system.get_state_output_port(), "state")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = system.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    inputs(system, context)
    states = []
    for time in times:
        simulator.AdvanceTo(time)
        states.append(diagram.GetOutputPort("state").Eval(simulator.get_context()))
    return np.array(states)


@pytest.mark.parametrize(
    ("stiffness", "damping", "limit"),
    [(0.0, 1e4, 5.0), (0.0, 1e4, np.inf), (300.0, 20.0, 50.0), (0.0, 3.0, 1.0)],
)
def test_servos_answer_alike_below_and_at_their_limits(stiffness, damping, limit):
    def states(engine):
        plant = new_plant()
        _, joint = add_axis(
            plant, RevoluteJoint, "wheel", plant.world_body(), [0, 0, 1], 5.0, 0.3
        )
        actuator = plant.AddJointActuator("wheel", joint, limit)
        actuator.set_controller_gains(PdControllerGains(p=stiffness, d=damping))
        plant.Finalize()

        def inputs(system, context):
            instance = actuator.model_instance()
            desired = system.get_desired_state_input_port(instance)
            desired.FixValue(context, [0.4, 1.0])
            system.get_actuation_input_port(instance).FixValue(context, [0.7])

        return stepped(engine, plant, inputs, STEP * np.arange(1, 120))

    drake, mujoco = map(states, SAME_STEPS)
    assert np.abs(drake).max() > 0.1
    assert mujoco == pytest.approx(drake, rel=SOLVED, abs=SOLVED)


def material(friction, stiffness):
    properties = ProximityProperties()
    kind = CoulombFriction(friction, friction)
    AddContactMaterial(50.0, stiffness, kind, properties)
    return properties


def ball_on_a_floor(mass, stiffness, floor_friction, ball_friction):
    """Returns a plant of a ball that slides along x and z, and its scene graph."""
    plant, scene_graph = new_plant(), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    world = plant.world_body()
    slide, _ = add_axis(plant, PrismaticJoint, "x", world, [1, 0, 0], mass / 2, 0.1)
    ball, _ = add_axis(plant, PrismaticJoint, "z", slide, [0, 0, 1], mass / 2, 0.1)
    for body, shape, friction, k in (
        (world, HalfSpace(), floor_friction, 1e12),
        (ball, Sphere(0.1), ball_friction, stiffness),
    ):
        plant.RegisterCollisionGeometry(
            body, RigidTransform(), shape, body.name(), material(friction, k)
        )
    plant.Finalize()
    return plant, scene_graph


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES.keys())
@pytest.mark.parametrize("stiffness", [1e5, 5e6])
def test_a_ball_sinks_into_the_floor_by_its_stiffness(engine, stiffness):
    plant, scene_graph = ball_on_a_floor(10.0, stiffness, 0.5, 0.5)
    plant.SetDefaultPositions([0.0, 0.1])
    ((_, z, v_x, v_z),) = stepped(engine, plant, lambda *_: None, [1.0], scene_graph)
    # Half of the mass is carried by the slide.
    sunk = 5.0 * G / stiffness
    assert 0.1 - z == pytest.approx(sunk, rel=1e-3)
    assert (v_x, v_z) == pytest.approx((0.0, 0.0), abs=1e-6)


def balls_on_tiles():
    """Returns a plant of a soft and a hard ball on a floor of two boxes."""
    plant, scene_graph = new_plant(), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    world = plant.world_body()
    for name, x in (("left", -5.0), ("right", 5.0)):
        box, X_WG = Box(10.0, 10.0, 1.0), RigidTransform([x, 0.0, -0.5])
        plant.RegisterCollisionGeometry(world, X_WG, box, name, material(0.5, 1e12))
    for name, stiffness in (("soft", 1e5), ("hard", 1e6)):
        ball, _ = add_axis(plant, PrismaticJoint, name, world, [0, 0, 1], 5.0, 0.1)
        place = RigidTransform([3.0 if name == "hard" else -3.0, 0.0, 0.0])
        plant.RegisterCollisionGeometry(
            ball, place, Sphere(0.1), name, material(0.5, stiffness)
        )
    plant.Finalize()
    return plant, scene_graph


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES.keys())
def test_each_of_several_balls_sinks_by_its_own_stiffness(engine):
    # MuJoCo sorts pairs of geometries by their bodies.
    plant, scene_graph = balls_on_tiles()
    plant.SetDefaultPositions([0.1, 0.1])
    ((soft, hard, *_),) = stepped(engine, plant, lambda *_: None, [1.0], scene_graph)
    assert 0.1 - soft == pytest.approx(5.0 * G / 1e5, rel=1e-3)
    assert 0.1 - hard == pytest.approx(5.0 * G / 1e6, rel=1e-3)


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES.keys())
def test_the_forces_of_contacts_are_put_out_without_those_of_servos(engine):
    plant, scene_graph = ball_on_a_floor(10.0, 1e6, 0.5, 0.5)
    plant.SetDefaultPositions([0.0, 0.1])
    builder = DiagramBuilder()
    system = engine.add_to(builder, plant, scene_graph)
    port = system.get_generalized_contact_forces_output_port(ModelInstanceIndex(1))
    simulator = Simulator(builder.Build())
    context = system.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    pull = system.get_applied_generalized_force_input_port()
    pull.FixValue(context, [10.0, 0.0])
    simulator.AdvanceTo(1.0)
    # Friction holds against the pull, and the floor against the ball's half.
    assert port.Eval(context) == pytest.approx([-10.0, 5.0 * G], abs=1e-3)


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES.keys())
def test_torques_for_all_actuators_are_in_their_order(engine):
    plant = new_plant()
    for name, mass in (("a", 2.0), ("b", 3.0)):
        _, joint = add_axis(
            plant, PrismaticJoint, name, plant.world_body(), [1, 0, 0], mass, 0.1
        )
        plant.AddJointActuator(name, joint)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    plant.Finalize()

    def inputs(system, context):
        system.get_actuation_input_port().FixValue(context, [1.0, -6.0])

    ((_, _, a, b),) = stepped(engine, plant, inputs, [0.5 - STEP / 2])
    assert (a, b) == pytest.approx((0.5 / 2.0, -6.0 * 0.5 / 3.0), rel=1e-6)


def test_a_shape_that_mujoco_cannot_have_is_refused_by_name():
    plant, scene_graph = new_plant(), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    world = plant.world_body()
    ball, _ = add_axis(plant, PrismaticJoint, "z", world, [0, 0, 1], 1.0, 0.1)
    shape = Convex(0.1 * np.vstack([np.eye(3), np.zeros(3)]).T, "tip")
    plant.RegisterCollisionGeometry(
        ball, RigidTransform(), shape, "tip", material(0.5, 1e6)
    )
    plant.Finalize()
    with pytest.raises(ParameterError, match="cannot have a Convex touch") as error:
        Mujoco().add_to(DiagramBuilder(), plant, scene_graph)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES.keys())
def test_a_ball_that_slides_is_braked_by_both_surfaces_friction(engine):
    plant, scene_graph = ball_on_a_floor(10.0, 1e6, 0.2, 0.6)
    plant.SetDefaultPositions([0.0, 0.1 - 5.0 * G / 1e6])

    def push(_, context):
        context.SetDiscreteState(0, [*plant.GetDefaultPositions(), 0.8, 0.0])

    (first, later) = stepped(engine, plant, push, [0.15, 0.35], scene_graph)
    mu = 2.0 * 0.2 * 0.6 / (0.2 + 0.6)
    # Of half the weight, on the whole mass.
    braked = mu * G / 2.0
    assert (first[2] - later[2]) / 0.2 == pytest.approx(braked, rel=LIFTED)


def test_a_state_that_is_not_finite_stays_so_and_leaves_no_file(tmp_path, monkeypatch):
    # By itself, MuJoCo starts again from its default state, and writes a log.
    monkeypatch.chdir(tmp_path)
    plant, scene_graph = ball_on_a_floor(10.0, 1e6, 0.2, 0.6)

    def push(system, context):
        force = system.get_applied_generalized_force_input_port()
        force.FixValue(context, [np.nan, 0.0])

    (state,) = stepped(Mujoco(), plant, push, [0.1], scene_graph)
    assert not np.isfinite(state).all()
    assert list(tmp_path.iterdir()) == []
