"""The live plots: what is drawn over the last seconds, and how it looks."""

import dataclasses as dc
from typing import Any

from drake_mobman.scenario import AnyScenario, Guided

SPAN = 20
"""How much of the past is drawn [s]."""

_INK, _FAINT = "#9aa4b2", "#2b323c"
_COLORS = ("#4cc2ff", "#ffb454")


@dc.dataclass(frozen=True)
class Plot:
    """Signals over time, and the limits of the first."""

    title: str
    unit: str
    series: dict[str, str]  # Names in the state that pages are told, by label.
    limits: tuple[float, ...] = ()

    def options(self) -> dict[str, Any]:
        """Returns it as Apache ECharts knows it."""
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
        """Returns an axis that shows the limits, and some more."""
        if not self.limits:
            return {}
        low, high = min(self.limits), max(self.limits)
        room = 0.5 * (high - low)
        return {"min": round(low - room, 2), "max": round(high + room, 2)}

    def _label(self) -> dict[str, Any]:
        """Returns labels without the odd numbers at the ends of such an axis."""
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


def plots(scenario: AnyScenario) -> list[Plot]:
    """Returns what the page draws of a scenario."""
    at = scenario.workspace
    error = "m" if isinstance(scenario, Guided) else "m/s"
    return [
        Plot("reach l", "m", {"l": "l"}, (at.l_min, at.l_max)),
        Plot("angle ψ", "rad", {"ψ": "psi"}, (at.psi_min, at.psi_max)),
        Plot("along the reach", "m/s", {"base": "base", "arm": "arm"}),
        Plot("base", "m/s, rad/s", {"v": "v_b", "ω": "omega_b"}),
        Plot("hand error", error, {"error": "error"}),
    ]
