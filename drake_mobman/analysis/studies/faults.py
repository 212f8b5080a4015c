"""Faults of floor and drive, each met by what is sent and by what is measured."""

import dataclasses as dc
from collections.abc import Mapping
from typing import Any

from drake_mobman.analysis.compare import chosen_decomposers, with_each
from drake_mobman.analysis.studies.study import Column, Results, error, metric, ratio
from drake_mobman.estimation.measured import Measured
from drake_mobman.estimation.sent import Sent
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.wheels.drive import Drive
from drake_mobman.robots.wheels.floor import Bump, Floor, Patch
from drake_mobman.robots.wheels.sensors import Sensors
from drake_mobman.robots.wheels.wheels import Wheels
from drake_mobman.scenario import AnyScenario, ScenarioError, Teleop

_NOISE = 0.002
"""Of the noisy measurement: standard deviation of v and v_y [m/s], omega [rad/s]."""

_LATENCY = 0.02
"""Of the noisy measurement [s]."""

_GRADE = 0.0873
"""A slope of five degrees [rad]."""

_ALL = Drive(delay=0.05, bandwidth=5.0, left_radius=1.03)


def _bump(y: float) -> Bump:
    """Returns a bump for a wheel alone: a caster has no spring that gets it over."""
    return Bump(y=y, width=0.1, height=0.005)


FAULTS: dict[str, dict[str, Any]] = {
    "none": {},
    "friction 0.05": {"floor": Floor(friction=0.05)},
    "friction 0.2, slope 5 deg": {"floor": Floor(friction=0.2, slope=_GRADE)},
    "friction 0.05 from 0.3 m": {
        "floor": Floor(patches=[Patch(x_min=0.3, friction=0.05)])
    },
    "left wheel 3 % large": {"drive": Drive(left_radius=1.03)},
    "track 5 % wide": {"drive": Drive(track=1.05)},
    "delay 50 ms": {"drive": Drive(delay=0.05)},
    "motors of 5 Hz": {"drive": Drive(bandwidth=5.0)},
    "friction 0.2, 3 %, 50 ms, 5 Hz": {"floor": Floor(friction=0.2), "drive": _ALL},
    "bump of 5 mm, left": {"floor": Floor(bumps=[_bump(0.2)])},
    "bump of 5 mm, both": {"floor": Floor(bumps=[_bump(0.2), _bump(-0.2)])},
    "step down 2 mm": {"floor": Floor(patches=[Patch(height=-0.002)])},
}
"""What is wrong, by its name; as parameters of `Wheels`."""


def _jerk(run: str) -> Any:
    return ratio(metric(run, "base_jerk_rms"), metric("sent", "base_jerk_rms"))


def _stopped(results: Results) -> float | None:
    """Returns how many of a row's runs died, or were stopped by the guard."""
    refused = (metric(run, "commands_refused")(results) for run in results)
    died = (bool(each.get("died")) for each in results.values())
    return float(sum(d or bool(r) for d, r in zip(died, refused, strict=True)))


@dc.dataclass(frozen=True)
class Faults:
    """Each fault: blending, the exact law by what is sent, and by what is measured."""

    name: str = "faults"
    help: str = "faults of floor and drive, met by what is sent and what is measured"
    own: bool = False
    columns: tuple[Column, ...] = (
        Column("blending", "mm/s", error("blending")),
        Column("sent", "mm/s", error("sent")),
        Column("measured", "mm/s", error("measured")),
        Column("noisy", "mm/s", error("noisy")),
        Column("jerk, measured", "of sent", _jerk("measured")),
        Column("jerk, noisy", "of sent", _jerk("noisy")),
        Column("stopped", "", _stopped),
    )

    def rows(self, scenario: AnyScenario | None) -> dict[str, dict[str, AnyScenario]]:
        """Returns the scenario's variants for each fault.

        Raises:
            ScenarioError: where it cannot be driven on wheels.
        """
        if not isinstance(scenario, Teleop):
            raise ScenarioError("--over faults needs a Teleop scenario")
        try:
            return {name: variants(scenario, fault) for name, fault in FAULTS.items()}
        except ParameterError as error:
            raise ScenarioError(str(error)) from None


def variants(scenario: Teleop, fault: Mapping[str, Any]) -> dict[str, AnyScenario]:
    """Returns a scenario on wheels with a fault: blended, and decomposed exactly.

    Args:
        scenario: its own parameters of wheels are kept, but for those of the fault.
        fault: parameters of `Wheels`.

    Raises:
        ParameterError: where it cannot be driven on wheels.
    """
    given = scenario.fidelity
    wheels = given if isinstance(given, Wheels) else Wheels()
    wheels = dc.replace(wheels, **fault)
    latency = max(round(_LATENCY / scenario.period), 1) * scenario.period
    sensors = Sensors(
        measured_noise=_NOISE, measured_yaw_noise=_NOISE, measured_latency=latency
    )
    each = with_each(scenario, chosen_decomposers(("exact", "blending")))
    exact = dc.replace(each["exact"], fidelity=wheels)
    found = {
        "blending": dc.replace(each["blending"], fidelity=wheels, estimate=Sent()),
        "sent": dc.replace(exact, estimate=Sent()),
        "measured": dc.replace(exact, estimate=Measured()),
        "noisy": dc.replace(
            exact,
            estimate=Measured(latency=latency),
            fidelity=dc.replace(wheels, sensors=sensors),
        ),
    }
    return {name: checked(one) for name, one in found.items()}
