"""Controllers side by side: one drives, and hands over without a jump."""

import math

import numpy as np
import pytest
from drake_mobman.diagrams.choice import make_choice
from drake_mobman.diagrams.teleop import make_teleop_diagram
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator

from drake_mobman.console.choices import choice_names, live_scenario
from drake_mobman.decomposers.field import build_decomposer
from drake_mobman.parameters import ParameterError
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.log import read_log
from drake_mobman.teleop.choice import (
    ControllerSelector,
    Handover,
    Transition,
    faded,
    next_handover,
)
from drake_mobman.teleop.live import NOBODY, OperatorSample

ROUNDING = 1e-15
"""Of a sum of two commands below 1, faded."""

FINITE = st.floats(-10, 10)


@pytest.mark.parametrize(
    ("last", "choice", "after"),
    [
        (Handover(0, 0, 1.0), 0.0, Handover(0, 0, 1.0)),
        (Handover(0, 0, 1.0), 2.0, Handover(0, 2, 0.0)),
        (Handover(0, 2, 0.0), 2.0, Handover(0, 2, 0.25)),
        (Handover(0, 2, 0.75), 2.0, Handover(0, 2, 1.0)),
        (Handover(0, 2, 1.0), 2.0, Handover(2, 2, 1.0)),
        # Another change waits for the end of this one.
        (Handover(0, 2, 0.5), 1.0, Handover(0, 2, 0.75)),
        (Handover(0, 2, 1.0), 1.0, Handover(2, 1, 0.0)),
        # A choice of nobody changes nothing.
        *((Handover(1, 1, 1.0), odd, Handover(1, 1, 1.0)) for odd in (3.0, -1.0, 0.5)),
        (Handover(1, 1, 1.0), math.nan, Handover(1, 1, 1.0)),
        (Handover(1, 1, 1.0), math.inf, Handover(1, 1, 1.0)),
    ],
)
def test_handover_goes_on_as_worked_out_by_hand(last, choice, after):
    assert next_handover(last, choice, count=3, step=0.25) == after


@given(before=FINITE, now=FINITE, weight=st.floats(0, 1))
def test_what_is_faded_is_never_outside_of_the_two(before, now, weight):
    value = faded(before, now, weight)
    slack = 1e-15 * max(abs(before), abs(now))
    assert min(before, now) - slack <= value <= max(before, now) + slack
    assert faded(before, now, 0.0) == before
    assert faded(now, now, weight) == now


def test_change_that_takes_no_time_is_refused():
    with pytest.raises(ParameterError, match=r"^duration: "):
        ControllerSelector(2, Transition(duration=0.0), 0.01)


# --- Side by side --------------------------------------------------------------------

PARTS = ("base_command", "base_contribution", "arm_command")
AT = {
    "ee_command": [0.3, -0.2, 0.1],
    "ee_cylindrical": [1.58, -0.66, 0.0],
    "base_command_smoothed": [0.1, 0.05],
    "base_estimate": [0.1, 0.01, 0.05],
}


@pytest.fixture
def kwon():
    """A scenario with all alternatives, its decomposers, and inputs to them."""
    scenario = live_scenario(load_scenario("kwon_arbitrary"))
    setup = scenario.setup()
    blocks = [build_decomposer(one, setup) for one in scenario.controllers]
    q = scenario.robot.arm().inverse(AT["ee_cylindrical"])
    return scenario, blocks, AT | {"arm_position": q}


def later(block, context, periods):
    """Returns a block's context some periods later: some decomposers have a state."""
    simulator = Simulator(block, context)
    simulator.AdvanceTo((periods - 0.5) * 0.01)
    return simulator.get_context()


def chosen(block, inputs, choice, periods, fed):
    """Returns a context of a choice some periods after one was chosen."""
    said = NOBODY._replace(choice=choice)
    return later(block, fed(block, operator_input=said, **inputs), periods)


def test_whoever_is_chosen_drives_as_if_alone(kwon, fed, outputs):
    scenario, blocks, inputs = kwon
    contexts = [later(block, fed(block, **inputs), 20) for block in blocks]
    every = [outputs(*pair) for pair in zip(blocks, contexts, strict=True)]
    choice = make_choice(blocks, Transition(duration=0.05), scenario.period)
    for i, alone in enumerate(every):
        context = chosen(choice, inputs, float(i), 20, fed)
        together = {p: choice.GetOutputPort(p).Eval(context) for p in alone}
        for name, value in alone.items():
            assert together[name].tobytes() == value.tobytes(), (i, name)
        # One that has no status has none to tell of.
        if "decomposer_status" not in alone:
            assert choice.GetOutputPort("decomposer_status").Eval(context) == [0.0]


def test_ports_are_those_of_a_decomposer_and_the_handover(kwon):
    scenario, blocks, _ = kwon
    choice = make_choice(blocks, Transition(), scenario.period)
    names = {choice.get_input_port(i).get_name() for i in range(6)}
    assert names == {"operator_input", "ee_command", "arm_position", *AT}
    assert choice.num_input_ports() == 6
    for name in (*PARTS, "decomposer_status", "handover"):
        assert choice.HasOutputPort(name)
    # What the base does may not depend on what it is sent, or there is a loop.
    for told in ("base_command_smoothed", "base_estimate"):
        sent = choice.GetInputPort(told).get_index()
        for name in ("base_command", "base_contribution"):
            out = choice.GetOutputPort(name).get_index()
            assert not choice.HasDirectFeedthrough(sent, out)


def test_parts_sum_to_the_command_while_one_law_of_shares_follows_another(kwon, fed):
    scenario, blocks, inputs = kwon
    shares = choice_names(scenario).index("switching")
    choice = make_choice(blocks, Transition(duration=0.2), scenario.period)
    for periods in range(1, 25):
        context = chosen(choice, inputs, float(shares), periods, fed)
        share, arm = (choice.GetOutputPort(p).Eval(context) for p in PARTS[1:])
        total = [*(share + arm[:2]), arm[2]]
        np.testing.assert_allclose(total, inputs["ee_command"], atol=ROUNDING)


# --- While driving -------------------------------------------------------------------

HOLD = 150
"""Periods for which each drives [10 ms]."""


def driven(change, order, command=(0.2, 0.1, 0.0), start=()):
    """Returns the log of a held command while one after another is chosen."""
    scenario = live_scenario(load_scenario("kwon_arbitrary", list(start)))
    scenario.transition = change
    order = [choice_names(scenario).index(name) for name in order]
    diagram = make_teleop_diagram(scenario)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    port = diagram.GetInputPort("operator_input")
    for k in range(HOLD * len(order)):
        said = OperatorSample(age=0.0, choice=float(order[k // HOLD]))
        if k >= 2:
            said = OperatorSample(*command, 1.0, 0.0, 0.0, float(order[k // HOLD]))
        port.FixValue(context, np.array(said))
        simulator.AdvanceTo((k + 1) * scenario.period)
    return read_log(diagram, context)


EACH = ("blending", "field, projected", "exact", "blending", "exact")
NEAR_LIMIT = ("start.l=1.5",)


def steps(log):
    """Returns the largest changes of base and arm in a period, from the change on."""
    moving = slice(HOLD - 20, None)
    return [np.abs(np.diff(log[name][moving], axis=0)).max() for name in PARTS[::2]]


def test_change_makes_no_jump_of_base_or_arm():
    smooth = steps(driven(Transition(duration=0.5), EACH, start=NEAR_LIMIT))
    sudden = steps(driven(Transition(duration=1e-6), EACH, start=NEAR_LIMIT))
    # A fade's steepest is 1.5 times its mean: 3 % of the difference in a period.
    for few, many in zip(smooth, sudden, strict=True):
        assert many > 0.1
        assert few < 0.02


def test_every_one_of_them_drives_in_turn():
    log = driven(Transition(), EACH, start=NEAR_LIMIT)
    _, now, weight = log["handover"].T
    scenario = live_scenario(load_scenario("kwon_arbitrary"))
    names = [choice_names(scenario)[int(i)] for i in now[HOLD - 1 :: HOLD]]
    assert tuple(names) == EACH
    assert (weight[HOLD - 1 :: HOLD] == 1).all()
    assert not log["gate_status"][3:].any()
