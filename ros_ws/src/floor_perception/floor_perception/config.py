"""Every value of floor and marker detection; a default stands here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate


@dataclass(frozen=True, kw_only=True)
class ColorConfig:
    """The floor's color: how it is learned and what counts as it."""

    file: str = param(
        "", "YAML of a floor color to start with; empty learns it from the first image.",
        read_only=True,
    )  # fmt: skip
    gate_sd: float = param(4.0, "A color within so many deviations is the floor's.", gt=0.0)
    min_sd: float = param(
        0.012, "Smallest deviation of the chromaticities, so that an even floor has some.", gt=0.0
    )
    darker: float = param(
        0.4, "The floor in shadow is at least this part as bright as around the robot.",
        gt=0.0, le=1.0,
    )  # fmt: skip
    brighter: float = param(
        1.8, "The floor in light is at most so many times as bright as around the robot.", ge=1.0
    )
    glare_share: float = param(
        0.5,
        "A direction is not seen if in the cell that ends it more than this share of what is not "
        "floor is saturated in all channels; 1 takes glare for an obstacle.",
        gt=0.0, le=1.0,
    )  # fmt: skip
    ring_m: float = param(
        0.15, "Width of the ring on the floor, from range_min_m on, that shows the floor's color.",
        unit="m", gt=0.0,
    )  # fmt: skip
    ring_share: float = param(
        0.5, "The floor's color is learned and followed only if this share of the ring has it.",
        gt=0.0, le=1.0,
    )  # fmt: skip
    look_s: float = param(0.1, "Time between looks at the ring.", unit="s", ge=0.0)
    adapt_s: float = param(
        5.0, "Time constant with which the color follows the light; 0 keeps it.", unit="s", ge=0.0
    )
    relearn_s: float = param(
        1.0, "Learned anew when the whole ring has had one other color for so long; 0 never.",
        unit="s", ge=0.0,
    )  # fmt: skip
    relearn_looks: int = param(
        5, "And in so many looks in a row, however slow the camera is.", ge=1, le=1000
    )
    relearn_share: float = param(
        0.9, "Share of the ring that must agree on the other color: more than obstacles cover.",
        gt=0.5, le=1.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class MaskConfig:
    """From colors to the floor region (floor paper, 3.1, step 1)."""

    speck_px: int = param(
        3, "Opening, after the closing: specks of floor that hold no square of this edge are none.",
        unit="px", ge=1, le=31,
    )  # fmt: skip
    mark_m: float = param(
        0.02,
        "Closing: lines and stains up to this width are floor; the kernel is as wide as that in "
        "pixels at range_min_m.",
        unit="m", ge=0.0, le=0.5,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class TemplateConfig:
    """The template of I x J cells (floor paper, 3.1, step 2)."""

    num_rings: int = param(36, "I, cells along a direction.", ge=1, le=1000)
    num_directions: int = param(180, "J, directions.", ge=4, le=3600)
    spacing: str = param(
        "image", "Rings of equal image radius, as published, or of equal distance on the floor.",
        choices=("image", "floor"),
    )  # fmt: skip
    range_min_m: float = param(
        0.17, "Where the first ring begins: the robot's body must end before.", unit="m", gt=0.0
    )
    horizon_m: float = param(2.5, "Where the last ring ends.", unit="m", gt=0.0)
    free_share: float = param(
        0.6, "r_th, share of floor from which on a cell is free.", gt=0.0, le=1.0
    )
    has_borders: bool = param(
        False, "Leave a line between cells out, as labelling needs it; they count without it."
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.horizon_m <= self.range_min_m:
            raise ValueError(
                f"horizon_m must be > range_min_m = {self.range_min_m:g}, got {self.horizon_m:g}"
            )


@dataclass(frozen=True, kw_only=True)
class FloorDetectorConfig:
    """Floor region and free space of an omnidirectional image."""

    color: ColorConfig = ColorConfig()
    mask: MaskConfig = MaskConfig()
    template: TemplateConfig = TemplateConfig()

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class CameraNodeConfig:
    """The camera that a node sees with."""

    camera_model: str = param(
        "soccer_small_size", "YAML of the camera, or the name of one of the package.",
        read_only=True,
    )  # fmt: skip
    hidden_mask: str = param(
        "", "Picture as large as the images whose black pixels see the robot; empty for none.",
        read_only=True,
    )  # fmt: skip
    image_transport: str = param(
        "raw", "Whether images come as Image or, on <topic>/compressed, as CompressedImage.",
        choices=("raw", "compressed"), read_only=True,
    )  # fmt: skip
    floor_frame: str = param(
        "omni_camera_floor", "Frame below the camera on the floor, without the prefix.",
        read_only=True,
    )  # fmt: skip
    image_timeout_s: float = param(0.5, "Silence of the camera allowed.", unit="s", gt=0.0)

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class FloorNodeConfig:
    """The node `floor_detector`."""

    publish_tf: bool = param(
        True,
        "Send base_frame -> floor_frame from the camera's YAML if /tf_static does not have it.",
        read_only=True,
    )
    publish_tf_after_s: float = param(
        7.0, "How long /tf_static must be silent about floor_frame before it is sent.",
        unit="s", ge=0.0, read_only=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)


@dataclass(frozen=True, kw_only=True)
class MarkerNodeConfig:
    """The node `marker_detector`."""

    colors: str = param(
        "soccer", "YAML of the classes of color, or the name of one of the package.",
        read_only=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        validate(self)
