"""The live plots of the last seconds."""

import dataclasses as dc
from collections.abc import Collection
from typing import Any

from drake_mobman import signals
from drake_mobman.scenario import AnyScenario

SPAN = 20
"""Length of the time axis [s]."""

_INK, _FAINT = "#9aa4b2", "#2b323c"
_COLORS = ("#4cc2ff", "#ffb454")


@dc.dataclass(frozen=True)
class Plot:
    """Signals over time, and the limits of the first."""

    title: str
    unit: str
    series: dict[str, str]  # Names in the state that pages receive, by label.
    limits: tuple[float, ...] = ()

    def options(self) -> dict[str, Any]:
        """Returns the options of the plot for Apache ECharts."""
        axis = {
            "type": "value",
            "axisLine": {"onZero": False, "lineStyle": {"color": _FAINT}},
            "axisTick": {"show": False},
        }
        label = {"color": _INK, "fontSize": 10}
        several = len(self.series) > 1
        return {
            "animation": False,
            "color": list(_COLORS),
            "title": {
                "text": f"{self.title} [{self.unit}]",
                "left": 8,
                "top": 4,
                "textStyle": {"color": _INK, "fontSize": 11, "fontWeight": "normal"},
            },
            "legend": {
                "show": several,
                "right": 6,
                "top": 2,
                "itemWidth": 10,
                "itemHeight": 6,
                "textStyle": {"color": _INK, "fontSize": 10},
            },
            "grid": {"left": 40, "right": 10, "top": 26, "bottom": 18},
            "xAxis": axis
            | {
                "min": -SPAN,
                "max": 0,
                "interval": SPAN / 2,
                "splitLine": {"show": False},
                "axisLabel": label | {"formatter": "{value} s"},
            },
            "yAxis": axis
            | {
                "scale": True,
                "splitNumber": 3,
                "splitLine": {"lineStyle": {"color": _FAINT}},
                "axisLabel": label | self._label(),
                **self._range(),
            },
            "series": [self._line(i, label) for i, label in enumerate(self.series)],
        }

    def _range(self) -> dict[str, float]:
        """Returns the range of an axis that shows the limits, with a margin."""
        if not self.limits:
            return {}
        low, high = min(self.limits), max(self.limits)
        margin = 0.5 * (high - low)
        return {"min": round(low - margin, 2), "max": round(high + margin, 2)}

    def _label(self) -> dict[str, Any]:
        """Returns labels without the uneven numbers at the ends of such an axis."""
        return {"showMinLabel": False, "showMaxLabel": False} if self.limits else {}

    def _line(self, i: int, label: str) -> dict[str, Any]:
        line = {
            "name": label,
            "type": "line",
            "showSymbol": False,
            "silent": True,
            "lineStyle": {"width": 1.6},
            "data": [],
        }
        if i == 0 and self.limits:
            line["markLine"] = {
                "silent": True,
                "symbol": "none",
                "label": {"show": False},
                "lineStyle": {"color": "#ff6b6b", "type": "dashed", "opacity": 0.7},
                "data": [{"yAxis": limit} for limit in self.limits],
            }
        return line


def plots(scenario: AnyScenario, names: Collection[str]) -> list[Plot]:
    """Returns the plots of a scenario.

    Args:
        scenario: that is driven.
        names: of its signals; where a hand pulls, the error is a distance.
    """
    at = scenario.workspace
    error = "m" if signals.HAND_POSITION in names else "m/s"
    return [
        Plot("reach l", "m", {"l": "l"}, (at.l_min, at.l_max)),
        Plot("angle ψ", "rad", {"ψ": "psi"}, (at.psi_min, at.psi_max)),
        Plot("along the reach", "m/s", {"base": "base", "arm": "arm"}),
        Plot("base", "m/s, rad/s", {"v": "v_b", "ω": "omega_b"}),
        Plot("end effector error", error, {"error": "error"}),
    ]
