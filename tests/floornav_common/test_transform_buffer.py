"""The buffer against tf2's documented answers, and the laws of rigid motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from floornav_common.transform_buffer import TransformBuffer, TransformUnavailable, clean_frame
from floornav_common.transform_errors import (
    FutureExtrapolationError,
    NotConnectedError,
    PastExtrapolationError,
    TooEarlyError,
    UnknownFrameError,
)

S = 1_000_000_000
LEVEL = (0.0, 0.0, 0.0, 1.0)
TOL_M = 1e-9


def turned(yaw: float) -> tuple[float, float, float, float]:
    return (0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))


def driving() -> TransformBuffer:
    """odom -> base_link moves 1 m and turns 90 degrees from 1 s to 2 s; the laser is fixed."""
    buffer = TransformBuffer()
    buffer.set_transform("base_link", "laser", 0, (0.2, 0.0, 0.1), LEVEL, True)
    buffer.set_transform("odom", "base_link", 1 * S, (0.0, 0.0, 0.0), LEVEL)
    buffer.set_transform("odom", "base_link", 2 * S, (1.0, 0.0, 0.0), turned(math.pi / 2))
    return buffer


def test_halfway_is_on_the_line_and_half_the_turn() -> None:
    pose = driving().lookup("odom", "base_link", 1 * S + S // 2).to_se2()
    assert (pose.x, pose.y) == pytest.approx((0.5, 0.0), abs=TOL_M)
    assert pose.yaw == pytest.approx(math.pi / 4, abs=TOL_M)


def test_static_and_moving_transforms_chain() -> None:
    T_odom_laser = driving().lookup("odom", "laser", 2 * S)
    assert T_odom_laser.translation == pytest.approx([1.0, 0.2, 0.1], abs=TOL_M)


def test_siblings_meet_at_their_common_parent_without_the_world() -> None:
    buffer = driving()
    buffer.set_transform("base_link", "sonar", 0, (0.0, 0.3, 0.0), LEVEL, True)
    T_sonar_laser = buffer.lookup("sonar", "laser", 100 * S)
    assert T_sonar_laser.translation == pytest.approx([0.2, -0.3, 0.1], abs=TOL_M)


@pytest.mark.parametrize("stamp", [0, None])
def test_stamp_zero_is_the_newest_common_one(stamp: int | None) -> None:
    buffer = driving()
    buffer.set_transform("map", "odom", 1 * S, (5.0, 0.0, 0.0), LEVEL)
    buffer.set_transform("map", "odom", 1 * S + S // 2, (5.0, 0.0, 0.0), LEVEL)
    assert buffer.newest_common_stamp("map", "laser") == 1 * S + S // 2
    at_newest = buffer.lookup("map", "laser", 1 * S + S // 2).matrix()
    assert np.allclose(buffer.lookup("map", "laser", stamp).matrix(), at_newest)


def test_static_chains_have_no_newest_stamp_and_answer_at_any() -> None:
    buffer = driving()
    assert buffer.newest_common_stamp("base_link", "laser") == 0
    for stamp in (None, 1, 10**18):
        assert buffer.lookup("base_link", "laser", stamp).translation[0] == 0.2


def test_a_frame_to_itself_is_the_identity() -> None:
    assert np.array_equal(driving().lookup("odom", "odom", 10**18).matrix(), np.eye(4))


@pytest.mark.parametrize(
    ("target", "source", "stamp", "kind", "words"),
    [
        ("odom", "camera", 1 * S, UnknownFrameError, ["'camera'", "base_link"]),
        ("kitchen", "laser", 1 * S, UnknownFrameError, ["'kitchen'"]),
        ("odom", "laser", 3 * S, FutureExtrapolationError, ["3.000", "1.000", "2.000", "'laser'"]),
        ("odom", "laser", S // 2, PastExtrapolationError, ["0.500", "1.000", "'base_link'"]),
        ("odom", "island", 1 * S, NotConnectedError, ["'island'", "'odom'", "'sea'"]),
    ],
)
def test_what_is_missing_is_named(
    target: str, source: str, stamp: int, kind: type[Exception], words: list[str]
) -> None:
    buffer = driving()
    buffer.set_transform("sea", "island", 1 * S, (0.0, 0.0, 0.0), LEVEL)
    with pytest.raises(kind) as caught:
        buffer.lookup(target, source, stamp)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert not buffer.can_transform(target, source, stamp)
    assert isinstance(caught.value, TransformUnavailable)


def test_what_left_the_cache_is_too_early() -> None:
    buffer = driving()
    buffer.set_transform("odom", "base_link", 13 * S, (2.0, 0.0, 0.0), LEVEL)
    with pytest.raises(TooEarlyError):
        buffer.lookup("odom", "base_link", 2 * S)
    assert buffer.can_transform("odom", "base_link", 13 * S)


def test_a_single_sample_answers_only_at_its_stamp() -> None:
    buffer = TransformBuffer()
    buffer.set_transform("odom", "base_link", 1 * S, (1.0, 0.0, 0.0), LEVEL)
    assert buffer.can_transform("odom", "base_link", 1 * S)
    assert not buffer.can_transform("odom", "base_link", 1 * S + 1)
    assert not buffer.can_transform("odom", "base_link", 1 * S - 1)


def test_samples_may_come_out_of_order() -> None:
    buffer = TransformBuffer()
    for second in (3, 1, 2):
        buffer.set_transform("odom", "base_link", second * S, (float(second**2), 0.0, 0.0), LEVEL)
    x = buffer.lookup("odom", "base_link", 1 * S + S // 2).translation[0]
    assert x == pytest.approx(2.5, abs=TOL_M)


def test_a_repeated_stamp_replaces_its_sample() -> None:
    buffer = driving()
    buffer.lookup("odom", "base_link", 1 * S + S // 2)
    assert buffer.set_transform("odom", "base_link", 2 * S, (3.0, 0.0, 0.0), LEVEL)
    pose = buffer.lookup("odom", "base_link", 1 * S + S // 2).to_se2()
    assert (pose.x, pose.yaw) == pytest.approx((1.5, 0.0), abs=TOL_M)


def test_one_late_sample_older_than_the_cache_is_ignored() -> None:
    buffer = driving()
    buffer.set_transform("odom", "base_link", 20 * S, (2.0, 0.0, 0.0), LEVEL)
    assert not buffer.set_transform("odom", "base_link", 9 * S, (9.0, 9.0, 9.0), LEVEL)
    assert buffer.lookup("odom", "base_link", 20 * S).translation[0] == 2.0


def test_memory_is_bounded_by_the_cache() -> None:
    buffer = TransformBuffer(cache_ns=1 * S)
    for i in range(500):
        buffer.set_transform("odom", "base_link", i * S // 50, (float(i), 0.0, 0.0), LEVEL)
    assert len(buffer._histories["base_link"]) == 51


def test_clear_forgets_what_moves_and_keeps_what_is_static() -> None:
    buffer = driving()
    buffer.clear()
    assert buffer.can_transform("base_link", "laser", 5 * S)
    assert not buffer.can_transform("odom", "laser", 2 * S)
    buffer.set_transform("odom", "base_link", S // 10, (7.0, 0.0, 0.0), LEVEL)
    assert buffer.lookup("odom", "base_link").translation[0] == 7.0


def test_a_frame_may_change_its_parent() -> None:
    buffer = TransformBuffer()
    buffer.set_transform("table", "cup", 1 * S, (1.0, 0.0, 0.0), LEVEL)
    buffer.set_transform("hand", "cup", 2 * S, (0.1, 0.0, 0.0), LEVEL)
    assert buffer.lookup("table", "cup", 1 * S + S // 2).translation[0] == 1.0
    assert buffer.lookup("hand", "cup", 2 * S).translation[0] == 0.1
    assert buffer.parent_of("cup") == "hand"
    with pytest.raises(NotConnectedError):
        buffer.lookup("table", "cup", 2 * S)


def test_the_last_word_decides_whether_a_frame_is_static() -> None:
    buffer = driving()
    buffer.set_transform("base_link", "laser", 3 * S, (0.5, 0.0, 0.0), LEVEL)
    assert not buffer.can_transform("base_link", "laser", 9 * S)
    buffer.set_transform("base_link", "laser", 0, (0.6, 0.0, 0.0), LEVEL, True)
    assert buffer.lookup("base_link", "laser", 9 * S).translation[0] == 0.6


def test_a_static_transform_sent_again_replaces_the_old_one() -> None:
    buffer = driving()
    buffer.set_transform("base_link", "laser", 0, (0.3, 0.0, 0.1), LEVEL, True)
    assert buffer.lookup("base_link", "laser", 5 * S).translation[0] == 0.3


def test_leading_slashes_are_stripped_everywhere() -> None:
    buffer = TransformBuffer()
    buffer.set_transform("/odom", "/base_link", 1 * S, (1.0, 0.0, 0.0), LEVEL)
    assert buffer.lookup("odom", "/base_link", 1 * S).translation[0] == 1.0
    assert buffer.frames == ("odom", "base_link")
    assert clean_frame("/r2/odom") == "r2/odom"


@pytest.mark.parametrize(
    ("translation", "quat"),
    [
        ((math.nan, 0.0, 0.0), LEVEL),
        ((math.inf, 0.0, 0.0), LEVEL),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, math.nan, 1.0)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.1)),
    ],
)
def test_unusable_numbers_are_refused_with_the_frames(
    translation: tuple[float, float, float], quat: tuple[float, float, float, float]
) -> None:
    buffer = driving()
    with pytest.raises(ValueError, match="'odom' to 'base_link'"):
        buffer.set_transform("odom", "base_link", 3 * S, translation, quat)
    assert buffer.newest_common_stamp("odom", "base_link") == 2 * S


def test_slightly_unnormalized_quaternions_are_taken_and_normalized() -> None:
    buffer = TransformBuffer()
    buffer.set_transform("odom", "base_link", 1 * S, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.004))
    rotation = buffer.lookup("odom", "base_link", 1 * S).rotation
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=TOL_M)


@pytest.mark.parametrize("child", ["odom", "/odom", "", "/"])
def test_empty_frames_and_frames_in_themselves_are_refused(child: str) -> None:
    with pytest.raises(ValueError, match="loop|empty"):
        TransformBuffer().set_transform("odom", child, 1 * S, (0.0, 0.0, 0.0), LEVEL)


def test_loops_are_refused_and_leave_the_tree_as_it_was() -> None:
    buffer = driving()
    with pytest.raises(ValueError, match="loop: odom -> laser -> base_link -> odom"):
        buffer.set_transform("laser", "odom", 1 * S, (0.0, 0.0, 0.0), LEVEL)
    assert buffer.can_transform("odom", "laser", 1 * S)


quaternions = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(
    lambda q: math.sqrt(sum(v * v for v in q)) > 0.1
)
positions = st.tuples(*[st.floats(-50.0, 50.0)] * 3)
TOL_LAW = 1e-6  # m and parts of a rotation matrix, at distances up to 100 m


def unit(quat: tuple[float, ...]) -> np.ndarray:
    return np.array(quat) / np.linalg.norm(quat)


@settings(max_examples=60)
@given(positions, quaternions, positions, quaternions, st.floats(0.0, 1.0))
def test_laws_of_rigid_motion(p0: tuple, q0: tuple, p1: tuple, q1: tuple, share: float) -> None:
    buffer = TransformBuffer()
    buffer.set_transform("a", "b", 1 * S, p0, unit(q0))
    buffer.set_transform("a", "b", 2 * S, p1, unit(q1))
    buffer.set_transform("b", "c", 0, p1, unit(q0), True)
    stamp = 1 * S + int(share * S)
    T_a_c = buffer.lookup("a", "c", stamp)
    assert np.allclose((T_a_c @ buffer.lookup("c", "a", stamp)).matrix(), np.eye(4), atol=TOL_LAW)
    through_b = buffer.lookup("a", "b", stamp) @ buffer.lookup("b", "c", stamp)
    assert np.allclose(T_a_c.matrix(), through_b.matrix(), atol=TOL_LAW)
    assert np.allclose(T_a_c.inverse().matrix(), buffer.lookup("c", "a", stamp).matrix())
    for end, quat in ((1, q0), (2, q1)):
        rotation = buffer.lookup("a", "b", end * S).rotation
        assert np.allclose(rotation, Rotation.from_quat(unit(quat)).as_matrix(), atol=TOL_LAW)


@settings(max_examples=60)
@given(quaternions, quaternions, st.floats(0.0, 1.0))
def test_interpolation_turns_the_shorter_way_at_a_steady_rate(
    q0: tuple, q1: tuple, share: float
) -> None:
    buffer = TransformBuffer()
    buffer.set_transform("a", "b", 1 * S, (0.0, 0.0, 0.0), unit(q0))
    buffer.set_transform("a", "b", 2 * S, (0.0, 0.0, 0.0), unit(q1))
    start, end = Rotation.from_quat(unit(q0)), Rotation.from_quat(unit(q1))
    whole = (start.inv() * end).magnitude()
    stamp = 1 * S + int(share * S)
    here = Rotation.from_matrix(buffer.lookup("a", "b", stamp).rotation)
    assert (start.inv() * here).magnitude() == pytest.approx(share * whole, abs=TOL_LAW)
