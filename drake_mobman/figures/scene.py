"""The motion in 3D, as a page to open in a browser."""

import numpy as np
from pydrake.geometry import (
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Rgba,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.systems.rendering import MultibodyPositionToGeometryPose
from pydrake.trajectories import PiecewisePolynomial

from drake_mobman import signals
from drake_mobman.analysis.motion import ee_motion
from drake_mobman.meshcat import offline_meshcat
from drake_mobman.robot_model.model import drawn_plant
from drake_mobman.simulation.run import Run

_FRAME_RATE = 32.0
"""Frames a second; a power of two, so that their times have no rounding errors."""


def scene(run: Run) -> str:
    """Returns the page of a run of two samples or more, made by Meshcat."""
    log, robot = run.log, run.scenario.robot
    times = log["time"]
    builder = DiagramBuilder()
    plant, scene_graph = drawn_plant(robot)
    builder.AddSystem(scene_graph)
    q = np.hstack([log[signals.BASE_POSE], log[signals.ARM_POSITION]])
    source = builder.AddSystem(
        TrajectorySource(PiecewisePolynomial.FirstOrderHold(times, q.T))
    )
    poses = builder.AddSystem(MultibodyPositionToGeometryPose(plant))
    builder.Connect(source.get_output_port(), poses.get_input_port())
    builder.Connect(
        poses.get_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    meshcat = offline_meshcat()
    MeshcatVisualizer.AddToBuilder(
        builder,
        scene_graph,
        meshcat,
        MeshcatVisualizerParams(publish_period=1 / _FRAME_RATE),
    )
    tool = log.get(signals.TOOL_POSITION)
    path = ee_motion(run).position if tool is None else tool[:, :2]
    height = np.full(len(path), 0.005)
    meshcat.SetLine(
        "/end_effector_path", np.vstack([path.T, height]), 3, Rgba(0.1, 0.55, 0.75)
    )
    base = np.vstack([log[signals.BASE_POSE][:, :2].T, height])
    meshcat.SetLine("/base_path", base, 3, Rgba(0.5, 0.5, 0.5))
    lowest, highest = q[:, :2].min(0), q[:, :2].max(0)
    target = np.array([*(lowest + highest) / 2, 0.4])
    away = 0.8 + float(np.linalg.norm(highest - lowest)) / 6
    meshcat.SetCameraPose(target + away * np.array([-1.0, -2.2, 1.4]), target)

    simulator = Simulator(builder.Build())
    meshcat.StartRecording(frames_per_second=_FRAME_RATE)
    simulator.AdvanceTo(float(times[-1]))
    meshcat.PublishRecording()
    return meshcat.StaticHtml()
