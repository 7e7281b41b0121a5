"""The simulated optics: from the sheet's shape to the image a camera takes of it."""

from sim_hardware.optics.marker import read_marker, write_marker
from sim_hardware.optics.renderer import Contact, Renderer
from sim_hardware.optics.settings import (
    CameraNoise,
    FarFace,
    Jaws,
    Lens,
    Light,
    OpticsSettings,
    Rolls,
    Spot,
)

__all__ = [
    "CameraNoise",
    "Contact",
    "FarFace",
    "Jaws",
    "Lens",
    "Light",
    "OpticsSettings",
    "Renderer",
    "Rolls",
    "Spot",
    "read_marker",
    "write_marker",
]
