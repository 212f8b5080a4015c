"""The state that pages receive."""

import json

from drake_mobman.console.snapshot import Snapshot, status_text
from drake_mobman.console.state import state
from drake_mobman.teleop.gate import Arming, GateStatus


def test_state_is_json_whatever_the_robot_does():
    snapshot = Snapshot(
        time=1.25,
        signals={
            "ee_cylindrical": (1.0, 0.0, float("nan")),
            "base_command_smoothed": (0.2, 0.1),
            "arm_command": (0.1, 0.0, 0.0),
        },
        tracking_error=float("inf"),
    )
    shown = json.loads(json.dumps(state(snapshot, (0.1, 0.3, 0.5)), allow_nan=False))
    assert shown["z"] is None
    assert shown["error"] is None
    assert (shown["base"], shown["arm"]) == (0.17, 0.1)  # 0.2 - 0.1 x 0.3 m/s.
    json.dumps(state(Snapshot(), (0.1, 0.3, 0.5)), allow_nan=False)


def test_every_status_of_the_gate_has_a_text_of_its_own():
    pairs = [(status, arming) for status in GateStatus for arming in Arming]
    texts = {status_text(*pair, who="a viewer") for pair in pairs}
    assert len(texts) == len(pairs)
    assert all(text.isprintable() and "{" not in text for text in texts)
