"""Makes `docs/movie.gif`: a run of a scenario, drawn by Drake's own renderer.

    python docs/make_movie.py

It needs a graphics driver with EGL; on a machine without one, Mesa's software driver
does.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    GeometryInstance,
    LightParameter,
    MakeRenderEngineVtk,
    PerceptionProperties,
    RenderCameraCore,
    RenderEngineVtkParams,
    Rgba,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo

import drake_mobman as mm
from drake_mobman import signals

SCENARIO = "kwon_franka"
WIDTH, HEIGHT = 720, 320  # Of the picture [px].
FRAMES_PER_SECOND = 12
SPEED_UP = 4.0  # Seconds of the run in a second of the film.
COLOURS = 48  # In the file's palette: it is to be small.

END_EFFECTOR = np.array([0.0, 0.62, 0.45, 1.0])  # Colour of its path.
BASE = np.array([0.0, 0.45, 0.70, 1.0])
BACKGROUND = np.array([1.0, 1.0, 1.0])
SPACING = 0.04  # Between two dots of a path [m].


def dotted(points: np.ndarray) -> Iterator[np.ndarray]:
    """Yields points of a path (N, 3) that are `SPACING` apart or more."""
    last = points[0]
    for point in points:
        if np.linalg.norm(point - last) >= SPACING:
            last = point
            yield point


def painted(colour: np.ndarray) -> PerceptionProperties:
    """Returns what the renderer needs to know of a body of one `colour` (4,)."""
    properties = PerceptionProperties()
    properties.AddProperty("phong", "diffuse", Rgba(*colour))
    return properties


def add_path(
    scene_graph: Any, name: str, points: np.ndarray, radius: float, colour: np.ndarray
) -> None:
    """Draws a path (N, 3) in the world as a row of dots."""
    source = scene_graph.RegisterSource(name)
    for i, point in enumerate(dotted(points)):
        dot = GeometryInstance(RigidTransform(point), Sphere(radius), f"{name}_{i}")
        dot.set_perception_properties(painted(colour))
        scene_graph.RegisterAnchoredGeometry(source, dot)


def camera_at(eye: np.ndarray, target: np.ndarray) -> RigidTransform:
    """Returns X_WC of a camera at `eye` that looks at `target` [m]; z is up."""
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(ahead, right), ahead])
    return RigidTransform(RotationMatrix(axes), eye)


def tool_path(plant: Any, context: Any, q: np.ndarray) -> np.ndarray:
    """Returns p_WE (N, 3) at each row of `q` (N, 3 + n)."""
    tool, found = plant.GetFrameByName("tool"), []
    for row in q:
        plant.SetPositions(context, row)
        found.append(tool.CalcPoseInWorld(context).translation())
    return np.array(found)


def frames(log: dict[str, np.ndarray], urdf: str) -> Iterator[Image.Image]:
    """Yields the pictures of a run's log."""
    q = np.hstack([log[signals.BASE_POSE], log[signals.ARM_POSITION]])
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    plant = builder.AddSystem(MultibodyPlant(0.001))
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    Parser(plant).AddModelsFromString(urdf, "urdf")
    plant.Finalize()
    path = tool_path(plant, plant.CreateDefaultContext(), q)
    floor = np.zeros(len(q))
    add_path(scene_graph, "end_effector", path, 0.012, END_EFFECTOR)
    add_path(scene_graph, "base", np.column_stack([q[:, :2], floor]), 0.010, BASE)
    lights = [
        LightParameter(type="directional", direction=direction, intensity=intensity)
        for direction, intensity in (([0.4, 0.6, -1.0], 1.3), ([-1, 0.2, -0.3], 0.5))
    ]
    for light in lights:
        light.frame = "world"
    scene_graph.AddRenderer(
        "vtk",
        MakeRenderEngineVtk(
            RenderEngineVtkParams(
                default_clear_color=BACKGROUND, lights=lights, backend="EGL"
            )
        ),
    )
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    query_port = scene_graph.get_query_output_port()
    scene_context = scene_graph.GetMyContextFromRoot(context)

    core = RenderCameraCore(
        "vtk",
        CameraInfo(WIDTH, HEIGHT, np.radians(26.0)),
        ClippingRange(0.05, 100.0),
        RigidTransform(),
    )
    camera = ColorRenderCamera(core)
    passed = np.vstack([path[:, :2], q[:, :2]])
    target = np.array([*(passed.min(0) + passed.max(0)) / 2, 0.4])
    away = 1.8 + 0.95 * float(np.linalg.norm(np.ptp(passed, axis=0)))
    X_WC = camera_at(target + away * np.array([-0.3, -0.85, 0.4]), target)

    period = log["time"][1] - log["time"][0]
    every = round(SPEED_UP / FRAMES_PER_SECOND / period)
    for row in q[::every]:
        plant.SetPositions(plant_context, row)
        query = query_port.Eval(scene_context)
        image = query.RenderColorImage(camera, scene_graph.world_frame_id(), X_WC)
        yield Image.fromarray(image.data[:, :, :3].copy())


def write(pictures: list[Image.Image], path: Path) -> None:
    """Writes pictures as a film that repeats."""
    # One palette for all, of a picture where everything is seen.
    palette = pictures[len(pictures) // 2].quantize(COLOURS)
    first, *others = [
        picture.quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in pictures
    ]
    first.save(
        path,
        save_all=True,
        append_images=others,
        duration=round(1000 / FRAMES_PER_SECOND),
        loop=0,
        optimize=True,
    )
    print(f"{path}: {len(pictures)} pictures, {path.stat().st_size} bytes")


def main() -> None:
    """Runs the scenario and writes the film."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenario", default=SCENARIO)
    parser.add_argument("--out", default=Path(__file__).parent / "movie.gif", type=Path)
    given = parser.parse_args()
    scenario = mm.load_scenario(given.scenario)
    run = mm.simulate(scenario)
    write(list(frames(run.log, scenario.robot.urdf())), given.out)


if __name__ == "__main__":
    main()
