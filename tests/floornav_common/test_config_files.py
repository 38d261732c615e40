"""YAML into dataclasses: what is right is taken, what is wrong is named."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from floornav_common.config import param, validate
from floornav_common.config_files import config_from_mapping, describe, load_config
from floornav_common.frames import FrameConfig


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """Parameters of every kind."""

    gain: float = param(0.5, "Gain of the loop.", unit="1/s", gt=0.0, le=1.0)
    num_beams: int = param(3, "Beams.", ge=1)
    mode: str = param("a", "Mode.", choices=("a", "b"))
    is_fast: bool = param(False, "Fast.")
    topics: tuple[str, ...] = param(("sonar",), "Topics.")
    limits: tuple[float, float] = param((-1.0, 1.0), "Limits.", unit="m")

    def __post_init__(self) -> None:
        validate(self)


def write(folder: Path, text: str) -> Path:
    path = folder / "tuning.yaml"
    path.write_text(text)
    return path


def test_an_empty_file_gives_the_defaults(tmp_path: Path) -> None:
    assert load_config(write(tmp_path, ""), Tuning) == Tuning()


def test_a_plain_mapping_and_a_ros_file_say_the_same(tmp_path: Path) -> None:
    plain = load_config(write(tmp_path, "gain: 1\ntopics: [a, b]\nlimits: [0, 2.5]"), Tuning)
    text = "mapper:\n  ros__parameters:\n    gain: 1\n    topics: [a, b]\n    limits: [0, 2.5]"
    assert load_config(write(tmp_path, text), Tuning) == plain
    assert plain == Tuning(gain=1.0, topics=("a", "b"), limits=(0.0, 2.5))
    assert isinstance(plain.gain, float)


def test_a_named_block_overrides_the_block_for_all(tmp_path: Path) -> None:
    text = (
        "/**:\n  ros__parameters: {gain: 0.1, num_beams: 7, use_sim_time: true}\n"
        "/r2/mapper:\n  ros__parameters: {gain: 0.2}\n"
    )
    config = load_config(write(tmp_path, text), Tuning)
    assert (config.gain, config.num_beams) == (0.2, 7)


def test_of_several_blocks_one_is_chosen_by_node(tmp_path: Path) -> None:
    text = (
        "r1:\n  mapper:\n    ros__parameters: {gain: 0.1}\n"
        "  planner:\n    ros__parameters: {speed: 3}\n"
    )
    path = write(tmp_path, text)
    with pytest.raises(ValueError, match="several nodes: r1/mapper, r1/planner"):
        load_config(path, Tuning)
    assert load_config(path, Tuning, node="mapper").gain == 0.1


def test_groups_and_keys_of_other_classes_may_share_a_file(tmp_path: Path) -> None:
    path = write(tmp_path, "loop: {gain: 0.25}\nmap_frame: world\n")
    assert load_config(path, Tuning, prefix="loop", others=[FrameConfig]).gain == 0.25


def test_unknown_keys_are_refused_with_the_nearest_name(tmp_path: Path) -> None:
    path = write(tmp_path, "gian: 0.5\nnum_baems: 3\nzzzzzz: 1\n")
    with pytest.raises(ValueError) as caught:
        load_config(path, Tuning)
    text = str(caught.value)
    assert "'gian' (did you mean 'gain'?)" in text and "(did you mean 'num_beams'?)" in text
    assert "'zzzzzz'" in text and str(path) in text


def test_what_ros_itself_declares_is_no_unknown_key(tmp_path: Path) -> None:
    text = "n:\n  ros__parameters:\n    use_sim_time: true\n    qos_overrides: {/scan: {x: 1}}\n"
    assert load_config(write(tmp_path, text), Tuning) == Tuning()


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"gain": 0}, "gain must be > 0, <= 1, got 0.0"),
        ({"gain": "fast"}, "gain must be a number, got 'fast'"),
        ({"gain": True}, "gain must be a number, got True"),
        ({"gain": float("nan")}, "gain must be finite, got nan"),
        ({"num_beams": 2.5}, "num_beams must be an integer, got 2.5"),
        ({"num_beams": True}, "num_beams must be an integer, got True"),
        ({"is_fast": 1}, "is_fast must be true or false, got 1"),
        ({"mode": "c"}, "mode must be one of a, b, got 'c'"),
        ({"mode": None}, "mode must be text, got None"),
        ({"topics": "sonar"}, "topics must be a list, got 'sonar'"),
        ({"topics": [1]}, "topics must be text, got 1"),
        ({"limits": [1.0]}, "limits must have 2 values, got 1"),
    ],
)
def test_a_wrong_value_is_named_with_its_range(values: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError) as caught:
        config_from_mapping(Tuning, values)
    assert str(caught.value) == said


@pytest.mark.parametrize("text", ["- a\n- b", "gain: [1,", "\x00"])
def test_a_file_that_is_no_mapping_is_one_line(tmp_path: Path, text: str) -> None:
    with pytest.raises(ValueError) as caught:
        load_config(write(tmp_path, text), Tuning)
    assert "tuning.yaml" in str(caught.value) and "\n" not in str(caught.value)


def test_a_missing_file_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="nix.yaml: cannot be read"):
        load_config(tmp_path / "nix.yaml", Tuning)


def test_the_description_holds_unit_and_open_bounds() -> None:
    field = Tuning.__dataclass_fields__["gain"]
    assert describe(field) == "Gain of the loop. (unit: 1/s; > 0, <= 1)"


def test_the_prefix_stands_before_our_three_frames_only() -> None:
    frames = FrameConfig(frame_prefix="r2/")
    assert (frames.map, frames.odom, frames.base) == ("r2/map", "r2/odom", "r2/base_link")
    assert FrameConfig().odom == "odom"
    assert FrameConfig(odom_frame="/odom").odom == "odom"
    with pytest.raises(ValueError, match="base_frame must not be empty"):
        FrameConfig(base_frame="")
