"""Scans taken beam by beam: the order is learned, times that cannot be are not believed."""

from dataclasses import replace

import numpy as np
import pytest
from worlds import square_room, swept_scan

from floornav_common.scan import Scan
from floornav_common.se2 import SE2
from floornav_common.twists import steady_offsets
from grid_mapper.config import GridMapperConfig, MotionConfig
from grid_mapper.layers import LayeredMapper
from grid_mapper.loop_localizer import LoopClosingLocalizer
from grid_mapper.map_rebuild import MapRebuild
from grid_mapper.mapper import GridMapper
from grid_mapper.sweeps import (
    AS_SENT,
    MAX_TRIALS,
    NUM_GAPS,
    TURNED_ROUND,
    UNKNOWN,
    SweepOrder,
    in_order,
    sweep_of,
    sweep_twist,
    with_sweep,
)

HERE, MOUNT = SE2.identity(), SE2(0.1, 0.0, 0.2)
PERIOD_NS, SWEEP_S, NUM_BEAMS = 100_000_000, 0.09, 180
STEP = SWEEP_S / (NUM_BEAMS - 1)
TURNING = (0.0, 0.0, 1.0)


def raw(step=STEP, num=NUM_BEAMS):
    return Scan(np.ones(num), -np.pi, 0.01, 0.05, 30.0, step)


def believing(order=UNKNOWN):
    sweeps = SweepOrder()
    for k in range(NUM_GAPS + 1):
        sweeps.note(k * PERIOD_NS, raw())
    sweeps.order = order
    return sweeps


def wiggle(num):
    """Return the robot's pose at a time, s: it drives on and turns by up to 1.3 rad/s."""
    t = np.arange(0.0, num * 0.1 + 1.0, 0.001)
    yaw = 0.5 * np.sin(2.5 * t) + 0.15 * t
    x, y = (np.cumsum(0.25 * f(yaw)) * 0.001 for f in (np.cos, np.sin))
    return lambda at: SE2(*(np.interp(at + 0.5, t, v) for v in (x - 1.5, y - 1.0, yaw)))


def drive(mapper, order=AS_SENT, num=90):
    """Let a mapper follow a robot that turns to and fro; return results and the true poses."""
    pose_at, rng, results, truth = wiggle(num), np.random.default_rng(0), [], []
    for k in range(num):
        times = k * 0.1 + order * STEP * np.arange(NUM_BEAMS)
        poses = [pose_at(t) @ MOUNT for t in times]
        scan = swept_scan(poses, square_room(), STEP, rng)
        truth.append(pose_at(k * 0.1))
        results.append(mapper.insert_scan(k * PERIOD_NS, scan, MOUNT, truth[-1]))
    return results, truth


def turn_errors(results, truth):
    """Return how far the motions found are from the true ones, mean of the turn, rad."""
    found = [a.T_map_base.between(b.T_map_base) for a, b in zip(results, results[1:], strict=False)]
    true = [a.between(b) for a, b in zip(truth, truth[1:], strict=False)]
    return float(np.mean([abs(t.between(f).yaw) for t, f in zip(true, found, strict=True)][20:]))


@pytest.mark.parametrize(("order", "sign"), [(AS_SENT, 1.0), (TURNED_ROUND, -1.0)])
def test_one_beam_by_hand(order, sign):
    # The 10th beam of a robot that turns by 1 rad/s came 0.1 s after the first, or before it.
    scan = in_order(raw(0.01, 11), HERE, TURNING, order)
    assert scan.angles[10] == pytest.approx(-np.pi + 0.1 + sign * 0.1)


def test_the_motion_is_that_of_the_sensor_where_it_is_mounted():
    scan = in_order(raw(0.01, 11), SE2(0.5, 0.0, 0.0), TURNING, AS_SENT)
    assert scan.twist == pytest.approx((0.0, 0.5, 1.0))
    assert scan.origins()[10] == pytest.approx(steady_offsets((0.0, 0.5, 1.0), np.array([0.1]))[0])


def test_without_time_between_beams_the_scan_stays_as_it_is():
    still = raw(0.0)
    assert believing(AS_SENT).deskewed(still, HERE, TURNING, "auto") is still
    assert SweepOrder().words("auto") == ""


@pytest.mark.parametrize(
    ("deskew", "step"),
    [("auto", -STEP), ("first_to_last", STEP), ("last_to_first", -STEP), ("none", STEP)],
)
def test_what_the_parameter_says_is_done(deskew, step):
    scan = believing(TURNED_ROUND).deskewed(raw(), HERE, TURNING, deskew)
    assert scan.time_increment == step
    assert (scan.twist is None) == (deskew == "none")


@pytest.mark.parametrize("step", [-STEP, np.nan, np.inf])
def test_a_time_that_cannot_be_is_not_believed(step):
    sweeps = SweepOrder()
    sweeps.note(0, raw(step))
    assert "time_increment is" in sweeps.objection and not sweeps.is_believed
    scan = raw(step)
    assert sweeps.deskewed(scan, HERE, TURNING, "first_to_last") is scan


def test_a_sweep_longer_than_scans_are_apart_is_not_believed():
    sweeps = SweepOrder()
    for k in range(NUM_GAPS + 1):
        sweeps.note(k * PERIOD_NS, raw(0.12 / (NUM_BEAMS - 1)))
    assert "takes 0.120 s, but scans are 0.100 s apart" in sweeps.words("auto")
    assert not sweeps.is_believed


def test_one_stamp_late_and_one_repeated_do_not_matter():
    sweeps = SweepOrder()
    stamps = [*range(NUM_GAPS), NUM_GAPS - 1, NUM_GAPS + 3]
    for k in stamps:
        sweeps.note(k * PERIOD_NS, raw())
    assert sweeps.is_believed


def test_no_order_is_learned_where_either_fits_as_well():
    sweeps, rng = believing(), np.random.default_rng(0)
    for _ in range(MAX_TRIALS + 5):
        sweeps.learn(raw(), HERE, TURNING, lambda scan: 0.8 + rng.normal(0.0, 0.01))
    assert sweeps.order == UNKNOWN
    assert sweeps.num_trials == MAX_TRIALS


@pytest.mark.parametrize("order", [AS_SENT, TURNED_ROUND])
def test_the_order_that_fits_better_is_learned(order):
    sweeps, rng = believing(), np.random.default_rng(0)
    for _ in range(60):
        better = 0.02 * order
        sweeps.learn(
            raw(), HERE, TURNING,
            lambda s, b=better: 0.8 + np.sign(s.time_increment) * b + rng.normal(0.0, 0.02),
        )  # fmt: skip
    assert sweeps.order == order


def test_a_robot_that_does_not_turn_teaches_nothing():
    sweeps = believing()
    sweeps.learn(raw(), HERE, (1.0, 0.0, 0.05), lambda scan: 1.0)
    assert sweeps.num_trials == 0


def test_a_motion_over_a_gap_or_too_fast_for_a_robot_is_none():
    config = MotionConfig()
    assert sweep_twist(SE2(0.1, 0.0, 0.05), 0.1, config) == pytest.approx((1.0, 0.0, 0.5), abs=0.05)
    assert sweep_twist(SE2(0.1, 0.0, 0.0), 0.0, config) is None
    assert sweep_twist(SE2(0.1, 0.0, 0.0), 1.5, config) is None
    assert sweep_twist(SE2(0.5, 0.0, 0.0), 0.1, config) is None
    assert sweep_twist(SE2(0.0, 0.0, 0.5), 0.1, config) is None


def test_a_sweep_can_be_given_back():
    scan = in_order(raw(), HERE, TURNING, TURNED_ROUND)
    again = with_sweep(raw(), sweep_of(scan))
    assert (again.time_increment, again.twist) == (scan.time_increment, scan.twist)
    assert sweep_of(raw()) is None and with_sweep(scan, None) is scan


@pytest.mark.parametrize("order", [AS_SENT, TURNED_ROUND])
def test_the_order_is_learned_while_the_robot_turns_and_turns_are_found_better(order):
    learning, plain = (GridMapper(GridMapperConfig(deskew=word)) for word in ("auto", "none"))
    found, truth = drive(learning, order)
    before, _ = drive(plain, order)
    assert learning.sweeps.order == order
    assert plain.sweeps.order == UNKNOWN
    assert turn_errors(found, truth) < 0.5 * turn_errors(before, truth)


def test_without_odometry_the_motion_found_so_far_says_it():
    class Blind(GridMapper):
        def insert_scan(self, stamp_ns, scan, T_base_laser, T_odom_base):
            return super().insert_scan(stamp_ns, scan, T_base_laser, None)

    errors = []
    for deskew in ("first_to_last", "none"):
        errors.append(turn_errors(*drive(Blind(GridMapperConfig(deskew=deskew)))))
    assert errors[0] < 0.95 * errors[1]


def test_maps_made_anew_hold_the_points_that_were_matched():
    config = GridMapperConfig(deskew="first_to_last")
    localizer, seen = LoopClosingLocalizer(config), []

    class Both:
        def insert_scan(self, *event):
            seen.append(event)
            return localizer.insert_scan(*event)

    drive(Both(), num=30)
    poses, mapped = localizer.known_poses(), []
    mapper = LayeredMapper(config)
    mapper.follow_scan = lambda stamp_ns, scan, *rest: mapped.append(scan)  # type: ignore[assignment]
    rebuild = MapRebuild(mapper, poses)
    for event in seen:
        rebuild.insert_scan(*event)
    assert mapped[-1].twist is not None and mapped[0].twist is None
    frames = {frame.stamp_ns: frame for frame in localizer.closer.frames}
    kept = [frames[event[0]].scan for event in seen if event[0] in frames]
    again = [scan for scan, event in zip(mapped, seen, strict=True) if event[0] in frames]
    assert len(kept) >= 3
    assert all(np.array_equal(a.points(), b.points()) for a, b in zip(kept, again, strict=True))


def test_a_scan_without_times_gives_the_same_map_whatever_the_parameter_says():
    results = []
    for deskew in ("auto", "first_to_last", "none"):
        mapper = GridMapper(GridMapperConfig(deskew=deskew))
        pose_at, rng = wiggle(15), np.random.default_rng(0)
        for k in range(15):
            pose = pose_at(k * 0.1)
            scan = replace(swept_scan([pose] * NUM_BEAMS, square_room(), STEP, rng),
                           time_increment=0.0)  # fmt: skip
            mapper.insert_scan(k * PERIOD_NS, scan, HERE, pose)
        results.append(mapper.occupancy().cells.tobytes())
    assert results[0] == results[1] == results[2]
