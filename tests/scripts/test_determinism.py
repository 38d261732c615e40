import argparse

import pytest

from experiments.determinism import FILES, check, differing, run
from floornav_common.reporting import UserError

NUM_SCANS = 12


def log(path):
    """Write a CARMEN log of a robot that comes nearer to a wall between two others."""
    ranges = [3.0 / max(0.2, abs(k - 90) / 60.0) for k in range(180)]
    lines = []
    for k in range(NUM_SCANS):
        numbers = " ".join(f"{value:.2f}" for value in ranges)
        pose = f"{0.3 * k:.2f} 0 0"
        lines.append(f"FLASER 180 {numbers} {pose} {pose} {k}.0 robot {k}.0\n")
    path.write_text("".join(lines))
    return path


def options(tmp_path, recording, **given):
    values = {"runs": 2, "loaded": 1, "busy": 1, "max_scans": None, "quiet": True}
    return argparse.Namespace(recording=recording, out_dir=tmp_path, **(values | given))


def test_two_runs_one_beside_a_busy_process_give_the_same_bytes(tmp_path):
    values = {}
    sections = run(options(tmp_path, log(tmp_path / "a.log")), values)
    assert values["identical"] is True and values["differing"] == []
    assert [r["busy"] for r in values["runs"]] == [0, 1]
    assert "Identical" in sections[0].blocks[-1]
    assert (tmp_path / "run-2" / "run.session").stat().st_size > 0


def test_a_file_that_differs_once_is_named():
    same = {"digests": dict.fromkeys(FILES, "a")}
    other = {"digests": {**same["digests"], "map.pgm": "b"}}
    assert differing([same, same, other]) == ["map.pgm"]
    assert differing([same, same]) == []


@pytest.mark.parametrize(("given", "problem"), [
    ({"runs": 1}, "--runs must be >= 2"), ({"loaded": 3}, "--loaded from 0"),
    ({"recording": "none.log"}, "there is no recording"),
])  # fmt: skip
def test_what_cannot_be_done_is_refused(tmp_path, given, problem):
    from pathlib import Path

    recording = Path(given.pop("recording", log(tmp_path / "a.log")))
    with pytest.raises(UserError, match=problem):
        check(options(tmp_path, recording, **given))
