"""Robots that come with the package, each with scenarios fitted to it."""

import dataclasses as dc

from drake_mobman.analysis.compare import chosen_decomposers, with_each
from drake_mobman.analysis.studies.study import Column, error, metric, ratio
from drake_mobman.estimation.measured import Measured
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.file import File
from drake_mobman.robots.wheels import Wheels
from drake_mobman.scenario import AnyScenario, ScenarioError
from drake_mobman.scenario.fitted import fitted_guided, fitted_teleop
from drake_mobman.scenario_files import robot_paths

_EXACT, _BLENDING = error("exact"), error("blending")


@dc.dataclass(frozen=True)
class Robots:
    """Each robot driven by the same stick, decomposed exactly and blended; and led.

    Those that have wheels are driven on them too, by what is sent and by what is
    measured.
    """

    name: str = "robots"
    help: str = "each robot of the package, driven by a stick and led by hand"
    own: bool = True
    columns: tuple[Column, ...] = (
        Column("exact", "mm/s", _EXACT),
        Column("blending", "mm/s", _BLENDING),
        Column("ratio", "", ratio(_BLENDING, _EXACT)),
        Column("on wheels", "mm/s", error("exact on wheels")),
        Column("measured", "mm/s", error("measured on wheels")),
        Column("hand force", "N", metric("guided", "hand_force_max")),
        Column("hand error", "cm", metric("guided", "hand_error_max", 1e2)),
    )

    def rows(self, _: AnyScenario | None) -> dict[str, dict[str, AnyScenario]]:
        """Returns the scenarios of each robot whose model is installed."""
        return {name: fitted(File(str(path))) for name, path in robot_paths().items()}


def fitted(robot: File) -> dict[str, AnyScenario]:
    """Returns the scenarios of a robot: driven exactly, blended, and led by hand.

    And driven exactly on its wheels, where it has any, by what is sent and measured.

    Raises:
        ScenarioError: where one does not fit.
    """
    chosen = chosen_decomposers(("exact", "blending"))
    try:
        found = with_each(fitted_teleop(robot), chosen)
        if robot.described().layout.wheels:
            rolling = dc.replace(found["exact"], fidelity=Wheels())
            found["exact on wheels"] = checked(rolling)
            measured = dc.replace(rolling, estimate=Measured())
            found["measured on wheels"] = checked(measured)
        return {**found, "guided": checked(fitted_guided(robot))}
    except ParameterError as error:
        raise ScenarioError(str(error)) from None
