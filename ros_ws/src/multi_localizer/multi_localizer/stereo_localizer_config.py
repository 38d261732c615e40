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
