"""Every value of the stereo localizer; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate
from multi_localizer.stereo_view import VIEW_COLUMNS, VIEW_ROWS

METHODS = ("published", "ours", "color_only")
"""Names of the methods, as `StereoLocalizerConfig.method` takes them."""


@dataclass(frozen=True, kw_only=True)
class StereoLocalizerConfig:
    """How views of stereo pairs are held against a voxel map."""

    method: str = param(
        "ours", "The paper's search, the best of ours, or the paper's search by color alone.",
        choices=METHODS, read_only=True,
    )  # fmt: skip
    distance_weight: float = param(
        0.3, "published: what 1 m counts in eq. 1 beside normalized colors.", unit="1/m", ge=0.0
    )
    mesh_cells: int = param(
        32, "published: squares of the first mesh along x and y.", ge=1, le=256, read_only=True
    )
    num_headings: int = param(
        16, "published: headings of the first mesh.", ge=4, le=128, read_only=True
    )
    num_kept: int = param(100, "published: how many candidates stay of each stage.", ge=1, le=10000)
    view_columns: tuple[int, ...] = param(
        (1, 5, 20, 80, 320), "published: columns of the views, stage by stage.", unit="px", ge=1,
        read_only=True,
    )  # fmt: skip
    view_rows: tuple[int, ...] = param(
        (1, 1, 2, 4, 8), "published: their rows.", unit="px", ge=1, read_only=True
    )
    alike_score: float = param(
        0.01, "published, color_only: places alike by eq. 1 within this are not told apart.", gt=0.0
    )
    lost_score: float = param(
        0.25, "published, color_only: where eq. 1 is more, the robot is not there.", gt=0.0
    )
    mesh_error_m: float = param(
        0.03, "published: standard deviation of x and y; color_only: ten times this.", unit="m",
        gt=0.0,
    )  # fmt: skip
    mesh_error_rad: float = param(
        0.015, "published: standard deviation of yaw; color_only: ten times this.", unit="rad",
        gt=0.0,
    )  # fmt: skip
    panorama_spacing_m: float = param(
        0.08, "ours: between the places of the global search.", unit="m", gt=0.0, read_only=True
    )
    max_places: int = param(
        20000, "ours: in a larger map places are farther apart, so many at most.", ge=1,
        le=1000000, read_only=True,
    )  # fmt: skip
    panorama_columns: int = param(
        128, "ours: headings of the global search.", ge=16, le=1024, read_only=True
    )
    panorama_rows: int = param(
        4, "ours: rows that the views have in the global search.", ge=1, le=64, read_only=True
    )
    search_color: float = param(
        0.1, "ours: a cell of a color that is off by this, of 1, is all wrong in the search.",
        gt=0.0,
    )  # fmt: skip
    search_inverse_per_m: float = param(
        0.15, "ours: a cell whose inverse distance is off by this is all wrong in the search.",
        unit="1/m", gt=0.0,
    )  # fmt: skip
    num_refined: int = param(
        40, "ours: poses of the global search that are refined.", ge=1, le=1000
    )
    max_hypotheses: int = param(
        6, "ours: poses that may be the robot's, kept at once.", ge=1, le=100
    )
    color_error: float = param(0.1, "ours: a color off by this, of 1, is half wrong.", gt=0.0)
    inverse_error_per_m: float = param(
        0.02, "ours: an inverse distance off by this is half wrong.", unit="1/m", gt=0.0
    )
    map_error_m: float = param(
        0.01, "ours: a place off by this is half wrong, besides.", unit="m", ge=0.0
    )
    fit_color: float = param(
        0.1, "ours: what color counts where a pose is fitted; distance counts the rest.", ge=0.0,
        le=1.0,
    )  # fmt: skip
    judge_color: float = param(
        0.5, "ours: what color counts where poses are held against each other.", ge=0.0, le=1.0
    )
    evidence: float = param(
        500.0, "ours: how much surer a pose is whose mean cost is less by 1, as a logarithm, where "
        "costs are small; see usual_cost.", gt=0.0,
    )  # fmt: skip
    usual_cost: float = param(
        0.05, "ours: mean cost of a good map's views; where all poses cost more, ratios count.",
        gt=0.0,
    )  # fmt: skip
    least_error_m: float = param(
        0.003, "ours: standard deviation of x and y at least.", unit="m", gt=0.0
    )
    least_error_rad: float = param(
        0.002, "ours: standard deviation of yaw at least.", unit="rad", gt=0.0
    )
    same_m: float = param(0.15, "ours: poses nearer to each other are one.", unit="m", gt=0.0)
    same_rad: float = param(0.15, "ours: see same_m.", unit="rad", gt=0.0)
    settle_share: float = param(
        0.95, "ours: a pose with this share of the belief is known.", gt=0.5, lt=1.0
    )
    least_share: float = param(
        0.001, "ours: a pose with less of the belief is dropped.", ge=0.0, lt=0.5
    )
    lost_cost: float = param(
        0.4, "ours: where more of the views is wrong, of 1, the robot is not there.", gt=0.0, le=1.0
    )
    least_seen: float = param(
        0.1, "Views with distances in a smaller part, of 1, say nothing.", ge=0.0, le=1.0
    )
    lost_after_s: float = param(
        1.0, "ours: a robot whose views fit nowhere near is lost after this time.", unit="s", ge=0.0
    )
    locate_period_s: float = param(
        0.5, "ours: time between global searches of a lost robot.", unit="s", ge=0.0
    )
    near_sd: float = param(
        3.0, "A pose told by initialpose may be off by so many of its deviations.", gt=0.0
    )
    odometry_error: float = param(
        0.1, "ours: standard deviation of odometry, of 1.", ge=0.0, le=1.0
    )
    drift_m_s: float = param(0.02, "ours: what a pose may drift besides.", unit="m/s", ge=0.0)
    drift_rad_s: float = param(0.02, "ours: what a yaw may drift besides.", unit="rad/s", ge=0.0)
    free_speed_m_s: float = param(
        1.0, "ours: how fast the robot may go, where there is no odometry.", unit="m/s", ge=0.0
    )
    free_turn_rad_s: float = param(
        1.0, "ours: how fast it may turn, where there is no odometry.", unit="rad/s", ge=0.0
    )
    slip_sd: float = param(
        3.0, "ours: odometry is not believed where views are off it by so many deviations.", gt=0.0
    )
    renewal_s: float = param(
        0.5, "ours: time in which the views of a standing robot take the place of older ones.",
        unit="s", gt=0.0,
    )  # fmt: skip
    new_view_m: float = param(
        0.2, "ours: a way after which a view is as good as new.", unit="m", gt=0.0
    )
    new_view_rad: float = param(
        0.3, "ours: a turn after which a view is as good as new.", unit="rad", gt=0.0
    )

    def __post_init__(self) -> None:
        validate(self)
        if len(self.view_columns) != len(self.view_rows) or not self.view_columns:
            raise ValueError(
                "view_columns and view_rows must be of one length, got "
                f"{self.view_columns} and {self.view_rows}"
            )
        if any(VIEW_COLUMNS % c for c in self.view_columns):
            raise ValueError(f"view_columns must divide {VIEW_COLUMNS}, got {self.view_columns}")
        if any(VIEW_ROWS % r for r in self.view_rows):
            raise ValueError(f"view_rows must divide {VIEW_ROWS}, got {self.view_rows}")
