"""Variants of a scenario, by decomposer and engine, and the metrics of their runs."""

import dataclasses as dc
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from drake_mobman.analysis.metrics import metrics
from drake_mobman.analysis.table import flat_table
from drake_mobman.decomposers import Decomposer
from drake_mobman.engines import Engine
from drake_mobman.parameters import ParameterError, checked
from drake_mobman.robots.defaults import default_of
from drake_mobman.scenario import AnyScenario, ScenarioError, Teleop
from drake_mobman.simulation.run import Run
from drake_mobman.simulation.run_folder import finite
from drake_mobman.simulation.simulate import simulate
from drake_mobman.simulation.tick_times import tick_times

_SHARED = {"alpha", "beta", "projection"}
"""Parameters copied from the scenario's decomposer, for a fair comparison."""


def decomposers_by_name() -> dict[str, type]:
    """Returns the parameters' class of each decomposer, by its name in lower case."""
    return {kind.__name__.lower(): kind for kind in typing.get_args(Decomposer)}


def engines_by_name() -> dict[str, type]:
    """Returns the parameters' class of each engine, by its name in lower case."""
    # Of one engine alone there is no union.
    kinds = typing.get_args(Engine) or (Engine,)
    return {kind.__name__.lower(): kind for kind in kinds}


def chosen_decomposers(names: Sequence[str]) -> dict[str, type]:
    """Returns some of `decomposers_by_name`, as `_chosen` does."""
    return _chosen("--decomposers", names, decomposers_by_name())


def chosen_engines(names: Sequence[str]) -> dict[str, type]:
    """Returns some of `engines_by_name`, as `_chosen` does."""
    return _chosen("--engine", names, engines_by_name())


def _chosen(
    option: str, names: Sequence[str], known: Mapping[str, type]
) -> dict[str, type]:
    """Returns some of the kinds that are known, in the order of their names.

    Args:
        option: where they are named, for messages.
        names: as in a scenario; upper or lower case.
        known: kinds by name.

    Raises:
        ParameterError: where a name is not known, or is given twice.
    """
    chosen: dict[str, type] = {}
    for given in names:
        name = given.strip().lstrip("!").lower()
        if name not in known:
            valid = f"must be one of {', '.join(known)}"
            raise ParameterError(option, given, valid)
        if name in chosen:
            raise ParameterError(option, given, "must be given once")
        chosen[name] = known[name]
    return chosen


def variants_of(
    scenario: AnyScenario,
    decomposers: Mapping[str, type] | None = None,
    engines: Mapping[str, type] | None = None,
) -> dict[str, AnyScenario]:
    """Returns a scenario with each of some decomposers, in each of some engines.

    Args:
        scenario: checked, as `load_scenario` returns it.
        decomposers: as `chosen_decomposers` returns them; its own unless given.
        engines: as `chosen_engines` returns them; its own unless given.

    Raises:
        ScenarioError: where a variant does not work.
    """
    variants: dict[str, AnyScenario] = {"": scenario}
    if decomposers:
        variants = {**with_each(scenario, decomposers)}
    return in_each(variants, engines) if engines else variants


def in_each(
    scenarios: Mapping[str, AnyScenario], engines: Mapping[str, type]
) -> dict[str, AnyScenario]:
    """Returns each scenario in each engine, by both names, as `exact, mujoco`.

    A scenario's own engine keeps its parameters.

    Raises:
        ScenarioError: where an engine does not work with a scenario.
    """
    variants = {}
    for name, scenario in scenarios.items():
        for engine, kind in engines.items():
            own = scenario.engine
            params = own if isinstance(own, kind) else kind()
            try:
                variant = checked(dc.replace(scenario, engine=params))
            except ParameterError as error:
                raise ScenarioError(f"with engine={engine}: {error}") from None
            variants[", ".join(filter(None, (name, engine)))] = variant
    return variants


def with_each(
    scenario: AnyScenario, decomposers: Mapping[str, type]
) -> dict[str, Teleop]:
    """Returns the scenario with each of the decomposers, by name.

    The scenario's own decomposer keeps its parameters. The others get parameters that
    fit the robot, but those in `_SHARED` are the same for all.

    Raises:
        ScenarioError: where the end effector is not commanded, or where a decomposer
            does not work with the rest of the scenario.
    """
    scenario = commanded(scenario)
    variants = {}
    for name, kind in decomposers.items():
        try:
            params = _like(scenario.decomposer, default_of(scenario.robot, kind))
            # A recorded operator cannot choose another decomposer.
            variant = dc.replace(scenario, decomposer=params, alternatives=[])
            checked(variant)
        except ParameterError as error:
            raise ScenarioError(f"with decomposer={name}: {error}") from None
        variants[name] = variant
    return variants


def commanded(scenario: AnyScenario) -> Teleop:
    """Returns a scenario that has a decomposer.

    Raises:
        ScenarioError: where it has none, as the end effector is not commanded.
    """
    if not hasattr(scenario, "decomposer"):
        tag = type(scenario).__name__
        raise ScenarioError(f"!{tag} has no command to decompose; must be !Teleop")
    return typing.cast(Teleop, scenario)


def _like(first: Any, other: Any) -> Any:
    """Returns `first` if both are of one class; else `other` with shared parameters."""
    if isinstance(first, type(other)):
        return first
    shared = _SHARED & {f.name for f in dc.fields(other)}
    same = {key: getattr(first, key) for key in shared if hasattr(first, key)}
    return dc.replace(other, **same)


@dc.dataclass
class Comparison:
    """Runs of a scenario's variants."""

    scenario: AnyScenario  # As it was given.
    runs: dict[str, Run]  # By the variant's name.
    metrics: dict[str, dict[str, Any]]  # Likewise; None for a number not finite.

    def table(self) -> dict[str, dict[str, Any]]:
        """Returns the value of each metric by variant, by the metric's flat name."""
        return flat_table(self.metrics)


def timed(_name: str, variant: AnyScenario) -> Run:
    """Returns the run of a variant, with its control ticks timed if it did not die."""
    run = simulate(variant)
    if not run.died:
        run.tick_times = tick_times(variant)
    return run


def compared(
    scenario: AnyScenario,
    variants: Mapping[str, AnyScenario],
    simulated: Callable[[str, AnyScenario], Run] = timed,
    stop: Callable[[], bool] = lambda: False,
) -> Comparison:
    """Returns the runs of a scenario's variants.

    Args:
        scenario: checked, as `load_scenario` returns it.
        variants: as `variants_of` returns them.
        simulated: runs a variant, given its name.
        stop: called before each run; returns whether the user wants to stop.

    Raises:
        KeyboardInterrupt: where the user stopped before there was any result.
    """
    runs: dict[str, Run] = {}
    for name, variant in variants.items():
        if stop():
            break
        runs[name] = simulated(name, variant)
        if runs[name].interrupted:
            break
    logged = any(len(run.time) for run in runs.values())
    if not logged and (stop() or any(run.interrupted for run in runs.values())):
        raise KeyboardInterrupt
    numbers = {name: finite(metrics(run)) for name, run in runs.items()}
    return Comparison(scenario, runs, numbers)
