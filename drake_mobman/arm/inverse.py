"""The ports that every inverse of an arm has, so that one swaps for another."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import ValueProducer

from drake_mobman import signals
from drake_mobman.scalars import Scalar


def declare_inverse_ports(
    block: Any, joints: int, invert: Callable[[Any], tuple[list[Scalar], Scalar]]
) -> None:
    """Declares an inverse's ports; both outputs come of one evaluation.

    Args:
        block: gets `command` and `position`, its inputs, and `inverted`, a cache entry.
        joints: of the arm, n.
        invert: returns the joint rates (n,) [rad/s] and the `ArmStatus` flags of what
            bounds them, from the block's context.
    """
    block.command = block.DeclareVectorInputPort(signals.ARM_COMMAND, 3)
    block.position = block.DeclareVectorInputPort(signals.ARM_POSITION, joints)
    block.inverted = block.DeclareCacheEntry(
        "rates and status",
        ValueProducer(
            allocate=lambda: AbstractValue.Make(()),
            calc=lambda context, value: value.set_value(invert(context)),
        ),
        {block.all_input_ports_ticket(), block.xd_ticket()},
    )

    def calc_rates(context: Any, output: Any) -> None:
        output.SetFromVector(np.array(block.inverted.Eval(context)[0]))

    def calc_status(context: Any, output: Any) -> None:
        output.SetFromVector(np.array([block.inverted.Eval(context)[1]]))

    needs = {block.inverted.ticket()}
    rates, status = signals.ARM_VELOCITY_COMMAND, signals.ARM_STATUS
    block.DeclareVectorOutputPort(
        rates, joints, calc_rates, prerequisites_of_calc=needs
    )
    block.DeclareVectorOutputPort(status, 1, calc_status, prerequisites_of_calc=needs)
