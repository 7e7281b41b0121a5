"""The constant parts of a frame: the jaws, the light, the reflections."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim_hardware.optics.geometry import FloatArray, Geometry
from sim_hardware.optics.settings import OpticsSettings

Picture = npt.NDArray[np.float32]


def light_gain(settings: OpticsSettings) -> Picture:
    """Relative brightness of each pixel (rows, columns)."""
    columns, rows = settings.image_size
    across = np.linspace(-1, 1, columns)[None, :]
    down = np.linspace(-1, 1, rows)[:, None]
    light = settings.light
    gain = 1 - light.vignetting * (across**2 + down**2) / 2
    gain = gain * (1 + light.gradient[0] / 2 * across + light.gradient[1] / 2 * down)
    return gain.astype(np.float32)


def glare(settings: OpticsSettings) -> Picture:
    """Grey levels that the reflections add (rows, columns)."""
    columns, rows = settings.image_size
    v, u = np.mgrid[0:rows, 0:columns]
    added = np.zeros((rows, columns))
    for spot in settings.spots:
        distance2 = (u - spot.at_px[0]) ** 2 + (v - spot.at_px[1]) ** 2
        added += spot.level * np.exp(-distance2 / (2 * spot.radius_px**2))
    return added.astype(np.float32)


@dataclass(frozen=True)
class Patch:
    """A part of one grey level that lies over the image."""

    where: tuple[slice, slice]
    coverage: Picture
    level: float

    def draw(self, frame: Picture) -> None:
        """Lay it over a frame (rows, columns)."""
        frame[self.where] += self.coverage * (np.float32(self.level) - frame[self.where])


def jaws(settings: OpticsSettings, geometry: Geometry) -> Patch | None:
    """Return the image of the clamp; None where it is not visible."""
    clamp = settings.jaws
    if not clamp.visible:
        return None
    columns, rows = settings.image_size
    v, u = np.mgrid[0:rows, 0:columns]
    from_clamp = np.stack((u, v), axis=-1) - geometry.to_pixels([[0.0, 0.0]])[0]
    along = from_clamp @ geometry.turned(clamp.angle_rad)
    across = np.abs(from_clamp @ geometry.turned(clamp.angle_rad + np.pi / 2))
    length, half_height = clamp.length_m * geometry.px_per_m, clamp.height_m * geometry.px_per_m / 2
    coverage = _soft(-along) * _soft(along + length) * _soft(half_height - across)
    lines, places = np.nonzero(coverage)
    if len(lines) == 0:
        return None
    where = slice(lines.min(), lines.max() + 1), slice(places.min(), places.max() + 1)
    return Patch(where, coverage[where].astype(np.float32), clamp.level)


def _soft(depth_px: FloatArray) -> FloatArray:
    """Coverage of a pixel whose centre lies this deep inside a straight edge."""
    return np.clip(depth_px + 0.5, 0.0, 1.0)
