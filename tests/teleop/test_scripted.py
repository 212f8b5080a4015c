"""An operator's command by script: held, or led smoothly to a new value."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator

from drake_mobman.parameters import ParameterError
from drake_mobman.teleop.scripted import (
    Held,
    Script,
    ScriptedSource,
    Smooth,
    script_trajectory,
)

ROUNDING = 1e-15
"""Of a cubic with values of up to 0.4."""

VALUES = {key: st.floats(-0.4, 0.4) for key in ("v_c", "omega_c", "v_z")}
HELD = st.builds(Held, duration=st.floats(0.01, 5.0), **VALUES)
SMOOTH = st.builds(Smooth, duration=st.floats(0.01, 5.0), **VALUES)
SCRIPTS = st.builds(
    Script,
    segments=st.lists(st.one_of(HELD, SMOOTH), min_size=1, max_size=6),
    repeat=st.integers(1, 3),
)


def commanded(script, times):
    """Returns the source's commands at `times`."""
    source = ScriptedSource(script)
    context = source.CreateDefaultContext()
    found = []
    for time in times:
        context.SetTime(time)
        found.append(source.GetOutputPort("ee_command").Eval(context))
    return np.array(found)


def target(segment):
    return [segment.v_c, segment.omega_c, segment.v_z]


def borders(script):
    """Returns where each segment starts, and where the last one ends."""
    times = [0.0]
    for segment in script.segments * script.repeat:
        times.append(times[-1] + segment.duration)
    return times


def test_held_commands_are_held():
    script = Script([Held(1.0), Held(2.0, 0.3, -0.2, 0.1), Held(0.5, -0.4)])
    found = commanded(script, [0.0, 0.5, 1.5, 2.9, 3.2])
    expected = [
        [0, 0, 0],
        [0, 0, 0],
        [0.3, -0.2, 0.1],
        [0.3, -0.2, 0.1],
        [-0.4, 0, 0],
    ]
    np.testing.assert_array_equal(found, expected)


def test_at_a_border_the_later_segment_counts():
    script = Script([Held(1.0, 0.1), Held(2.0, 0.2), Smooth(1.0, 0.4), Held(1.0, 0.3)])
    before = [math.nextafter(t, 0.0) for t in (1.0, 3.0, 4.0, 5.0)]
    assert commanded(script, [0.0, 1.0, 3.0, 4.0, 5.0])[:, 0] == pytest.approx(
        [0.1, 0.2, 0.2, 0.3, 0.0], abs=ROUNDING
    )
    # Within the width of a float before it, the earlier one.
    assert commanded(script, before)[:, 0] == pytest.approx(
        [0.1, 0.2, 0.4, 0.3], abs=ROUNDING
    )


def test_smooth_commands_are_as_worked_out_by_hand():
    # From a to b with s = t / T: a + (b - a) (3 s^2 - 2 s^3): at s = 1/4 it is 5/32 of
    # the way, at 1/2 a half, at 3/4 27/32.
    script = Script([Held(1.0, 0.1, 0.0, -0.2), Smooth(2.0, 0.42, -0.32, -0.2)])
    found = commanded(script, [1.0, 1.5, 2.0, 2.5, math.nextafter(3.0, 0.0)])
    expected = [
        [0.10, 0.00, -0.2],
        [0.15, -0.05, -0.2],
        [0.26, -0.16, -0.2],
        [0.37, -0.27, -0.2],
        [0.42, -0.32, -0.2],
    ]
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def test_a_smooth_start_is_from_rest():
    found = commanded(Script([Smooth(2.0, 0.4)]), [0.0, 1.0])
    np.testing.assert_allclose(found[:, 0], [0.0, 0.2], atol=ROUNDING)


@given(script=SCRIPTS)
def test_smooth_segments_join_on_to_the_one_before(script):
    times = borders(script)
    before = [0.0, 0.0, 0.0]
    segments = script.segments * script.repeat
    for segment, time in zip(segments, times[:-1], strict=True):
        if isinstance(segment, Smooth):
            found = commanded(script, [time])[0]
            np.testing.assert_allclose(found, before, rtol=0, atol=ROUNDING)
        before = target(segment)


@given(script=SCRIPTS)
def test_each_segment_ends_at_its_values(script):
    times = borders(script)
    segments = script.segments * script.repeat
    for segment, end in zip(segments, times[1:], strict=True):
        found = commanded(script, [end - 1e-9])[0]
        # The last 1e-9 s of a cubic without slope: 3 (1e-9 / 0.01)^2 = 3e-14.
        np.testing.assert_allclose(found, target(segment), rtol=0, atol=1e-13)


@given(smooth=st.lists(SMOOTH, min_size=1, max_size=5))
def test_smooth_commands_have_no_kink_and_the_slope_they_say(smooth):
    trajectory = script_trajectory(Script(smooth))
    start = [0.0, 0.0, 0.0]
    times = borders(Script(smooth))
    for segment, begin, end in zip(smooth, times[:-1], times[1:], strict=True):
        change = np.subtract(target(segment), start)
        # 1.5 times the change over the duration, in the middle; none at the ends.
        middle = trajectory.EvalDerivative((begin + end) / 2, 1).ravel()
        steepest = 1.5 * change / segment.duration
        np.testing.assert_allclose(middle, steepest, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(
            trajectory.EvalDerivative(begin, 1).ravel(), 0.0, atol=1e-9
        )
        start = target(segment)


@given(script=SCRIPTS, later=st.floats(0.0, 1e3))
def test_after_the_end_there_is_rest(script, later):
    end = borders(script)[-1]
    assert (commanded(script, [end + later]) == 0).all()


@pytest.mark.parametrize("segments", [[], [Held(0.5)]])
def test_a_script_without_commands_is_rest(segments):
    assert (commanded(Script(segments), [0.0, 0.5, 2.0]) == 0).all()


def test_repeated_segments_go_on_where_they_ended():
    script = Script([Smooth(1.0, 0.4), Held(1.0, 0.2)], repeat=3)
    found = commanded(script, [0.5, 1.5, 2.0, 2.5, 3.5, 4.5, 5.5, 6.0])[:, 0]
    # The first from rest, the others from 0.2.
    expected = [0.2, 0.2, 0.2, 0.3, 0.2, 0.3, 0.2, 0.0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def test_a_repeated_script_is_the_script_written_out():
    segments = [Held(0.3, 0.1), Smooth(0.7, -0.2, 0.3), Held(0.1, 0.0, 0.1, -0.1)]
    times = np.linspace(0.0, 4.0, 401)
    found = commanded(Script(segments, repeat=3), times)
    np.testing.assert_array_equal(found, commanded(Script(segments * 3), times))


def test_simulated_it_puts_out_the_scripts_commands():
    source = ScriptedSource(Script([Held(1.0), Held(2.0, 0.3)]))
    simulator = Simulator(source)
    for time, v_c in ((0.5, 0.0), (1.5, 0.3), (3.5, 0.0)):
        simulator.AdvanceTo(time)
        found = source.GetOutputPort("ee_command").Eval(simulator.get_context())
        assert list(found) == [v_c, 0, 0]


def test_ports_are_those_of_the_contract():
    source = ScriptedSource(Script())
    assert source.num_input_ports() == 0
    assert source.num_output_ports() == 1
    assert source.GetOutputPort("ee_command").size() == 3


@pytest.mark.parametrize("kind", [Held, Smooth])
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("duration", 0.0),
        ("duration", -1.0),
        ("duration", math.inf),
        ("v_c", math.nan),
        ("omega_c", math.inf),
        ("v_z", -math.inf),
    ],
)
def test_bad_segments_are_refused_by_name(kind, key, value):
    script = Script([Held(1.0), kind(**{key: value})])
    with pytest.raises(ParameterError) as error:
        ScriptedSource(script)
    assert error.value.key == f"segments[1].{key}"


@pytest.mark.parametrize("repeat", [0, -1])
def test_a_script_never_gone_through_is_refused(repeat):
    with pytest.raises(
        ParameterError, match=r"^repeat: .* must be within \[1, 100000\]"
    ):
        ScriptedSource(Script([Held()], repeat=repeat))


def test_a_segment_too_short_for_the_clock_is_refused_by_name():
    with pytest.raises(ParameterError, match=r"^segments\[1\].duration: "):
        ScriptedSource(Script([Held(1.0), Held(1e-17)]))
