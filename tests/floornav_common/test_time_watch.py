"""The rule of time: each rule on its own, with both clocks handed in."""

from __future__ import annotations

from floornav_common.time_watch import Deadline, Throttle, TimeWatch

S = 1_000_000_000


def run(watch: TimeWatch, deadline: Deadline, steady_s: float, rate: float) -> None:
    """Let steady time pass in steps of 0.1 s with `/clock` at a rate; nothing is fed."""
    sim, steady = watch._sim_ns or 0, watch._steady_ns or 0
    for i in range(1, round(steady_s * 10) + 1):
        watch.update(steady + i * S // 10, int(sim + i * rate * S / 10))
        deadline.is_over(watch.now_ns)


def test_on_a_robot_silence_is_counted_on_the_steady_clock() -> None:
    watch, deadline = TimeWatch(), Deadline(S // 2)
    watch.update(5 * S, None)
    deadline.feed(watch.now_ns)
    watch.update(5 * S + S // 2, None)
    assert not deadline.is_over(watch.now_ns)
    watch.update(5 * S + S // 2 + 1, None)
    assert deadline.is_over(watch.now_ns)
    assert not watch.is_simulated and not watch.is_stopped


def test_with_simulated_time_silence_is_counted_in_it() -> None:
    watch, deadline = TimeWatch(), Deadline(S // 2)
    watch.update(5 * S, 100 * S)
    deadline.feed(watch.now_ns)
    watch.update(6 * S, 100 * S + S // 4)
    assert not deadline.is_over(watch.now_ns)
    watch.update(6 * S + 1, 101 * S)
    assert deadline.is_over(watch.now_ns)


def test_a_tenth_of_real_time_gives_ten_times_as_long() -> None:
    watch, deadline = TimeWatch(), Deadline(S // 2)
    watch.update(1, 100 * S)
    deadline.feed(watch.now_ns)
    run(watch, deadline, 4.9, rate=0.1)
    assert not deadline.is_over(watch.now_ns) and not watch.is_stopped
    run(watch, deadline, 0.3, rate=0.1)
    assert deadline.is_over(watch.now_ns)


def test_ten_times_real_time_gives_a_tenth() -> None:
    watch, deadline = TimeWatch(), Deadline(5 * S)
    watch.update(1, 100 * S)
    deadline.feed(watch.now_ns)
    run(watch, deadline, 0.5, rate=10.0)
    assert not deadline.is_over(watch.now_ns)
    run(watch, deadline, 0.1, rate=10.0)
    assert deadline.is_over(watch.now_ns)


def test_a_pause_is_no_silence_but_a_fault_of_its_own_after_2_s() -> None:
    watch, deadline = TimeWatch(), Deadline(S // 2)
    watch.update(1, 100 * S)
    deadline.feed(watch.now_ns)
    run(watch, deadline, 1.9, rate=0.0)
    assert not watch.is_stopped
    run(watch, deadline, 60.0, rate=0.0)
    assert watch.is_stopped and not deadline.is_over(watch.now_ns)
    watch.update(62 * S, 100 * S + S // 10)
    assert not watch.is_stopped and not deadline.is_over(watch.now_ns)


def test_a_clock_that_never_comes_is_stopped() -> None:
    watch = TimeWatch()
    watch.update(1 * S, 0)
    assert not watch.is_stopped
    watch.update(3 * S, 0)
    assert watch.is_stopped and watch.stopped_for_ns == 2 * S


def test_the_first_clock_is_no_silence() -> None:
    watch, deadline = TimeWatch(), Deadline(S // 2)
    watch.update(1 * S, 0)
    deadline.feed(watch.now_ns)
    assert not watch.update(1 * S + 1, 1_700_000_000 * S)
    assert not deadline.is_over(watch.now_ns)
    watch.update(1 * S + 2, 1_700_000_001 * S)
    assert deadline.is_over(watch.now_ns)


def test_a_clock_that_jumps_back_starts_everything_afresh() -> None:
    watch, deadline = TimeWatch(), Deadline(S // 2)
    calls: list[str] = []
    watch.on_restart(lambda: calls.append("cleared"))
    watch.on_restart(deadline.restart)
    assert not watch.update(1 * S, 100 * S)
    deadline.feed(watch.now_ns)
    assert watch.update(2 * S, 3 * S)
    assert calls == ["cleared"] and not deadline.has_heard
    assert not deadline.is_over(watch.now_ns)
    watch.update(3 * S, 4 * S)
    assert deadline.is_over(watch.now_ns)
    assert calls == ["cleared"]


def test_a_change_to_simulated_time_and_back_starts_afresh() -> None:
    watch = TimeWatch()
    assert not watch.update(1 * S, None)
    assert watch.update(2 * S, 0)
    assert watch.update(3 * S, None)
    assert not watch.is_stopped and not watch.is_simulated


def test_a_jump_ahead_is_time_that_passed() -> None:
    watch, deadline = TimeWatch(), Deadline(S // 2)
    watch.update(1 * S, 100 * S)
    deadline.feed(watch.now_ns)
    assert not watch.update(2 * S, 500 * S)
    assert deadline.is_over(watch.now_ns)


def test_what_never_came_is_counted_from_the_first_look() -> None:
    deadline = Deadline(S)
    assert not deadline.is_over(50 * S)
    assert deadline.is_over(52 * S) and not deadline.has_heard


def test_throttle_lets_one_through_in_a_while() -> None:
    throttle = Throttle(5 * S)
    passed = [t for t in range(0, 20) if throttle.is_due(t * S)]
    assert passed == [0, 5, 10, 15]
