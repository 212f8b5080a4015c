"""The result of a benchmark as text: tables of Markdown."""

from typing import Any

from drake_mobman.analysis.markdown import markdown_table
from drake_mobman.benchmarking.cases import BLOCK, COMPILED, LAW, REFERENCE, SOLVER
from drake_mobman.benchmarking.control_tick import DIFF_IK
from drake_mobman.benchmarking.costs import Cost

_TABLE_3 = (
    "Kwon's table 3, on a machine that it does not name, has a mean of 90 µs, largest"
    " 270, smallest 40, for the proposed law, and 2340, 5520 and 1480 for the program."
)

_HEADINGS = {
    LAW: "Bare law",
    BLOCK: "Block in a diagram",
    COMPILED: "Compiled block in a diagram",
    SOLVER: "Solution of the program alone, its matrices given, beside the bare law",
}


_BLOCKS = {"python": "Python blocks", "compiled": "compiled", "bare": "bare plant"}


def report(content: dict[str, Any], name: str) -> str:
    """Returns the result of a benchmark as Markdown.

    Args:
        content: what `bench` returns.
        name: of the scenario.
    """
    ran_on = dict(content["ran_on"])
    date, processor, cores = (ran_on.pop(key) for key in ("date", "processor", "cores"))
    versions = ", ".join(f"{key} {value}" for key, value in ran_on.items())
    parts = [
        f"{date}, {processor}, {cores} cores; {versions}.",
        f"Time of a tick [µs], over {content['ticks']} ticks of `{name}` in"
        f" {content['turns']} turns. The ratio is to {REFERENCE} at the same level,"
        " of the medians of each turn: their median, and quartiles. The process had"
        f" {100 * content['core_share']:.0f} % of a core meanwhile. {_TABLE_3}",
    ]
    for level, costs in content["costs"].items():
        if costs:
            parts += [f"### {_HEADINGS[level]}", _cost_table(costs)]
    parts += [
        f"As {level}, {name} found no solution in {cost['unsolved']} of the ticks."
        for level, costs in content["costs"].items()
        for name, cost in costs.items()
        if cost["unsolved"]
    ]
    parts += [f"Left out: {line}." for line in content["missing"]]
    parts += [
        "### Real-time factor",
        "Simulated over wall time, with all blocks and loggers; and of the plant alone,"
        " where there is one.",
        _factor_table(content["real_time_factors"]),
        *_tick_parts(content["control_tick"]),
        *_wheels_parts(content["wheels"]),
        f"Two compiled diagrams of `{name}` in two threads take"
        f" {_with_quartiles(content['two_threads'])} times the wall time of one.",
    ]
    return "\n\n".join(parts)


def _tick_parts(tick: dict[str, Any]) -> list[str]:
    return [
        "### Control tick",
        f"Decomposer and arm inverse in a diagram, over {tick['ticks']} ticks of"
        f" `{tick['scenario']}` [µs]. The ratio is to {DIFF_IK}.",
        _cost_table(tick["costs"]),
    ]


def _wheels_parts(wheels: dict[str, Any]) -> list[str]:
    servo, rolling = wheels["factors"].values()
    rows = [
        [
            blocks,
            _digits(servo[kind]),
            _digits(rolling[kind]),
            _with_quartiles(wheels["wheels_to_servo"][kind]),
        ]
        for kind, blocks in _BLOCKS.items()
    ]
    names = [f"!{name}" for name in wheels["factors"]]
    return [
        "### On wheels",
        f"Simulated over wall time of `{wheels['scenario']}` at each fidelity, its step"
        f" {1e3 * wheels['step']:g} ms; and how many times the wall time wheels cost.",
        markdown_table(["blocks", *names, "wheels / servo"], rows),
    ]


def _cost_table(costs: dict[str, Cost]) -> str:
    columns = ("mean", "median", "p99", "max", "min")
    rows = [
        [
            name,
            *(_digits(cost[f"{column}_us"]) for column in columns),
            _with_quartiles(cost["ratio"]),
        ]
        for name, cost in costs.items()
    ]
    return markdown_table(["decomposer", *columns, "ratio"], rows)


def _factor_table(factors: dict[str, Any]) -> str:
    keys = _BLOCKS
    rows = [
        [
            name,
            *(_digits(taken[key]) if key in taken else "-" for key in keys),
            *(
                _with_quartiles(taken[key]) if key in taken else "-"
                for key in ("compiled_to_python", "compiled_to_bare")
            ),
        ]
        for name, taken in factors.items()
    ]
    heading = ["scenario", *_BLOCKS.values()]
    return markdown_table([*heading, "compiled / Python", "compiled / bare"], rows)


def _digits(number: float) -> str:
    """Returns three digits, or as many as stand before the point."""
    return f"{number:.0f}" if number >= 100 else f"{number:.3g}"


def _with_quartiles(ratio: dict[str, float]) -> str:
    return f"{ratio['median']:.3g} ({ratio['low']:.3g}..{ratio['high']:.3g})"
