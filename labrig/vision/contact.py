"""Where the rolls touch the sheet, from the picture: a check on the stage's position."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from labrig.vision.curve import NeutralCurve
from labrig.vision.optics import Optics


@dataclass(frozen=True)
class Contact:
    """The contact as the picture shows it, in the world."""

    s_m: float  # along the sheet
    x_m: float
    y_m: float
    angle_rad: float  # of the sheet's tangent there
    radius_m: float  # distance from the clamp, to compare with the arc's


def contact_from_picture(curve: NeutralCurve, optics: Optics) -> Contact | None:
    """The point of the curve between the rolls named in the optics; None without rolls.

    With two rolls it is nearest to the middle of their centres, with one nearest to its centre.
    """
    if not curve.ok or not optics.rolls_px:
        return None
    centres = np.array([(u, v) for u, v, _ in optics.rolls_px])
    middle = optics.pixel_to_world(centres).mean(axis=0)
    dx, dy = curve.x_m - middle[0], curve.y_m - middle[1]
    nearest = int(np.argmin(dx**2 + dy**2))
    if math.hypot(dx[nearest], dy[nearest]) > 5e-3:
        return None
    low, high = max(0, nearest - 1), min(len(curve.s_m) - 1, nearest + 1)
    angle = math.atan2(curve.y_m[high] - curve.y_m[low], curve.x_m[high] - curve.x_m[low])
    # between two nodes: the foot of the middle on the tangent
    ahead = -(dx[nearest] * math.cos(angle) + dy[nearest] * math.sin(angle))
    ahead = float(np.clip(ahead, -0.5e-3, 0.5e-3))
    x = float(curve.x_m[nearest] + ahead * math.cos(angle))
    y = float(curve.y_m[nearest] + ahead * math.sin(angle))
    return Contact(float(curve.s_m[nearest]) + ahead, x, y, angle, math.hypot(x, y))
