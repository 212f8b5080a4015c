"""Scenarios run from a script or a notebook, in a line of Python."""

import base64
import dataclasses as dc
import html
import io
import warnings
from collections.abc import Iterator, Mapping
from numbers import Real
from pathlib import Path
from typing import Any

from drake_mobman.analysis.metrics import metrics
from drake_mobman.analysis.table import shown, table_of
from drake_mobman.figures.path import draw_path
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.scenario import AnyScenario, ScenarioError, load_scenario
from drake_mobman.scenario.scenario import OF_ROBOT
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.simulate import simulate as run_of

_LEFT, _RIGHT = 'style="text-align: left"', 'style="text-align: right"'


class NotebookRun(Run):
    """A run that measures and draws itself.

    `run["ee_command"]` is a signal over time (N, size), and `run.time` (N,) [s].
    """

    def metrics(self) -> dict[str, Any]:
        """Returns the numbers by which runs are compared, by name."""
        return metrics(self)

    def __repr__(self) -> str:
        """Returns how long the run is, and how it ended, in one line."""
        end = self.died or f"{self.time[-1]:g} s"
        return f"<{type(self).__name__}: {end}, {len(self.time)} samples>"

    def _repr_html_(self) -> str:
        """Returns metrics and path as HTML, for a notebook."""
        lines = [f"<p>{html.escape(self.scenario.description)}</p>"]
        if self.died:
            lines.append(f"<p><strong>{html.escape(self.died)}</strong></p>")
        lines += ["<table>", *_rows(self.metrics()), "</table>"]
        if len(self.time):
            lines.append(_picture(self))
        return "\n".join(lines)


def simulate(scenario: str | Path | AnyScenario, **changes: Any) -> NotebookRun:
    """Simulates a scenario from its start to its end, or to where it died.

    ::

        run = mm.simulate("kwon_spatial", decomposer=mm.Blending(alpha=10), duration=5)

    Args:
        scenario: name of a scenario, path of its file, or a scenario itself.
        changes: new values of fields of the scenario. A new `robot` brings its own
            start, limits and gains, unless they are given too.

    Raises:
        ScenarioError: where there is no such scenario, or it cannot be run.
        ParameterError: where a change is not valid; a line with what would be.
    """
    if isinstance(scenario, str | Path):
        scenario = load_scenario(scenario)
    run = run_of(changed(scenario, changes))
    if run.died:
        warnings.warn(run.died, RuntimeWarning, stacklevel=2)
    return NotebookRun(**{f.name: getattr(run, f.name) for f in dc.fields(run)})


def changed(scenario: AnyScenario, changes: Mapping[str, Any]) -> AnyScenario:
    """Returns a scenario with other values of some of its fields, checked.

    Raises:
        ScenarioError: where there is no such field.
        ParameterError: where a value is not valid.
    """
    fields = {field.name: field for field in dc.fields(scenario)}
    values: dict[str, Any] = {}
    if "robot" in changes:
        values = {f.name: OF_ROBOT for f in fields.values() if f.default is OF_ROBOT}
    for key, value in changes.items():
        if key not in fields:
            valid = f"valid fields are: {', '.join(fields)}"
            raise ScenarioError(f"{key}: no such field of the scenario; {valid}")
        values[key] = _of_type(fields[key].type, key, value)
    return checked(dc.replace(scenario, **values))


def _of_type(expected: Any, key: str, value: Any) -> Any:
    """Returns a value as a field of a type takes it, or raises `ParameterError`.

    Parameters may be of any class of the user's own.
    """
    if expected is float and isinstance(value, Real) and not isinstance(value, bool):
        return float(value)
    if expected in (bool, str, float):
        if not isinstance(value, expected):
            raise ParameterError(key, value, f"must be of type {expected.__name__}")
    elif isinstance(value, type) or not (dc.is_dataclass(value) or type(value) is list):
        raise ParameterError(key, value, "must be parameters, such as `mm.Blending()`")
    return value


def _rows(numbers: dict[str, Any]) -> Iterator[str]:
    """Yields the rows of a table of metrics."""
    for group in table_of({"": numbers}):
        title = html.escape(group.title)
        yield f'<tr><th colspan="3" {_LEFT}>{title}</th></tr>'
        for row in group.rows:
            cells = row.label, shown(row.values[""]), row.unit
            label, value, unit = map(html.escape, cells)
            yield (
                f"<tr><td {_LEFT}>{label}</td><td {_RIGHT}>{value}</td>"
                f"<td {_LEFT}>{unit}</td></tr>"
            )


def _picture(run: Run) -> str:
    """Returns the paths of base and end effector, as an image that holds itself."""
    content = io.BytesIO()
    draw_path(run).savefig(content, format="png")
    data = base64.b64encode(content.getvalue()).decode()
    alt = "Paths of base and end effector, seen from above"
    return (
        f'<img alt="{alt}" style="max-width: 100%" src="data:image/png;base64,{data}">'
    )
