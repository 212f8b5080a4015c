"""A random operator commands the same for the same seed, within its bounds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_mobman.parameters import ParameterError, checked
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate
from drake_mobman.teleop.random_held import RandomHeld

SEEDS = st.integers(0, 999_999_999)


@given(seed=SEEDS, rest=st.floats(0, 1), length=st.floats(0.5, 100))
@settings(max_examples=50)
def test_commands_are_held_within_their_bounds_until_the_end(seed, rest, length):
    params = RandomHeld(seed, length, 0.3, 2.0, 0.2, 0.1, 0.05, rest)
    segments = params.script().segments
    durations = [x.duration for x in segments]
    assert sum(durations) == pytest.approx(length, abs=2e-6)
    assert all(0.3 <= x <= 2.0 for x in durations[:-1])
    for held in segments:
        assert abs(held.v_c) <= 0.2
        assert abs(held.omega_c) <= 0.1
        assert abs(held.v_z) <= 0.05


def test_the_same_seed_draws_the_same_and_another_does_not():
    drawn = [RandomHeld(seed).script().segments for seed in (3, 3, 4)]
    assert drawn[0] == drawn[1] != drawn[2]


def test_a_seed_means_the_same_in_every_version():
    """Worked out apart: PCG64 is specified to the bit."""
    first = RandomHeld(1, rest=0.0).script().segments[0]
    assert first.duration == pytest.approx(0.5 + 3.5 * 0.5118216247002567, abs=1e-15)
    assert first.v_c == pytest.approx(0.4 * (2 * 0.14415961271963373 - 1), abs=1e-15)


def test_over_many_commands_the_share_at_rest_and_the_means_are_as_given():
    segments = RandomHeld(5, length=20_000.0, rest=0.3).script().segments
    v_c = np.array([x.v_c for x in segments])
    assert np.mean(v_c == 0) == pytest.approx(0.3, abs=0.02)
    assert abs(np.mean(v_c)) < 0.02
    assert np.max(np.abs(v_c)) > 0.39


def test_a_run_is_commanded_by_it():
    scenario = load_scenario("kwon_1", ["source=!RandomHeld {seed: 2}", "duration=5.0"])
    run = simulate(scenario)
    assert not run.died
    assert len(np.unique(run["source.ee_command"][:, 0])) > 1


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"seed": -1}, "seed"),
        ({"hold_min": 3.0, "hold_max": 2.0}, "hold_min"),
        ({"rest": 1.5}, "rest"),
        ({"max_v_c": -0.1}, "max_v_c"),
    ],
)
def test_values_out_of_range_are_refused(values, key):
    with pytest.raises(ParameterError, match=key):
        checked(RandomHeld(**values))
