"""A snapshot of a live session: what pages show of it."""

import dataclasses as dc
from pathlib import Path

from drake_mobman.teleop.gate import Arming, GateStatus

_REASON = {
    GateStatus.OK: "driving",
    GateStatus.NOT_FINITE: "stopped: command not finite",
    GateStatus.OVER_RANGE: "stopped: command out of range",
    GateStatus.NOT_ARMED: "not armed yet",
    GateStatus.RELEASED: "stopped: dead-man released",
    GateStatus.STALE: "stopped: no recent input",
    GateStatus.STOPPED: "stopped by {who}",
    GateStatus.GONE: "stopped: the operator left",
    GateStatus.ASTRAY: "stopped: the base does not move as it is told",
}

_NEXT_STEP = {
    Arming.LATCHED: "; release stick and dead-man",
    Arming.READY: "; hold the dead-man to drive",
    Arming.ARMED: "",
}


@dc.dataclass(frozen=True)
class Snapshot:
    """A session at one time; it never changes."""

    time: float = 0.0  # Simulated [s].
    # Every logged signal under its name; see `drake_mobman.signals`.
    signals: dict[str, tuple[float, ...]] = dc.field(default_factory=dict)
    tracking_error: float = 0.0  # See `drake_mobman.console.tracking_error`.
    status: GateStatus = GateStatus.NOT_ARMED
    arming: Arming = Arming.LATCHED
    text: str = ""  # Status, reason and next step, in one line.
    choice: str = ""  # The controller that drives, or is about to.
    real_time_factor: float = 1.0  # Simulated over wall time, of the last second.
    recording: Path | None = None  # Folder, while it is written to.
    problem: str = ""  # What went wrong with the recording, in one line.
    died: str = ""  # When and why the simulation ended, in one line.


def status_text(status: GateStatus, arming: Arming, who: str) -> str:
    """Returns what the gate does, why, and what the operator can do, in one line.

    Args:
        status: of the gate.
        arming: of the gate.
        who: by whom the robot was last stopped.
    """
    return _REASON[status].format(who=who) + _NEXT_STEP[arming]
