"""Find where the rolls touch the sheet in the image: a check of the stage's position.

Two methods, of which the better one is reported: the rolls themselves where they are seen; else
the place where the curve crosses the arc, for the sheet always runs between the rolls, which are on
it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve
from labrig.vision.image.image import ImageError, read_grey_image
from labrig.vision.thresholds import NAMED_ROLLS_DISTANCE_MAX_M
from labrig.vision.tracking.rolls import Roll, find_rolls
from model.measurements import Contact

FloatArray = npt.NDArray[np.float64]

# how well the image knows where the clamp ends, along the sheet: its edge and the length
CLAMP_SIGMA_PX = 0.5
ARC_SIGMA_M = 0.1e-3  # of the radius; a crossing at a slant moves with it


def contact_from_image(
    image: npt.NDArray[Any],
    curve: NeutralCurve,
    optics: Optics,
    arc_radius_m: float,
    arc_origin_rad: float = 0.0,
    *,
    expected_m: float | None = None,
) -> Contact | None:
    """Return the contact that `image`, whose neutral curve is `curve`, shows.

    None without a curve, or with one that does not come as far as the arc. Angles on the arc are
    counted about the place where the curve begins, which is the clamp as the image shows it.
    `expected_m`: the position on the arc as the stage has it; it only chooses where a sheet that
    curls crosses the arc more than once.
    """
    if not curve.ok:
        return None
    seat = _RollSeat(curve, optics, arc_radius_m, arc_origin_rad)
    crossings = [seat.crossing(at) for at in seat.crossings()]
    if not crossings:
        return None
    if expected_m is not None:
        crossings.sort(key=lambda c: abs(c.position_m - expected_m))
    try:
        grey_image = read_grey_image(image, optics)
    except ImageError:
        return None
    for crossing in crossings:
        rolls = _named(optics, crossing) or find_rolls(grey_image, curve, optics, crossing.s_m)
        if rolls is not None:
            return seat.between(rolls)
    return crossings[0]


def _named(optics: Optics, crossing: Contact) -> tuple[Roll, Roll] | None:
    """Return the two rolls that the optics name, where they are beside the curve near the arc."""
    if optics.rolls_px is None or len(optics.rolls_px) != 2:
        return None
    table = np.array(optics.rolls_px)
    centres = optics.pixel_to_world(table[:, :2])
    if math.dist(centres.mean(axis=0), (crossing.x_m, crossing.y_m)) > NAMED_ROLLS_DISTANCE_MAX_M:
        return None
    sigma = 1.0 / optics.px_per_m  # a person's reading
    first, second = (
        Roll(float(x), float(y), float(radius) / optics.px_per_m, sigma)
        for (x, y), radius in zip(centres, table[:, 2], strict=True)
    )
    return first, second


class _RollSeat:
    """A curve and the arc it crosses."""

    def __init__(
        self, curve: NeutralCurve, optics: Optics, radius_m: float, origin_rad: float
    ) -> None:
        self.curve, self.optics = curve, optics
        self.radius_m, self.origin_rad = radius_m, origin_rad
        self.angles = np.unwrap(np.arctan2(np.gradient(curve.y_m), np.gradient(curve.x_m)))

    def crossings(self) -> list[float]:
        """Return the fractional indices where the curve crosses the arc's circle, last first."""
        curve = self.curve
        away = np.hypot(curve.x_m - curve.x_m[0], curve.y_m - curve.y_m[0]) - self.radius_m
        at = np.flatnonzero((away[:-1] < 0) != (away[1:] < 0))[::-1]
        return [float(i + away[i] / (away[i] - away[i + 1])) for i in at]

    def between(self, rolls: tuple[Roll, Roll]) -> Contact:
        """Return the contact of two rolls: their middle, and the curve's point nearest to it."""
        first, second = rolls
        apart = math.hypot(second.x_m - first.x_m, second.y_m - first.y_m)
        share = 0.5 + 0.5 * (first.radius_m - second.radius_m) / apart
        x = first.x_m + share * (second.x_m - first.x_m)
        y = first.y_m + share * (second.y_m - first.y_m)
        sigma = math.hypot(first.sigma_m, second.sigma_m) / 2
        circles = tuple((roll.x_m, roll.y_m, roll.radius_m) for roll in rolls)
        return self._contact(x, y, sigma, self._foot(x, y), circles)

    def crossing(self, at: float) -> Contact:
        """Return the contact where the curve crosses the arc."""
        curve, nodes = self.curve, np.arange(len(self.curve.s_m))
        x, y, sigma, angle = (
            float(np.interp(at, nodes, values))
            for values in (curve.x_m, curve.y_m, curve.sigma_m, self.angles)
        )
        # seen from the clamp the curve crosses the arc at a slant, so errors slide along it
        slant = angle - math.atan2(y - curve.y_m[0], x - curve.x_m[0])
        steep = max(abs(math.cos(slant)), 0.1)
        sideways = math.hypot(sigma, ARC_SIGMA_M * math.sin(slant)) / steep
        return self._contact(x, y, sideways, at, ())

    def _foot(self, x: float, y: float) -> float:
        """Return fractional index of the curve's point nearest to (x, y)."""
        dx, dy = x - self.curve.x_m, y - self.curve.y_m
        i = int(np.argmin(dx**2 + dy**2))
        along = dx[i] * math.cos(self.angles[i]) + dy[i] * math.sin(self.angles[i])
        step = float(np.diff(self.curve.s_m).mean())
        return float(np.clip(i + along / step, 0, len(self.curve.s_m) - 1))

    def _contact(
        self,
        x: float,
        y: float,
        sigma_m: float,
        at: float,
        rolls: tuple[tuple[float, float, float], ...],
    ) -> Contact:
        curve, nodes = self.curve, np.arange(len(self.curve.s_m))
        dx, dy = x - float(curve.x_m[0]), y - float(curve.y_m[0])
        polar, away = math.atan2(dy, dx), math.hypot(dx, dy)
        turn = math.remainder(polar - self.origin_rad, 2 * math.pi)
        start = CLAMP_SIGMA_PX / self.optics.px_per_m * math.sin(polar)
        level = float(curve.sigma_m[0]) * math.cos(polar)
        on_arc = math.sqrt(sigma_m**2 + start**2 + level**2) * self.radius_m / away
        return Contact(
            s_m=float(np.interp(at, nodes, curve.s_m)),
            x_m=x,
            y_m=y,
            angle_rad=float(np.interp(at, nodes, self.angles)),
            position_m=self.radius_m * turn,
            position_sigma_m=math.hypot(on_arc, self.radius_m * self.optics.roll_sigma_rad),
            radius_m=away,
            rolls_m=rolls,
        )
