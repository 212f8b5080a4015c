"""The figures of a velocity field, written to a folder."""

from collections.abc import Callable
from pathlib import Path

from drake_mobman.base.velocity_field import VelocityField
from drake_mobman.figures.field import field_figures
from drake_mobman.report.pictures import png
from drake_mobman.scenario import AnyScenario
from drake_mobman.simulation.output_folder import OutputFolder

FIELD = ("field_*.png",)
"""Patterns of the files that may be replaced."""


def write_field(
    scenario: AnyScenario, path: Path, drawn: Callable[[Callable[[], bytes]], bytes]
) -> None:
    """Draws the velocity field of a scenario to a folder, if the scenario has one.

    Args:
        scenario: checked, as `load_scenario` returns it.
        path: of the folder, new or of earlier figures.
        drawn: calls a figure's function; it may raise `KeyboardInterrupt`.

    Raises:
        OSError: where it cannot be written; then the folder is unchanged.
    """
    params = scenario.base_controller
    if not isinstance(params, VelocityField):
        return
    reach, smoother, names = scenario.robot.reach(), scenario.smoother, []
    with OutputFolder(path, FIELD) as folder:
        for name, figure in field_figures(params, reach, smoother):
            content = drawn(lambda figure=figure: png(figure))  # type: ignore[misc]
            folder.file(f"{name}.png").write_bytes(content)
            names.append(f"{name}.png")
        folder.publish(names, anew=True)
