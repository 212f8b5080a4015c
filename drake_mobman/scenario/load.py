"""Scenarios read from files.

Layers, of which a later one overrides an earlier one: defaults, the robot's defaults,
the scenario's file, and overrides given as `key.path=value`.
"""

import dataclasses as dc
import textwrap
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from drake_mobman.files import read_file
from drake_mobman.parameters import ParameterError, quoted
from drake_mobman.scenario.guided import Guided
from drake_mobman.scenario.old_names import with_new_names
from drake_mobman.scenario.robot_path import located, robot_warnings
from drake_mobman.scenario.teleop import Teleop
from drake_mobman.scenario_files import scenario_paths
from drake_mobman.schema import load_typed, load_yaml, with_override
from drake_mobman.teleop.recorded import Recording

AnyScenario = Teleop | Guided
"""A tag at the top of a scenario's file selects one; `!Teleop` may be left out."""


def played_back(scenario: AnyScenario, folder: Path) -> AnyScenario:
    """Returns a scenario with its recording, if it has one, found in `folder`.

    It lasts no longer than the recording.

    Raises:
        ParameterError: where the recording cannot be read.
    """
    if not isinstance(scenario.source, Recording):
        return scenario
    source = scenario.source.in_folder(folder)
    try:
        last = len(source.samples(scenario.period)) - 1
    except ParameterError as error:
        raise error.below("source") from None
    duration = min(scenario.duration, last * scenario.period)
    return dc.replace(scenario, source=source, duration=duration)


class ScenarioError(ValueError):
    """A scenario that cannot be run; the message is one line."""


_LONGEST = 1_000_000
"""Largest size of a scenario's file [bytes]: it takes a minute to read."""


def load_scenario(name: str | Path, overrides: Sequence[str] = ()) -> AnyScenario:
    """Returns a scenario.

    Args:
        name: one of `scenario_paths`, or a path. The `scenario.yaml` of a run folder
            gets the folder's name.
        overrides: `key.path=value` each.

    Raises:
        ScenarioError: names in one line what is wrong, where, and what is valid.
    """
    name = str(name)
    path = scenario_paths().get(name, Path(name))
    text = _text(name, path)
    stem = path.resolve().parent.name if path.name == "scenario.yaml" else path.stem
    if not stem.isprintable():
        # The name is used for a folder, a title, and in other files.
        raise ScenarioError(f"{stem!r}: a scenario's name must be printable text")
    label = path.name
    try:
        data = load_yaml(text)
        data = located({} if data is None else data, path.parent.absolute())
        for override in overrides:
            label = "--set"
            data = located(_overridden(data, override), Path.cwd())
        label = f"{path.name} with --set" if overrides else path.name
        scenario = load_typed(AnyScenario, with_new_names(data, label))
        for line in robot_warnings(scenario.robot):
            warnings.warn(f"{label}: {line}", UserWarning, stacklevel=2)
        return dc.replace(played_back(scenario, path.parent), name=stem)
    except ParameterError as error:
        raise ScenarioError(f"{label}: {error}") from None
    except (RuntimeError, ValueError, ArithmeticError, SystemExit) as error:
        # pydrake turns Drake's failed assertions into `SystemExit`.
        reason = textwrap.shorten(str(error), 200, placeholder=" ...")
        raise ScenarioError(f"{label}: cannot be built; {reason}") from None


def _text(name: str, path: Path) -> str:
    """Returns the text of a scenario's file, or raises `ScenarioError`."""
    name = quoted(name)
    try:
        return read_file(path, _LONGEST).decode()
    except FileNotFoundError:
        known = ", ".join(scenario_paths())
        why = f"no such scenario; valid names are {known}, or a path"
        raise ScenarioError(f"{name}: {why}") from None
    except OSError as error:
        raise ScenarioError(f"{name}: cannot be read; {error.strerror}") from None
    except ValueError as error:  # Bytes that are not text, or a path with a NUL.
        raise ScenarioError(f"{name}: cannot be read; {error}") from None


def _overridden(data: Any, override: str) -> Any:
    """Returns data with `key.path=value` set, or raises `ParameterError`."""
    key, equals, text = override.partition("=")
    if not equals or not key:
        raise ParameterError("override", override, "must be key.path=value")
    try:
        value = load_yaml(text)
    except ParameterError as error:
        raise ParameterError(f"{key}, {error.key}", error.value, error.valid) from None
    return with_override(data, key, value)
