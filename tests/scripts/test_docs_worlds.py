"""docs/worlds.md: what is on it, and the pictures that it shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pybullet", reason="no pybullet: worlds cannot be simulated")

ROOT = Path(__file__).resolve().parents[2]


def test_the_page_shows_every_world_of_the_package():
    from _docs_worlds import SHOWN
    from sim_bridge.world import world_names

    assert set(world_names()) <= {shown.name for shown in SHOWN}


def test_the_page_is_what_the_code_says():
    from _docs_worlds import PAGE, worlds_page

    assert (ROOT / "docs" / PAGE).read_text(encoding="utf-8") == worlds_page()


def test_a_picture_that_is_missing_or_left_over_is_named(tmp_path: Path):
    from _docs_worlds import FOLDER, SENSOR_PICTURES, SHOWN, pictures_amiss

    folder = tmp_path / FOLDER
    folder.mkdir(parents=True)
    for name in (*(shown.picture for shown in SHOWN), *SENSOR_PICTURES):
        (folder / name).write_bytes(b"x")
    assert pictures_amiss(tmp_path) == []
    (folder / "flat.png").rename(folder / "flat2.png")
    assert pictures_amiss(tmp_path) == ["flat.png is missing", "flat2.png is on no page"]


def test_the_text_gives_the_figures_of_the_defaults():
    from _docs_sensor_text import sensor_text

    text = sensor_text("p")
    assert "critical angle of 15 degrees" in text and "10 + 15 = 25 degrees" in text
    assert "8 mm, index 1.52" in text
    assert "| 100 | 1.62 | 0.127 |" in text  # eq. 26 by hand: 100 / (10.12 - 0.02054 * 489.69)
    assert "205 mm above the floor" in text
    assert "6.9 px at 4 m" in text  # 0.10 m * 276.3 px / 4 m


def test_a_ride_keeps_the_last_scan_and_where_everyone_was():
    from _tour_ride import ride
    from sim_bridge.world import load_world

    ridden = ride(load_world("sjmc_oncoming"), 0.5, seed=0)
    ridden.simulation.close()
    assert len(ridden.ways[""]) == 50 and len(ridden.people_now) == 1
    (way,) = ridden.people.values()
    assert len(way) == 50
    last = ridden.last[""]
    assert last.scan is not None
    assert (last.T_world_base.x, last.T_world_base.y) == ridden.ways[""][-1]


def test_a_ride_that_is_not_driven_stands_still():
    from _tour_ride import ride
    from sim_bridge.world import load_world

    ridden = ride(load_world("sjmc_static"), 0.3, seed=0, is_driven=False)
    ridden.simulation.close()
    assert np.ptp(np.array(ridden.ways[""]), axis=0) == pytest.approx([0.0, 0.0], abs=1e-6)
