"""Tries cases of `test_fuzz`, in a process that may be lost with one.

Reads a case a line from standard input: {"name": .., "text": .., "overrides": [..]}.
With a text, or its bytes in Latin 1, that is put into a file of the name. Answers each
with a line: what became of it, or the traceback that came out.
"""

import dataclasses as dc
import json
import os
import resource
import sys
import tempfile
import traceback
from pathlib import Path

from drake_mobman.scenario import AnyScenario, ScenarioError, load_scenario
from drake_mobman.schema import dump_typed, load_typed, load_yaml
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.external import External
from drake_mobman.teleop.recorded import Recording

TICKS = 3
MEMORY = 4_000_000_000
"""Of the whole process [bytes]; a tenth of it is what Drake takes."""


def outcome(case, folder):
    """Returns `refused`, `died` or `ran`; raises where something else comes of it."""
    name = case["name"]
    if case["text"] is not None:
        name = folder / name
        name.write_bytes(case["text"].encode("latin-1"))
    try:
        scenario = load_scenario(str(name), case["overrides"])
    except ScenarioError as error:
        line = str(error)
        assert line.isprintable(), line
        assert 10 < len(line) < 1500, line
        return "refused"
    if not isinstance(getattr(scenario, "source", None), Recording):
        again = load_typed(AnyScenario, load_yaml(dump_typed(scenario)))
        assert again == scenario, dump_typed(scenario)
    if isinstance(getattr(scenario, "source", None), External):
        return "ran"  # As far as it goes without a program.
    run = simulate(dc.replace(scenario, duration=TICKS * scenario.period))
    assert "\n" not in run.died
    assert not run.died, run.died
    return "ran"


def main():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    # What Drake's solvers print is no answer.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    with tempfile.TemporaryDirectory() as folder:
        for line in sys.stdin:
            try:
                answer = outcome(json.loads(line), Path(folder))
            except BaseException:
                answer = traceback.format_exc()
            print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
