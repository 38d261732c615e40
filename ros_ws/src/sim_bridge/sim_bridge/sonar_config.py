"""Settings of a ring of ultrasonic rangers, each with unit and range."""

from __future__ import annotations

from dataclasses import dataclass

from floornav_common.config import param, validate
from sim_bridge.config import STEP_S


@dataclass(frozen=True, kw_only=True)
class SonarConfig:
    """Ultrasonic rangers on one robot, on the links `<frame>0`, `<frame>1` ... of its URDF.

    The figures are those of the common 50 kHz rangers of indoor robots: an opening of 20 degrees
    (the glass paper's, section 7.1), and walls so smooth beside the wavelength of 7 mm that they
    are mirrors beyond a small angle; books and clothes are not.
    """

    count: int = param(16, "Number of sonars.", ge=1, le=64)
    frame: str = param("sonar_", "Links of the URDF, followed by the sonar's number.")
    period_s: float = param(0.2, "Time in which every sonar fires once.", unit="s", gt=0.0)
    groups: tuple[tuple[int, ...], ...] = param(
        (), "Sonars that fire together, in firing order; () = one after the other."
    )
    opening_rad: float = param(0.349066, "Full angle of the cone.", unit="rad", gt=0.0, le=2.0)
    listening_rad: float = param(
        1.05, "Full angle in which it hears the echoes of others.", unit="rad", gt=0.0, le=3.1
    )
    rays_across: int = param(15, "Rays across the cone, odd.", ge=1, le=101)
    range_min_m: float = param(0.15, "Nearer echoes are -inf.", unit="m", ge=0.0)
    range_max_m: float = param(5.0, "Farther echoes are +inf.", unit="m", gt=0.0)
    critical_rad: float = param(
        0.2618, "Angle of incidence beyond which smooth surfaces reflect like mirrors; rough ones "
        "and cloth answer farther from their normal (`sim_bridge/surfaces.py`).", unit="rad",
        gt=0.0, lt=1.5708,
    )  # fmt: skip
    critical_sd_rad: float = param(
        0.035, "Deviation of that angle from firing to firing.", unit="rad", ge=0.0, le=0.5
    )
    noise_sd_m: float = param(0.005, "Deviation of a range.", unit="m", ge=0.0)
    noise_sd_share: float = param(0.005, "Deviation of a range, in shares of it, added.", ge=0.0)
    quantum_m: float = param(0.01, "Step of the ranges; 0 = exact.", unit="m", ge=0.0)
    miss_share: float = param(0.01, "Share of firings without any echo: +inf.", ge=0.0, le=1.0)

    def __post_init__(self) -> None:
        validate(self)
        if self.rays_across % 2 == 0:
            raise ValueError(f"rays_across must be odd, got {self.rays_across}")
        if self.range_max_m <= self.range_min_m:
            raise ValueError(
                f"range_max_m must be > range_min_m = {self.range_min_m}, got {self.range_max_m}"
            )
        slot_s = self.period_s / len(self.firing_order)
        if slot_s < STEP_S - 1e-9:
            raise ValueError(
                f"period_s must give each of {len(self.firing_order)} slots >= {STEP_S:g} s, a "
                f"step of the simulation, got {slot_s:g} s"
            )
        named = sorted(k for group in self.groups for k in group)
        if self.groups and (named != list(range(self.count)) or not all(self.groups)):
            raise ValueError(f"groups must name each of 0..{self.count - 1} once, got {named}")

    @property
    def firing_order(self) -> tuple[tuple[int, ...], ...]:
        """The sonars of each slot of the period."""
        return self.groups or tuple((k,) for k in range(self.count))
