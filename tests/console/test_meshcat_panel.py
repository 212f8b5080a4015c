"""Meshcat's own panel as an input device."""

from drake_mobman.console.meshcat_panel import FIRST_HOLD, REPEAT_HOLD, KeyHold


def test_key_is_held_while_it_is_repeated(clock):
    key = KeyHold(clock)
    assert not key.is_held(0)
    assert key.is_held(1)
    clock.now += FIRST_HOLD - 0.01  # The first repetition takes long.
    assert key.is_held(1)
    clock.now += 0.005
    assert key.is_held(2)
    clock.now += REPEAT_HOLD - 0.01
    assert key.is_held(3)
    clock.now += REPEAT_HOLD + 0.01
    assert not key.is_held(3)
    assert key.is_held(4)
    clock.now += FIRST_HOLD + 0.01
    assert not key.is_held(4)
