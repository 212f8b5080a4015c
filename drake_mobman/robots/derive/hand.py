"""How a person's hand pulls a tool, by how heavy the tool feels."""

from typing import Any

import numpy as np

from drake_mobman.arm.chain import chain_of
from drake_mobman.guidance.guiding_hand import Hand, Waypoint
from drake_mobman.robot_model.model import BASE_JOINTS
from drake_mobman.robots.derive.derived import Derived
from drake_mobman.robots.servo import Servo
from drake_mobman.scalars import Matrix

_DAMPED, _STIFF = 0.8, 0.25
"""Largest c h / m and k h^2 / m of a hand of stiffness k and damping c that pulls m.

With a force that is constant for a period h, hand and tool oscillate ever more where
the first and half the second make 2. A tool is half as heavy in other postures."""

_PERIOD = 0.01
"""For which the hand's force is constant [s]: a scenario's, by default."""


def hand(plant: Any, posture: Matrix, p_BE: Matrix) -> Derived[Hand]:
    """Returns a hand that holds the tool at the posture.

    Its stiffness and damping are less for a tool that is light to pull, which a stiff
    hand would shake.

    Args:
        plant: finalized, of the robot.
        posture: joint positions (n,) [rad], [m].
        p_BE: of the tool at the posture (3,) [m].
    """
    mass = apparent_mass(plant, posture)
    stiffness, damping = softness(mass)
    x, y, z = map(float, p_BE)
    found = Hand(
        stiffness=round(stiffness, 3),
        damping=round(damping, 3),
        path=[Waypoint(x=x, y=y, z=z)],
    )
    return Derived(found, f"the tool feels like {mass:.2f} kg or more")


def softness(mass: float) -> tuple[float, float]:
    """Returns stiffness [N/m] and damping [N s/m] for a tool that feels like `mass`."""
    usual = Hand()
    stiffness = min(_STIFF * mass / _PERIOD**2, usual.stiffness)
    return stiffness, min(_DAMPED * mass / _PERIOD, usual.damping)


def apparent_mass(plant: Any, q: Matrix) -> float:
    """Returns the least mass [kg] that E has when pulled in any direction.

    What a force that is constant for a period h moves in that time, over h: without
    damping, the largest eigenvalue of J M^-1 J^T is the inverse of this mass (Khatib,
    1987). Damping d of the joints slows the tool as inertia does: in place of M there
    is d h / (1 - exp(-d h M^-1)). So a light arm with stiff joints is not that light.
    The base rests.

    Args:
        plant: finalized, of the robot.
        q: joint positions (n,) [rad], [m].
    """
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.append(np.zeros(BASE_JOINTS), q))
    M = plant.CalcMassMatrix(context)[BASE_JOINTS:, BASE_JOINTS:]
    inertia, axes = np.linalg.eigh(M)
    slowed = _PERIOD * Servo().joint_damping
    moved = axes @ np.diag(-np.expm1(-slowed / inertia) / slowed) @ axes.T
    chain = chain_of(plant)
    J: Matrix = np.array(chain.J_V_BE(chain.at(q.tolist())))[3:]
    return float(1.0 / np.linalg.eigvalsh(J @ moved @ J.T)[-1])
