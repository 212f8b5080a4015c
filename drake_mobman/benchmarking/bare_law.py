"""A decomposer's law as a plain function of numbers."""

from collections.abc import Callable
from typing import Any

from drake_mobman.decomposers.arm_compensation import arm_compensation
from drake_mobman.decomposers.blending import BlendingDecomposer, blending_shares
from drake_mobman.decomposers.exact import (
    ExactDecomposer,
    exact_arm,
    exact_base,
    exact_base_command,
)
from drake_mobman.decomposers.field import FieldDecomposer, field_base
from drake_mobman.decomposers.share import base_speed
from drake_mobman.decomposers.switching import SwitchingDecomposer, switching_shares


def bare_law(block: Any) -> Callable[..., Any] | None:
    """Returns a decomposer's law as a function of its four inputs, if it has one.

    The function returns `base_command` and `arm_command` (5,).
    """
    # One of its own first: a new decomposer needs no line here.
    if hasattr(block, "law"):
        return block.law
    if isinstance(block, BlendingDecomposer):
        return _by_shares(block, blending_shares)
    if isinstance(block, SwitchingDecomposer):
        return _by_shares(block, switching_shares)
    if isinstance(block, FieldDecomposer):
        return _by_field(block)
    if isinstance(block, ExactDecomposer):
        return _exact(block)
    return None


def _by_shares(block: Any, shares: Callable[..., Any]) -> Callable[..., Any]:
    params, limits, projection = block.params, block.workspace, block.projection

    def law(command: Any, at: Any, _q: Any, _smoothed: Any) -> Any:
        mu, nu = shares(params, limits, command, at)
        v_c, omega_c, v_z = command
        v_bm, omega_b = mu * v_c, nu * omega_c
        v_b = base_speed(v_bm, at[1], projection)
        return v_b, omega_b, v_c - v_bm, omega_c - omega_b, v_z

    return law


def _by_field(block: Any) -> Callable[..., Any]:
    params, reach, arm = block.params, block.reach, block.arm

    def law(command: Any, at: Any, q: Any, smoothed: Any) -> Any:
        base = field_base(q, params, reach, arm, block.limiter)[:2]
        return *base, *arm_compensation(command, at, smoothed, arm.p_BS)

    return law


def _exact(block: Any) -> Callable[..., Any]:
    params, limits, limiter = block.params, block.limits, block.limiter

    def law(command: Any, at: Any, q: Any, smoothed: Any) -> Any:
        inputs = command, at, q
        course = exact_base_command(*inputs, params, limits, limiter)
        return *course.base, *exact_arm(*inputs, smoothed, course, limiter)[0]

    return law


def without_limits(block: ExactDecomposer) -> Callable[..., Any]:
    """Returns the exact law as it is without limits of joints and base."""
    params, limits, p_BS = block.params, block.limits, block.limiter.arm.p_BS

    def law(command: Any, at: Any, _q: Any, smoothed: Any) -> Any:
        base = exact_base(command, at, params, limits, p_BS)
        return *base, *arm_compensation(command, at, smoothed, p_BS)

    return law
