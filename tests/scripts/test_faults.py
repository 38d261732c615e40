"""scripts/evaluate.py faults as a user starts it, its list and its page."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy", reason="no ROS: there is no graph")
pytest.importorskip("tf2_msgs", reason="tf2_msgs could not be built here")
import evaluate  # noqa: E402
from experiments import faults, faults_case  # noqa: E402
from experiments.faults_judge import DriveRecord  # noqa: E402
from experiments.faults_page import faults_page  # noqa: E402
from experiments.faults_result import Row  # noqa: E402


def test_every_fault_has_a_name_of_its_own_and_the_quick_ones_are_among_them() -> None:
    names = [fault.name for some in faults.all_faults().values() for fault in some]
    assert len(names) == len(set(names)) >= 20
    assert set(faults._QUICK) <= set(names)


def test_the_list_is_printed_and_leaves_no_folder(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as left:
        evaluate.main(["faults", "--list"])
    assert left.value.code == 0 and "kill-grid_mapper" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_a_name_of_no_fault_is_refused(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(evaluate_error(), match="no fault named nothing"):
        evaluate.main(["faults", "--only", "nothing"])
    assert list(tmp_path.iterdir()) == []


def evaluate_error() -> type[Exception]:
    from floornav_common.reporting import UserError

    return UserError


def row(name: str, *, safe: bool, recovered: bool = True) -> Row:
    figures = {"stop_ms": 50.0 if safe else None, "recover_s": 1.0 if recovered else None}
    return Row(name, "what", "a|b", "seen", safe, recovered, graph="hall", kind="halt", **figures)


def test_the_page_counts_what_passed_and_marks_what_did_not() -> None:
    rows = [
        row("good", safe=True),
        row("bad", safe=False),
        row("stuck", safe=True, recovered=False),
    ]
    page = faults_page(rows, 100.0, "2 cores")
    assert "**1 of 3 passed**" in page and page.count("**not passed:**") == 2
    assert "| `good` | what | a/b | seen | 50 |  | 1.0 |  |" in page
    assert "never" in page


def test_the_summary_has_the_keys_that_were_agreed_on() -> None:
    values: dict[str, object] = {}
    faults._fill(values, [row("good", safe=True), row("bad", safe=False)])
    assert (values["passed"], values["total"]) == (1, 2)
    first = json.loads(json.dumps(values["faults"]))[0]
    assert {"name", "safe", "recovered", "stop_ms"} <= set(first) and "trace" not in first


def run_on(monkeypatch, attempts: list[tuple[bool, int, int, int]]) -> Row:
    """Return the row of a fault whose attempts end (safe, clock stops, unanswered, touches)."""
    watch = SimpleNamespace(num_clock_stops=0, record=DriveRecord())
    graph, left = SimpleNamespace(watch=watch, notes={}), list(attempts)

    def run_once(_graph: object, _fault: object) -> Row:
        safe, stops, graph.notes["unanswered"], touches = left.pop(0)
        watch.num_clock_stops += stops
        watch.record.touches.extend([1] * touches)
        return row("kill", safe=safe)

    monkeypatch.setattr(faults_case, "_run_once", run_once)
    fault = next(f for f in faults.all_faults()["field"] if f.name == "image-silent")
    return faults_case.run_fault(graph, fault)


def test_a_fault_is_run_anew_where_time_did_not_wait_for_the_planner(monkeypatch) -> None:
    found = run_on(monkeypatch, [(False, 0, 3, 0), (False, 1, 0, 0), (True, 0, 0, 0)])
    assert found.passed and "run 3 times, as the machine stood still for 2 s" in found.seen
    found = run_on(monkeypatch, [(False, 0, 3, 0), (True, 0, 0, 0)])
    assert found.passed and "run 2 times, as time went on" in found.seen


def test_what_passed_though_time_did_not_wait_stays_as_it_is(monkeypatch) -> None:
    assert run_on(monkeypatch, [(True, 0, 3, 0)]).seen == "seen"


def test_neither_a_touch_nor_a_failure_on_a_quiet_machine_is_excused(monkeypatch) -> None:
    assert not run_on(monkeypatch, [(False, 0, 3, 1)]).passed
    assert not run_on(monkeypatch, [(False, 0, 0, 0)]).passed


def test_a_machine_that_is_always_busy_ends_in_a_failure(monkeypatch) -> None:
    found = run_on(monkeypatch, [(False, 0, 3, 0)] * 4)
    assert not found.passed and "run 4 times" in found.seen
