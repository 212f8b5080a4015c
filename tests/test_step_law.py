"""A diagram as one law does, tick by tick, as the diagram in Drake's simulator."""

import itertools

import numpy as np
import pytest
from drake_mobman.diagrams import make_diagram
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import DiscreteTimeDelay, Gain

from drake_mobman.machine_code import machine_code
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.step_law import StepLawError, step_law

LOOPS = {
    "blending": ("kwon_arbitrary", []),
    "exact": ("kwon_arbitrary", ["decomposer=!Exact {}"]),
    "switching": ("kwon_arbitrary", ["decomposer=!Switching {}"]),
    "field": ("kwon_arbitrary", ["decomposer=!VelocityField {}"]),
    "by rates": ("kwon_arbitrary", ["inverse=rates", "start.psi=0.1"]),
    "spatial": ("kwon_spatial", []),
    "drive that lags": (
        "kwon_spatial",
        ["estimate=!Sent {delay: 0.05, bandwidth: 5.0}"],
    ),
    "jerk limited": ("kwon_spatial", ["smoother=!JerkLimited {}"]),
    "franka, turning": ("kwon_franka", ["fidelity=!Kinematic {}"]),
}


def stepped(law, command):
    """Returns each output over time, by the law alone, for commands (N, 3)."""
    step, begin = machine_code(law.trace, [law.step, law.begin])
    state = list(begin([*law.start, *command[0]]))
    rows = []
    for given in command:
        row = step([*state, *given])[:]
        state = row[len(row) - len(law.start) :]
        rows.append(row)
    ends = np.cumsum([x.size for x in law.outputs])
    parts = np.split(np.array(rows), ends, axis=1)
    return dict(zip([x.name for x in law.outputs], parts, strict=False))


@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_as_one_law_gives_what_drake_logs(name):
    scenario, overrides = LOOPS[name]
    overrides = [*overrides, "duration=12.0"]
    run = simulate(load_scenario(scenario, overrides))
    fed = load_scenario(scenario, [*overrides, "source=external"])
    law = step_law(make_diagram(fed, logged=False))
    found = stepped(law, run["source.ee_command"].tolist())
    assert found.keys() == {*run.signals} - {"source.ee_command"}
    for signal, values in found.items():
        np.testing.assert_allclose(values, run[signal], rtol=0, atol=1e-12)


def test_signals_are_named_in_the_order_of_the_numbers():
    law = step_law(make_diagram(load_scenario("kwon_1", ["source=external"])))
    assert [(x.name, x.size) for x in law.inputs] == [("ee_command", 3)]
    assert [x.name for x in law.state] == ["robot/kinematic", "guard"]
    assert len(law.variables) == sum(x.size for x in (*law.state, *law.inputs))
    assert law.period == load_scenario("kwon_1").period


def test_only_the_outputs_that_are_wanted_are_worked_out():
    diagram = make_diagram(load_scenario("kwon_1", ["source=external"]))
    law = step_law(diagram, ["arm_status"])
    assert [x.name for x in law.outputs] == ["arm_status"]


class Blind(LeafSystem):
    """Takes no Expressions."""

    def __init__(self):
        super().__init__()
        self.DeclareVectorInputPort("u", 1)
        self.DeclareVectorOutputPort("y", 1, lambda *_: None)


def diagram_of(*systems, wired=True):
    """Returns a diagram of blocks in a row."""
    builder = DiagramBuilder()
    for i, system in enumerate(systems):
        builder.AddNamedSystem(f"block{i}", system)
    for a, b in itertools.pairwise(systems):
        builder.Connect(a.get_output_port(), b.get_input_port())
    if wired:
        builder.ExportInput(systems[0].get_input_port(), "u")
    builder.ExportOutput(systems[-1].get_output_port(), "y")
    return builder.Build()


def test_a_block_that_takes_no_expressions_is_named():
    with pytest.raises(StepLawError, match=r"^block1 takes no Expressions"):
        step_law(diagram_of(Gain(2.0, 1), Blind()))


def test_an_input_that_nothing_feeds_is_named():
    with pytest.raises(StepLawError, match=r"^block0: nothing feeds u"):
        step_law(diagram_of(Gain(2.0, 1), Gain(3.0, 1), wired=False))


def test_blocks_of_different_periods_are_refused():
    a, b = DiscreteTimeDelay(0.1, 1, 1), DiscreteTimeDelay(0.2, 1, 1)
    with pytest.raises(StepLawError, match="block1 has a period of 0\\.2 s"):
        step_law(diagram_of(a, b))
