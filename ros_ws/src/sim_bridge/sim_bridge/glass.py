"""Glass as a material: what a world file says of it, and what it does to light (Fresnel).

Defaults are those of clear float glass in the near infrared of laser range finders (905 nm):
its iron takes up more there than in the visible, so 8 mm let about 80 % through (acrylic 92 %).
A pane shines back like a mirror: a laser sees it only within a few degrees of the normal, and
dirt sends a small share of the beams back from the pane or from just behind it (glass paper,
section 4.1 and Fig. 4a). The figures of these two are not in the paper; they are parameters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Glass:
    """A pane's material.

    Attributes:
        thickness_m: Of the pane.
        refractive_index: 1.52 float glass, 1.49 acrylic.
        transmission: Share of light that crosses a pane along its normal, reflections included.
        scatter_share: Share of beams that dirt sends back, along the normal; more at a slant.
        scatter_fixed_share: Share of those that stay where they are: the same place of the pane
            sends back every beam, to the same range. The rest comes and goes from beam to beam.
        scatter_depth_m: Mean distance behind the pane at which those are measured.
        specular_share: Share of beams along the normal that the pane itself sends back.
        specular_half_width_deg: Angle of incidence at which that share has fallen to half.
    """

    thickness_m: float = 0.008
    refractive_index: float = 1.52
    transmission: float = 0.80
    scatter_share: float = 0.02
    scatter_fixed_share: float = 0.75
    scatter_depth_m: float = 0.10
    specular_share: float = 0.95
    specular_half_width_deg: float = 5.0

    def __post_init__(self) -> None:
        if not 0.0 < self.thickness_m <= 0.1:
            raise ValueError(f"thickness_m must be > 0, <= 0.1, got {self.thickness_m:g}")
        if not 1.0 < self.refractive_index <= 3.0:
            raise ValueError(f"refractive_index must be > 1, <= 3, got {self.refractive_index:g}")
        most = float(_lossless(self.refractive_index, np.ones(1))[0])
        if not 0.0 < self.transmission <= most:
            raise ValueError(
                f"transmission must be > 0, <= {most:.4f} (its two faces reflect the rest), "
                f"got {self.transmission:g}"
            )
        for name in ("scatter_share", "scatter_fixed_share", "specular_share"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must be >= 0, <= 1, got {getattr(self, name):g}")
        if self.scatter_depth_m < 0.0 or not 0.0 < self.specular_half_width_deg <= 45.0:
            raise ValueError("scatter_depth_m must be >= 0, specular_half_width_deg > 0, <= 45")


@dataclass(frozen=True, kw_only=True)
class Frame:
    """What holds panes: upright posts at both ends and between, and rails below and above.

    Attributes:
        spacing_m: Distance from post to post, middle to middle; 0 = posts at the ends only.
        width_m: Of a post, along the pane.
        depth_m: Of posts and rails, across the pane.
        rail_m: Height of each rail; 0 = none.
        color: RGB, 0..1.
    """

    spacing_m: float = 0.0
    width_m: float = 0.06
    depth_m: float = 0.06
    rail_m: float = 0.0
    color: tuple[float, float, float] = (0.45, 0.47, 0.50)

    def __post_init__(self) -> None:
        if not self.width_m > 0.0 or not self.depth_m > 0.0 or not self.rail_m >= 0.0:
            raise ValueError("a frame needs width_m > 0, depth_m > 0 and rail_m >= 0")
        if self.spacing_m != 0.0 and self.spacing_m <= self.width_m:
            raise ValueError(f"spacing_m must be 0 or > width_m, got {self.spacing_m:g}")


def transmittance(glass: Glass, cos_incidence: np.ndarray) -> np.ndarray:
    """Return the share of unpolarized light that crosses a pane, by angle of incidence.

    The two faces reflect by Fresnel's formulas, with all reflections inside the pane added up
    without interference; the rest of the loss grows with the way inside the pane.

    Args:
        glass: The pane.
        cos_incidence: Cosine of the angle between ray and normal, any shape, in [0, 1].
    """
    n = glass.refractive_index
    inside = glass.transmission / _lossless(n, np.ones(1))[0]
    way = 1.0 / _cos_inside(n, cos_incidence)
    return np.asarray(_lossless(n, cos_incidence) * inside**way)


def specular_probability(glass: Glass, cos_incidence: np.ndarray) -> np.ndarray:
    """Return the share of beams that the pane itself sends back, by angle of incidence."""
    angle = np.arccos(np.clip(cos_incidence, -1.0, 1.0))
    ratio = angle / math.radians(glass.specular_half_width_deg)
    return np.asarray(glass.specular_share * 0.5 ** (ratio**2))


def scatter_probability(glass: Glass, cos_incidence: np.ndarray) -> np.ndarray:
    """Return the share of crossing beams that dirt sends back: a slanted beam meets more of it."""
    slant = 1.0 / np.maximum(cos_incidence, 1e-3)
    return np.asarray(1.0 - (1.0 - glass.scatter_share) ** slant)


def optical_delay(glass: Glass, cos_incidence: np.ndarray) -> np.ndarray:
    """Return how much farther things behind a pane seem, m: light is slower in it."""
    n = glass.refractive_index
    return np.asarray(glass.thickness_m * (n * _cos_inside(n, cos_incidence) - cos_incidence))


def _cos_inside(n: float, cos_incidence: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(1.0 - (1.0 - cos_incidence**2) / n**2))


def _lossless(n: float, cos_incidence: np.ndarray) -> np.ndarray:
    """Return the transmittance of a slab that takes up nothing: mean of (1 - R) / (1 + R)."""
    c, t = cos_incidence, _cos_inside(n, cos_incidence)
    r_s = ((c - n * t) / (c + n * t)) ** 2
    r_p = ((t - n * c) / (t + n * c)) ** 2
    return np.asarray(0.5 * ((1.0 - r_s) / (1.0 + r_s) + (1.0 - r_p) / (1.0 + r_p)))
