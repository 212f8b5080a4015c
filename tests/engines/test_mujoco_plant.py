"""MuJoCo in the plant's place: servos, contacts and whole scenarios as in Drake."""

import numpy as np
import pytest
from pydrake.geometry import (
    AddContactMaterial,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_mobman.engines import Drake, Mujoco

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
