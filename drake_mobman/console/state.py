"""The state of a session as it is sent to pages, many times a second."""

import math
from typing import Any

from drake_mobman import signals
from drake_mobman.console.snapshot import Snapshot
from drake_mobman.decomposers.arm_compensation import base_induced_rates
from drake_mobman.terminal import visible


def state(snapshot: Snapshot, p_BS: Any) -> dict[str, Any]:
    """Returns a snapshot as a page shows it; numbers that are not finite become None.

    Args:
        snapshot: of a session.
        p_BS: shoulder in B (3,) [m].
    """
    values: dict[str, Any] = {
        "time": snapshot.time,
        "text": snapshot.text,
        "problem": snapshot.problem,
        "arming": int(snapshot.arming),
        "choice": snapshot.choice,
        "ratio": snapshot.real_time_factor,
        "recording": str(snapshot.recording or ""),
        "error": snapshot.tracking_error,
    }
    if signals.EE_CYLINDRICAL in snapshot.signals:
        values |= _motion(snapshot, p_BS)
    return {name: _as_json(value) for name, value in values.items()}


def _motion(snapshot: Snapshot, p_BS: Any) -> dict[str, float]:
    """Returns where the end effector is, and the speeds that base and arm give it.

    These are along the reach: the base carries the end effector, the arm adds l_dot.
    """
    get = snapshot.signals
    l, psi, z = get[signals.EE_CYLINDRICAL]
    v_b, omega_b = get[signals.BASE_COMMAND_SMOOTHED]
    base, _ = base_induced_rates((l, psi, z), v_b, omega_b, p_BS)
    if signals.ARM_COMMAND in get:
        arm = get[signals.ARM_COMMAND][0]
    else:
        theta = get[signals.BASE_POSE][2]
        x_dot, y_dot, _ = get[signals.TOOL_VELOCITY]
        arm = x_dot * math.cos(theta + psi) + y_dot * math.sin(theta + psi) - base
    return {
        "l": l,
        "psi": psi,
        "z": z,
        "v_b": v_b,
        "omega_b": omega_b,
        "base": base,
        "arm": arm,
    }


def _as_json(value: Any) -> Any:
    if isinstance(value, str):
        return visible(value)
    if not isinstance(value, float):
        return value
    return round(value, 5) if math.isfinite(value) else None
