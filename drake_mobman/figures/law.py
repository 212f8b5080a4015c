"""The law that the base follows in a scenario, as figures need it."""

from typing import Any

from drake_mobman.robot_model import BaseLimits
from drake_mobman.scenario import AnyScenario

_SYMBOLS = {"alpha": (r"\alpha", "1/m"), "beta": (r"\beta", "1/rad")}
"""Parameters that a title shows, where a law has them: symbol and unit."""


def law_of(scenario: AnyScenario) -> Any:
    """Returns the parameters of the decomposer, or base controller, that drives."""
    return scenario.controllers[0]


def name_of(law: Any) -> str:
    """Returns a law's name as a title shows it."""
    if hasattr(law, "law"):
        return f"{law.law} field"
    shown = [
        f"${symbol}$ = {getattr(law, key):g} {unit}"
        for key, (symbol, unit) in _SYMBOLS.items()
        if hasattr(law, key)
    ]
    share = getattr(law, "share", "tanh")
    shown += [share] if share != "tanh" else []
    return ", ".join([type(law).__name__.lower(), *shown])


def smoothed_limits(scenario: AnyScenario) -> BaseLimits | None:
    """Returns the limits of smoothed base commands; None if they are not smoothed."""
    limits = scenario.smoother.limits()
    return None if limits.follows_at_once else limits
