"""The law that the base follows in a scenario, as figures need it."""

import functools
from collections.abc import Callable
from typing import Any

from drake_mobman.base.smoother import Smoother
from drake_mobman.decomposers.blending import Blending, blending_shares
from drake_mobman.decomposers.exact import Exact
from drake_mobman.decomposers.share import Projection
from drake_mobman.decomposers.switching import Switching, switching_shares
from drake_mobman.scenario.scenario import AnyScenario

_SYMBOLS = {"alpha": (r"\alpha", "1/m"), "beta": (r"\beta", "1/rad")}
"""Parameters that a title shows, where a law has them: symbol and unit."""


def law_of(scenario: AnyScenario) -> Any:
    """Returns the parameters of the decomposer, or of the field, that drives first."""
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


# Until each of these has a method `shares`, and those with a projection hold it.
_SHARES: dict[type, Callable[..., Any]] = {
    Blending: blending_shares,
    Exact: blending_shares,
    Switching: switching_shares,
}


def shares_of(law: Any) -> Callable[..., Any] | None:
    """Returns a function of limits, command and `ee_cylindrical`: the base's shares.

    None for a law that does not split the command by shares.
    """
    if hasattr(law, "shares"):
        return law.shares
    by_kind = _SHARES.get(type(law))
    return by_kind and functools.partial(by_kind, law)


def projection_of(scenario: AnyScenario) -> Projection | None:
    """Returns how the base's speed follows from its share, where it does."""
    law: Any = law_of(scenario)
    if isinstance(law, Blending | Switching):
        return getattr(law, "projection", None) or getattr(scenario, "projection", None)
    return getattr(law, "projection", None)


def smoother_of(scenario: AnyScenario) -> Smoother | None:
    """Returns the smoother of the base commands; None where they are not smoothed."""
    return scenario.smoother if smooths(scenario.smoother) else None


def smooths(smoother: Any) -> bool:
    """Returns whether base commands are smoothed, and kept within limits."""
    return getattr(smoother, "enabled", hasattr(smoother, "max_acceleration"))
