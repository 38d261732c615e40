"""What things are made of, to sound and to a laser's light.

Sound of 7 mm waves is mirrored by what is smooth beside that (glass, plaster, boards) and sent to
every side by what is rough or soft: a surface answers up to the sonar's `critical_rad` plus its
own `rough_rad`. Light comes back from everything but glass to every side (Lambert), by its
reflectance in the near infrared. The figures are ours, in the range of what is reported: plaster
reflects about 0.8 there, wood and paper 0.5, cloth 0.4, black rubber and paint 0.05.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim_bridge.appearance import require_pattern


@dataclass(frozen=True)
class Surface:
    """A material.

    Attributes:
        rough_rad: How much farther from its normal than a smooth surface it answers sound.
        reflectance: Share of a laser's light that it sends back.
    """

    rough_rad: float
    reflectance: float


SURFACES = {
    "smooth": Surface(rough_rad=0.0, reflectance=0.8),  # plaster, paint, boards; glass to sound
    "dark": Surface(rough_rad=0.0, reflectance=0.05),  # as smooth, but black
    "rough": Surface(rough_rad=0.5236, reflectance=0.5),  # books, shelves, bricks, machines
    "cloth": Surface(rough_rad=1.0472, reflectance=0.4),  # sofas, beds, curtains, people
}
NAMES = tuple(SURFACES)
ROUGH_RAD = np.array([surface.rough_rad for surface in SURFACES.values()])
REFLECTANCE = np.array([surface.reflectance for surface in SURFACES.values()])
_ROUGH_TEXTURES = ("books", "bricks")


def surface_of(named: str, texture: str = "", usual: str = "smooth") -> str:
    """Return the material of a thing: as it is named, else as its texture says, else as usual."""
    return named or ("rough" if texture in _ROUGH_TEXTURES else usual)


def require_looks(texture: str, surface: str) -> None:
    """Check the names of a texture and of a material; "" leaves either to the kind of thing.

    Raises:
        ValueError: There is none of that name.
    """
    require_pattern(texture)
    if surface and surface not in SURFACES:
        raise ValueError(f"surface must be one of {', '.join(SURFACES)}, got {surface!r}")
