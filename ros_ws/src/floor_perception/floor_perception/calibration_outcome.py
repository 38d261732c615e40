"""What a calibration is told of the picture, and what it hands back."""

from __future__ import annotations

from dataclasses import dataclass, field

from floor_perception.fit_statistics import FitStatistics
from floornav_common.cameras.central import CentralCamera
from floornav_common.floor_camera import FloorCamera

LARGE_RMS_PX = 1.0
WIDE_SHARE = 0.2
"""Half an interval's width beside the value, above which the value means little."""


@dataclass
class Outcome:
    """What a calibration found.

    Attributes:
        camera: The camera; over the floor where its height is known.
        statistics: Of its parameters.
        rms_px: Of the residuals.
        derived: Statistics of what follows from the parameters, as A, B and C.
        header: Of `rows`.
        rows: A table for the user: what the fit says where.
        warnings: What the user should know before the camera is used.
        files: Pictures by file name, PNG.
        captions: Of the pictures.
        values: More for the summary.
    """

    camera: CentralCamera | FloorCamera
    statistics: FitStatistics
    rms_px: float
    derived: FitStatistics | None = None
    header: list[str] = field(default_factory=list)
    rows: list[list[float | str | None]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    files: dict[str, bytes] = field(default_factory=dict)
    captions: dict[str, str] = field(default_factory=dict)
    values: dict[str, object] = field(default_factory=dict)

    def add_picture(self, name: str, content: bytes, caption: str) -> None:
        """Keep a picture."""
        self.files[name], self.captions[name] = content, caption


@dataclass(frozen=True, kw_only=True)
class ViewOptions:
    """What the user says of the picture.

    Attributes:
        size_px: Width and height.
        center_px: The optical axis; None: found, or the middle.
        max_radius_px: Edge of the view; None: found, or the farthest measurement.
        looks: Where the camera looks.
        center_sd_px: How well each coordinate of the center is known; 0: exactly.
    """

    size_px: tuple[int, int]
    center_px: tuple[float, float] | None = None
    max_radius_px: float | None = None
    looks: str = "mirror_above"
    center_sd_px: float = 0.0

    @property
    def middle_px(self) -> tuple[float, float]:
        """The center given, or the image's middle."""
        if self.center_px is not None:
            return self.center_px
        return (self.size_px[0] - 1) / 2.0, (self.size_px[1] - 1) / 2.0


def warn_of_fit(outcome: Outcome) -> None:
    """Add warnings where parameters trade off or residuals are large."""
    s = outcome.statistics
    if s.is_nearly_degenerate:
        wide = [
            n for n, v, h in zip(s.names, s.values, s.half_widths, strict=True)
            if h > WIDE_SHARE * abs(v)
        ]  # fmt: skip
        if wide:
            outcome.warnings.append(
                f"nearly degenerate (condition {s.condition:.0f}): {', '.join(wide)} trade off "
                "against others; single values mean little, and none beyond what was measured"
            )
    if outcome.rms_px > LARGE_RMS_PX:
        outcome.warnings.append(f"residuals of {outcome.rms_px:.2f} px (RMS) are large")


def report_lines(outcome: Outcome) -> list[str]:
    """Return what is printed, and stands above the camera file."""
    s = outcome.statistics
    lines = [f"{'parameter':<14}{'value':>12}{'95 % +-':>12}"]
    for own in (s, outcome.derived):
        if own is not None:
            rows = zip(own.names, own.values, own.half_widths, strict=True)
            lines += [f"{name:<14}{v:>12.5g}{h:>12.2g}" for name, v, h in rows]
    lines += [f"residuals: {outcome.rms_px:.3f} px RMS, {s.dof} degrees of freedom"]
    width = max([8, *(len(str(row[0])) for row in outcome.rows if isinstance(row[0], str))]) + 2
    lines.append("".join(f"{h:>{width if k == 0 else 13}}" for k, h in enumerate(outcome.header)))
    for row in outcome.rows:
        cells = ["-" if c is None else f"{c:.4g}" if isinstance(c, float) else str(c) for c in row]
        lines.append("".join(f"{c:>{width if k == 0 else 13}}" for k, c in enumerate(cells)))
    return lines
