"""The shoulder, from the axes of an arm's joints."""

import math

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from drake_mobman.arm.axes import Line, distance, nearest_on
from drake_mobman.arm.shoulder import JointAxis, shoulder

NEAR = 1e-9
"""[m]: rounding, over the square of the least angle between two axes below, 1e-4."""

NUMBER = st.floats(-1.0, 1.0)
POINT = st.tuples(NUMBER, NUMBER, NUMBER).map(np.array)
DIRECTION = POINT.filter(lambda p: np.linalg.norm(p) > 0.1).map(
    lambda p: p / np.linalg.norm(p)
)
LINE = st.builds(Line, POINT, DIRECTION)

UP = np.array([0.0, 0.0, 1.0])
AHEAD = np.array([1.0, 0.0, 0.0])
AT = np.array([0.1, -0.2, 0.3])


def turning(index, point, direction):
    return JointAxis(index, False, Line(np.array(point), np.array(direction)))


def sliding(index, point, direction):
    return JointAxis(index, True, Line(np.array(point), np.array(direction)))


@given(a=LINE, b=LINE)
def test_nearest_points_of_two_axes_are_joined_at_right_angles(a, b):
    assume(np.linalg.norm(np.cross(a.direction, b.direction)) > 0.01)
    between = nearest_on(b, a) - nearest_on(a, b)
    assert abs(between @ a.direction) < NEAR
    assert abs(between @ b.direction) < NEAR
    assert math.isclose(np.linalg.norm(between), distance(a, b), abs_tol=NEAR)
    off = np.cross(nearest_on(a, b) - a.point, a.direction)
    assert np.linalg.norm(off) < NEAR


@given(a=LINE, b=LINE, along=st.floats(-1.0, 1.0))
def test_parallel_axes_have_a_distance_and_no_nearest_point(a, b, along):
    other = Line(b.point + along * a.direction, a.direction)
    np.testing.assert_array_equal(nearest_on(a, other), a.point)
    off = b.point - a.point
    across = off - (off @ a.direction) * a.direction
    assert math.isclose(distance(a, other), np.linalg.norm(across), abs_tol=NEAR)


def test_the_shoulder_is_on_the_first_axis_level_with_the_second():
    second = turning(1, [0.4, 0.05, 0.7], [0.0, 1.0, 0.0])
    for sign in (1.0, -1.0):
        found = shoulder([turning(0, AT, sign * UP), second])
        np.testing.assert_allclose(found.p_BS, [0.1, -0.2, 0.7], atol=1e-15)
        assert found.turn == (0, sign)
        assert found.lift is None


def test_a_lift_moves_the_arm_whichever_way_it_points_and_wherever_it_stands():
    pan, pitch = turning(1, AT, UP), turning(2, AT, [0.0, 1.0, 0.0])
    below = shoulder([sliding(0, [0.0, 0.0, 0.0], -UP), pan, pitch])
    assert (below.lift, below.turn) == ((0, -1.0), (1, 1.0))
    above = shoulder([turning(0, AT, UP), sliding(1, AT, UP), pitch])
    assert (above.lift, above.turn) == ((1, 1.0), (0, 1.0))


def test_joints_after_a_tilted_one_carry_no_whole_arm():
    pitch = turning(1, AT, [0.0, 1.0, 0.0])
    rail = sliding(0, AT, AHEAD)
    assert shoulder([rail, turning(1, AT, UP), pitch])[1:] == (None, None)
    oblique = turning(0, AT, [0.6, 0.0, 0.8])
    found = shoulder([oblique, sliding(1, AT, UP), pitch])
    assert found[1:] == (None, None)
    np.testing.assert_allclose(found.p_BS, AT, atol=1e-15)


def test_a_mount_that_is_slightly_off_still_turns_the_arm():
    tilted = np.array([0.0, 1.5e-5, 1.0])
    assert shoulder([turning(0, AT, tilted), turning(1, AT, AHEAD)]).turn == (0, 1.0)


def test_a_second_vertical_axis_leaves_the_shoulder_at_the_first():
    elbow, quill = turning(1, [0.5, 0.0, 0.4], UP), sliding(2, [0.8, 0.0, 0.4], -UP)
    found = shoulder([turning(0, AT, UP), elbow, quill])
    np.testing.assert_array_equal(found.p_BS, AT)
    assert found[1:] == ((0, 1.0), None)
