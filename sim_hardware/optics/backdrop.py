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
    v, u = np.ogrid[0:rows, 0:columns]
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
    start_px = geometry.to_pixels([[0.0, 0.0]])[0]
    length, half_height = clamp.length_m * geometry.px_per_m, clamp.height_m * geometry.px_per_m / 2
    # No further than this: to look at all pixels takes 20 ms.
    left, top, right, bottom = _around(start_px, length + half_height + 1.0, settings.image_size)
    v, u = np.mgrid[top:bottom, left:right]
    from_clamp = np.stack((u, v), axis=-1) - start_px
    along = from_clamp @ geometry.turned(clamp.angle_rad)
    across = np.abs(from_clamp @ geometry.turned(clamp.angle_rad + np.pi / 2))
    coverage = _soft(-along) * _soft(along + length) * _soft(half_height - across)
    lines, places = np.nonzero(coverage)
    if len(lines) == 0:
        return None
    first, last = (lines.min(), places.min()), (lines.max() + 1, places.max() + 1)
    inside = slice(first[0], last[0]), slice(first[1], last[1])
    where = slice(top + first[0], top + last[0]), slice(left + first[1], left + last[1])
    return Patch(where, coverage[inside].astype(np.float32), clamp.level)


def _around(
    centre_px: FloatArray, reach_px: float, image_size: tuple[int, int]
) -> tuple[int, int, int, int]:
    """Return first and last (beyond) column and row that lie so near: left, top, right, bottom."""
    first = np.clip(np.floor(centre_px - reach_px), 0, image_size).astype(int)
    last = np.clip(np.ceil(centre_px + reach_px) + 1, 0, image_size).astype(int)
    return int(first[0]), int(first[1]), int(last[0]), int(last[1])


def _soft(depth_px: FloatArray) -> FloatArray:
    """Coverage of a pixel whose centre lies this deep inside a straight edge."""
    return np.clip(depth_px + 0.5, 0.0, 1.0)
