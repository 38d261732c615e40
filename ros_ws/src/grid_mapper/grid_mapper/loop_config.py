"""Values of loop closing; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class LoopConfig:
    """Loop closing: the pose graph, where loops are looked for, and when one is believed."""

    node_distance_m: float = param(
        0.3,
        "A scan becomes a node of the graph when the robot moved this far.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    node_turn_rad: float = param(
        0.4,
        "A scan becomes a node when the robot turned this far.",
        unit="rad", gt=0.0, read_only=True,
    )  # fmt: skip
    recent_scans: int = param(
        60,
        "Key scans that the next ones are matched to; older ones come in by loops.",
        ge=5, read_only=True,
    )  # fmt: skip
    drift_m: float = param(
        0.01,
        "Error of the motion between two nodes beside what the match says.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    drift_rad: float = param(
        0.003,
        "Error of the turn between two nodes beside what the match says.",
        unit="rad", gt=0.0, read_only=True,
    )  # fmt: skip
    search_distance_m: float = param(
        0.5,
        "Loops are looked for each time the robot has moved this far.",
        unit="m", ge=0.0, read_only=True,
    )  # fmt: skip
    min_way_m: float = param(
        10.0,
        "A place left by less way than this is no loop.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    reach_m: float = param(
        2.0,
        "Places this far apart show the same walls.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    max_search_m: float = param(
        8.0,
        "No loop is looked for further off than this.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    max_candidates: int = param(
        3,
        "Places compared at a time, at most.",
        ge=1, read_only=True,
    )  # fmt: skip
    max_scans_a_place: int = param(
        12,
        "Key scans kept of one place (half a meter, about one way): older nodes stay in the graph "
        "without theirs.",
        ge=2, read_only=True,
    )  # fmt: skip
    submap_nodes: int = param(
        6,
        "Nodes to each side that make up a place.",
        ge=1, read_only=True,
    )  # fmt: skip
    min_overlap: float = param(
        0.5,
        "A loop of a smaller share of the points is refused.",
        ge=0.0, le=1.0, read_only=True,
    )  # fmt: skip
    min_agreement: float = param(
        0.6,
        "A loop whose pairs fit worse (mean weight) is refused.",
        ge=0.0, le=1.0, read_only=True,
    )  # fmt: skip
    max_contradiction: float = param(
        0.15,
        "A loop in which more of the points are seen through is refused.",
        ge=0.0, le=1.0, read_only=True,
    )  # fmt: skip
    max_second_peak: float = param(
        0.9,
        "A loop that fits elsewhere by this share as well is ambiguous, and refused.",
        gt=0.0, le=1.0, read_only=True,
    )  # fmt: skip
    sure_sigma_m: float = param(
        0.3,
        "Where the graph is less certain than this, a loop needs a second one that agrees.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    max_difference_m: float = param(
        1.8,
        "Where the graph is less certain than that, places whose walls are on average by more "
        "farther or nearer than here are not compared.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    agree_m: float = param(
        0.3,
        "Two loops that differ by more do not agree.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    agree_rad: float = param(
        0.05,
        "The same, of their turns.",
        unit="rad", gt=0.0, read_only=True,
    )  # fmt: skip
    loop_sigma_m: float = param(
        0.02,
        "Error of a loop beside what its match says.",
        unit="m", gt=0.0, read_only=True,
    )  # fmt: skip
    loop_sigma_rad: float = param(
        0.004,
        "Error of a loop's turn beside what its match says.",
        unit="rad", gt=0.0, read_only=True,
    )  # fmt: skip
    kernel: float = param(
        2.0,
        "A loop this many deviations off counts half (Cauchy).",
        unit="deviations", gt=0.0, read_only=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
