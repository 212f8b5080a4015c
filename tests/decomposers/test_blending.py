"""Authority blended about the workspace's limits (Kwon et al., eqs. 14-16)."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drake_mobman.decomposers.blending import Blending, BlendingDecomposer
from drake_mobman.decomposers.projection import Projection
from drake_mobman.decomposers.share import blended_share
from drake_mobman.decomposers.switching import Switching
from drake_mobman.parameters import ParameterError
from drake_mobman.robot_model import WorkspaceLimits
from drake_mobman.scenario import load_scenario
from drake_mobman.simulation.simulate import simulate

ROUNDING = 4e-16
"""A few operations on numbers of at most about 1, each off by 1.1e-16."""

L_MIN, L_MAX, PSI_MIN, PSI_MAX = 0.4, 1.6, -0.7, 0.7
ALPHA = 21.0

ALONE = {
    "arm_position": [0.0, 0.0],
    "base_command_smoothed": [0.0, 0.0],
    "base_estimate": [0.0, 0.0, 0.0],
}
"""Inputs that a law of shares does not look at."""

TABLE_2 = ["kwon_1", "kwon_2", "kwon_3", "kwon_4"]

SPEED = st.floats(-0.4, 0.4)
REACH = st.floats(0.0, 2.0)
ANGLE = st.floats(-3.2, 3.2)


@pytest.mark.parametrize(
    ("command", "x", "mu"),
    [
        # About 1.6, 0.5 tanh(21 d) + 0.5 = 1 / (1 + exp(-42 d)), d = x - 1.6.
        (0.3, 1.6, 0.5),
        (0.3, 1.6 + math.log(3) / 42, 0.75),
        (0.3, 1.6 - math.log(3) / 42, 0.25),
        (0.3, 1.6 + math.log(99) / 42, 0.99),
        (0.0, 1.6 + math.log(3) / 42, 0.75),  # A command of 0 counts as outward.
        # About 0.4, mirrored: 1 / (1 + exp(42 d)), d = x - 0.4.
        (-0.3, 0.4, 0.5),
        (-0.3, 0.4 + math.log(3) / 42, 0.25),
        (-0.3, 0.4 - math.log(3) / 42, 0.75),
        (-0.3, 0.4 - math.log(99) / 42, 0.99),
    ],
)
def test_share_is_as_worked_out_by_hand(command, x, mu):
    # 42 times the rounding of x, times the slope of at most 1/4.
    share = blended_share(command, x, L_MIN, L_MAX, ALPHA)
    assert share == pytest.approx(mu, abs=42 * ROUNDING)


@pytest.mark.parametrize(
    ("command", "psi", "shares"),
    [
        # A quarter of it to the base, three quarters to the arm, at each limit.
        ((0.4, 0.0, 0.0), (L_MAX - math.log(3) / 42, 0.0), (0.1, 0.0)),
        ((-0.4, 0.0, 0.0), (L_MIN + math.log(3) / 42, 0.0), (-0.1, 0.0)),
        ((0.0, 0.4, 0.0), (1.0, PSI_MAX - math.log(3) / 42), (0.0, 0.1)),
        ((0.0, -0.4, 0.0), (1.0, PSI_MIN + math.log(3) / 42), (0.0, -0.1)),
    ],
)
def test_block_splits_each_component_at_its_own_limits(
    fed, outputs, command, psi, shares
):
    block = BlendingDecomposer(Blending())
    context = fed(block, **ALONE, ee_command=command, ee_cylindrical=[*psi, 0])
    sent = outputs(block, context)
    np.testing.assert_allclose(sent["base_contribution"], shares, atol=42 * ROUNDING)
    rest = np.subtract(command[:2], shares)
    np.testing.assert_allclose(sent["arm_command"][:2], rest, atol=42 * ROUNDING)


def test_l_and_psi_have_a_sharpness_each():
    # 0.01 past the limit: 1 / (1 + exp(-2 alpha 0.01)).
    mu, nu = Blending(alpha=10.0, beta=40.0).shares(
        WorkspaceLimits(), (0.1, 0.1, 0), (1.61, 0.71, 0)
    )
    assert mu == pytest.approx(1 / (1 + math.exp(-0.2)), abs=80 * ROUNDING)
    assert nu == pytest.approx(1 / (1 + math.exp(-0.8)), abs=80 * ROUNDING)


@pytest.mark.parametrize(
    ("sigma", "v_b"),
    [
        # Half of 0.4 at L_max; at psi of 0.6 rad v_b = kappa 0.2 / 0.825336 with
        # kappa = 1 - exp(-(pi/2 - 0.6)^2 / sigma^2) and (pi/2 - 0.6)^2 = 0.942446.
        (0.5, 0.236738),  # 1 - exp(-3.769782) = 0.976943.
        (1.0, 0.147898),  # 1 - exp(-0.942446) = 0.610326.
    ],
)
def test_base_gets_the_speed_whose_projection_is_its_share(fed, outputs, sigma, v_b):
    block = BlendingDecomposer(Blending(projection=Projection(sigma)))
    context = fed(block, **ALONE, ee_command=[0.4, 0, 0], ee_cylindrical=[1.6, 0.6, 0])
    sent = outputs(block, context)
    assert sent["base_contribution"][0] == pytest.approx(0.2, abs=42 * ROUNDING)
    # The numbers above have six digits.
    assert sent["base_command"][0] == pytest.approx(v_b, abs=1e-6)


def algorithm_1(vc, wc, x_eff, y_eff):
    """Lines 11-29 as they are printed, with `x_eff` the reach and `y_eff` psi."""
    if vc >= 0:
        v_mu = 0.5 * math.tanh((x_eff - 1.6) * 21) + 0.5
    else:
        v_mu = 1.0 - (0.5 * math.tanh((x_eff - 0.4) * 21) + 0.5)
    if wc >= 0:
        w_mu = 0.5 * math.tanh((y_eff - 0.7) * 21) + 0.5
    else:
        w_mu = 1.0 - (0.5 * math.tanh((y_eff + 0.7) * 21) + 0.5)
    v_base = vc * v_mu
    w_base = wc * w_mu
    v_manipulator = vc * (1 - v_mu)
    w_manipulator = wc * (1 - w_mu)
    return v_base, w_base, v_manipulator, w_manipulator


@given(v_c=SPEED, omega_c=SPEED, l=REACH, psi=ANGLE)
def test_it_agrees_with_algorithm_1(fed, outputs, v_c, omega_c, l, psi):
    block = BlendingDecomposer(Blending())
    context = fed(
        block, **ALONE, ee_command=[v_c, omega_c, 0], ee_cylindrical=[l, psi, 0]
    )
    sent = outputs(block, context)
    parts = [*sent["base_contribution"], *sent["arm_command"][:2]]
    expected = algorithm_1(v_c, omega_c, l, psi)
    np.testing.assert_allclose(parts, expected, rtol=0, atol=ROUNDING)


@given(
    v_c=SPEED,
    omega_c=SPEED,
    l=REACH,
    psi=ANGLE,
    alpha=st.floats(0.1, 1e6),
    beta=st.floats(0.1, 1e6),
)
def test_shares_are_from_0_to_1(v_c, omega_c, l, psi, alpha, beta):
    shares = Blending(alpha, beta).shares(
        WorkspaceLimits(), (v_c, omega_c, 0.0), (l, psi, 0.0)
    )
    assert all(0 <= share <= 1 for share in shares)


@given(command=st.sampled_from([-0.3, 0.3]), x=REACH, further=st.floats(0.0, 1.0))
def test_share_grows_on_the_way_out(command, x, further):
    out = x + further * math.copysign(1.0, command)
    here = blended_share(command, x, L_MIN, L_MAX, ALPHA)
    assert blended_share(command, out, L_MIN, L_MAX, ALPHA) >= here


@given(v_c=SPEED, omega_c=SPEED, v_z=SPEED, l=REACH, psi=ANGLE)
def test_base_and_arm_sum_to_the_command(fed, outputs, v_c, omega_c, v_z, l, psi):
    block = BlendingDecomposer(Blending())
    command = [v_c, omega_c, v_z]
    sent = outputs(
        block, fed(block, **ALONE, ee_command=command, ee_cylindrical=[l, psi, 0])
    )
    v_bm, omega_b = sent["base_contribution"]
    v_m, omega_m, arm_v_z = sent["arm_command"]
    # One subtraction and one sum, each off by half a unit of 0.4.
    assert v_bm + v_m == pytest.approx(v_c, abs=6e-17)
    assert omega_b + omega_m == pytest.approx(omega_c, abs=6e-17)
    assert arm_v_z == v_z


@pytest.mark.parametrize(
    ("index", "command", "start", "limit"),
    [
        (0, -0.35, L_MAX + 0.2, L_MAX),
        (0, 0.35, L_MIN - 0.35, L_MIN),
        (1, -0.35, PSI_MAX + 0.15, PSI_MAX),
        (1, 0.35, PSI_MIN - 0.15, PSI_MIN),
    ],
)
@pytest.mark.parametrize("params", [Blending(), Switching()])
def test_arm_turns_back_from_outside_each_limit(params, index, command, start, limit):
    """Held for a second, the command is the arm's alone, and it crosses the limit."""
    x = [1.0, 0.0, 0.0]
    x[index] = start
    held = [0.0, 0.0, 0.0]
    held[index] = command
    for _ in range(100):
        share = params.shares(WorkspaceLimits(), held, x)[index]
        x[index] += 0.01 * (1 - share) * command
    # The other limit is 0.5 or more away: exp(-42 x 0.5) = 8e-10 of the command.
    assert x[index] == pytest.approx(start + command, abs=1e-8)
    assert (start - limit) * (x[index] - limit) < 0


def test_pushed_outward_the_arm_creeps_past_its_limit():
    # x = l - L_max obeys (1 + exp(42 x)) x' = v_c: x + exp(42 x) / 42 = v_c t - 1.6
    # from l = 0. After 14 s of 0.35 m/s that is 3.3, and x = ln(42 (3.3 - x)) / 42 =
    # 0.11656, which is the paper's l = 1.717 m.
    l, h, v_c = 0.0, 0.01, 0.35
    for _ in range(1400):
        l += h * v_c * (1 - blended_share(v_c, l, L_MIN, L_MAX, ALPHA))
    # An Euler step at the limit is off by up to 42 / 4 (v_c h)^2 = 1.3e-4.
    assert l == pytest.approx(1.6 + 0.11656, abs=1.3e-4)


def off_limits(command, x, lower, upper):
    """Returns how far `x` is from the limit that counts for `command`."""
    return abs(x - (upper if command >= 0 else lower))


@given(v_c=SPEED, omega_c=SPEED, l=REACH, psi=ANGLE, alpha=st.floats(1.0, 1e5))
def test_it_tends_to_switching_as_it_sharpens(v_c, omega_c, l, psi, alpha):
    command, workspace = (v_c, omega_c, 0.0), (l, psi, 0.0)
    blended = Blending(alpha, alpha).shares(WorkspaceLimits(), command, workspace)
    switched = Switching().shares(WorkspaceLimits(), command, workspace)
    away = (
        off_limits(v_c, l, L_MIN, L_MAX),
        off_limits(omega_c, psi, PSI_MIN, PSI_MAX),
    )
    for share, step, x in zip(blended, switched, away, strict=True):
        assume(x > 0)
        # 0.5 (1 - tanh(y)) = 1 / (1 + exp(2 y)) < exp(-2 y).
        assert abs(share - step) <= math.exp(-2 * alpha * x) + ROUNDING


@pytest.mark.parametrize("key", ["alpha", "beta"])
@pytest.mark.parametrize("value", [0.0, -21.0, math.nan, math.inf])
def test_a_transition_of_no_width_is_refused(key, value):
    with pytest.raises(ParameterError, match=f"^{key}: "):
        BlendingDecomposer(Blending(**{key: value}))


# Errata: what the paper prints, run, and what comes of it.


def swapped_shares(params, limits, command, workspace):
    """Eq. 16 as printed: v_bm = (1 - mu) v_c, v_m = mu v_c, and so in omega."""
    mu, nu = params.shares(limits, command, workspace)
    return 1 - mu, 1 - nu


@dc.dataclass
class Swapped:
    own: Blending

    @property
    def projection(self):
        return self.own.projection

    def shares(self, *at):
        return swapped_shares(self.own, *at)


@pytest.mark.parametrize("name", TABLE_2)
def test_erratum_eq_16_as_printed_never_moves_the_arm(name):
    scenario = load_scenario(name)

    def make():
        return BlendingDecomposer(Swapped(scenario.decomposer), scenario.workspace)

    log = simulate(scenario, decomposer=make).log
    command, share = log["ee_command"], log["base_contribution"]
    assert np.abs(command).max() == 0.35
    # The base gets all of the command, 1.2 m and more (1.5 rad) from the limit that
    # counts: exp(-42 x 1.2) = 1e-22 of it goes to the arm, which is less than rounding.
    np.testing.assert_array_equal(share, command[:, :2])
    np.testing.assert_array_equal(log["arm_command"], 0.0)
    # 1,500 periods, each off by a rounding of angles of at most 4 rad.
    moved = np.abs(log["arm_position"] - log["arm_position"][0]).max()
    assert moved <= 1500 * 4.5e-16


@pytest.mark.parametrize("name", TABLE_2)
def test_erratum_eq_16_with_shares_swapped_back_moves_the_arm(name):
    scenario = load_scenario(name)
    log = simulate(scenario).log
    # A metre, or three quarters of a radian, until the base takes over.
    moved = np.ptp(log["ee_cylindrical"], axis=0)[:2].max()
    assert moved > 0.75


def eq_14b_as_printed(l):
    """1 - 0.5 tanh(alpha (l - L_min)) + 0.5, without Algorithm 1's brackets."""
    return 1 - 0.5 * math.tanh(ALPHA * (l - L_MIN)) + 0.5


@given(l=REACH)
def test_erratum_eq_14b_as_printed_is_one_more_than_a_share(l):
    printed = eq_14b_as_printed(l)
    assert 1 <= printed <= 2
    share = blended_share(-0.3, l, L_MIN, L_MAX, ALPHA)
    assert printed == pytest.approx(share + 1, abs=2 * ROUNDING)


def test_erratum_eq_14b_as_printed_drives_the_arm_out_when_told_in():
    # At L_min its share is 1.5: told to come in, the base goes in by half as much
    # again, and the arm out by half.
    v_c = -0.35
    v_m = (1 - eq_14b_as_printed(L_MIN)) * v_c
    assert v_m == pytest.approx(0.175, abs=ROUNDING)
