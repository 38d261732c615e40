"""When the robot counts as lost."""

from grid_mapper.tracking import Tracking

S = 10**9
AFTER = 3.0


def test_lost_until_the_first_trusted_scan():
    tracking = Tracking()
    assert tracking.is_lost
    tracking.update(1 * S, False, AFTER)
    assert tracking.is_lost
    tracking.update(2 * S, True, AFTER)
    assert not tracking.is_lost


def test_lost_after_too_long_without_a_trusted_scan_and_found_again():
    tracking = Tracking()
    tracking.update(0, True, AFTER)
    for second, is_lost in ((1, False), (3, False), (4, True)):
        tracking.update(second * S, False, AFTER)
        assert tracking.is_lost == is_lost
    tracking.update(5 * S, True, AFTER)
    assert not tracking.is_lost


def test_stamps_that_jump_back_do_not_hide_a_loss():
    tracking = Tracking()
    tracking.update(100 * S, True, AFTER)
    tracking.update(10 * S, False, AFTER)
    assert not tracking.is_lost
    tracking.update(14 * S, False, AFTER)
    assert tracking.is_lost


def test_once_lost_by_silence_only_a_trusted_scan_finds_it_again():
    tracking = Tracking()
    tracking.update(1 * S, True, AFTER)
    tracking.lose()
    assert tracking.is_lost
    tracking.update(2 * S, False, AFTER)
    assert tracking.is_lost
    tracking.update(3 * S, True, AFTER)
    assert not tracking.is_lost
