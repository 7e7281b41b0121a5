"""A camera calibration in the making: views of the board, and what came of them."""

from __future__ import annotations

import datetime as dt
import threading
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drivers.interfaces import GreyImage
from labrig.errors import BadInputError
from labrig.files import not_written
from labrig.panel.errors import MissingError, NotNowError
from labrig.panel.live.event_stream import Message
from labrig.vision import Calibration, CalibrationBoard, Optics, calibrate_camera, calibrate_ruler
from labrig.vision.calibration.carried import carried_over
from labrig.vision.calibration.corners import find_corners

Point = tuple[float, float]
MOST_VIEWS = 30


@dataclass(frozen=True)
class View:
    """A picture of the board."""

    image: GreyImage
    corners_px: list[Point]


class CameraCalibrationRun:
    """Kept while the panel lives; nothing is written before it is accepted."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._views: dict[int, View] = {}
        self._count = 0
        self.made: Calibration | None = None

    def add_view(self, image: GreyImage, board: CalibrationBoard) -> Message:
        """Keep a picture in which the board was found. Raises BadInputError."""
        with self._lock:
            if len(self._views) >= MOST_VIEWS:
                raise NotNowError(f"{MOST_VIEWS} views are kept already; remove some.")
        _, corners = find_corners(image, board, "the picture")
        points = [(float(u), float(v)) for u, v in corners]
        with self._lock:
            self._count += 1
            self._views[self._count] = View(image, points)
            rows, columns = image.shape
            number = self._count
        return {"view": number, "width": columns, "height": rows, "corners_px": points}

    def view(self, number: int) -> View:
        """Return a kept view. Raises MissingError."""
        found = self._views.get(number)
        if found is None:
            raise MissingError(f"there is no view {number}.")
        return found

    def remove(self, number: int) -> None:
        """Forget a view."""
        self.view(number)
        with self._lock:
            self._views.pop(number, None)

    def from_board(
        self, board: CalibrationBoard, views: list[int], clamp_px: Point, along_px: Point | None
    ) -> Message:
        """Calibrate from views, the first one flat in the sheet's plane."""
        images = [self.view(number).image for number in views]
        self.made = calibrate_camera(images, board, clamp_px=clamp_px, along_px=along_px)
        return as_message(self.made)

    def from_ruler(
        self, image: GreyImage, ends_px: tuple[Point, Point], ruler_mm: float, clamp_px: Point
    ) -> Message:
        """Calibrate from the two ends of a scale bar."""
        rows, columns = image.shape
        made = calibrate_ruler((columns, rows), *ends_px, ruler_mm, clamp_px=clamp_px)
        # a rig's camera has its rows along the clamped sheet
        level = made.optics.model_copy(update={"clamp_angle_known": True})
        self.made = replace(made, optics=level)
        return as_message(self.made)

    def accept(self, path: Path) -> tuple[str | None, str]:
        """Write optics.json; the name of the one before, and what was taken over from it.

        Raises BadInputError.
        """
        if self.made is None:
            raise NotNowError("no calibration was made; make one first.")
        carried = carried_over(self.made.optics, path)
        return write_optics(carried.optics, path), carried.told


def as_message(made: Calibration) -> Message:
    """Return a calibration as the page shows it."""
    optics = made.optics
    axes = optics.world_to_pixel([[0.0, 0.0], [0.01, 0.0], [0.0, 0.01]])
    return {
        "px_per_mm": optics.px_per_mm,
        "px_per_mm_sigma": optics.px_per_mm_sigma,
        "residual_px": made.residual_px,
        "residual_um": made.residual_um,
        "largest_um": made.largest_um,
        "warnings": list(made.warnings),
        "clamp_px": list(optics.clamp_px),
        "axes_px": np.round(axes, 3).tolist(),
        "method": optics.method,
    }


def arc_through(optics: Optics, px: Point) -> dict[str, Any]:
    """Return the arc about the clamp on which a point lies, for `[arc]` of sheet.toml."""
    x_m, y_m = optics.pixel_to_world([px])[0]
    radius_mm = 1e3 * float(np.hypot(x_m, y_m))
    if radius_mm < 1.0:
        raise BadInputError("that is the clamp itself; click the roll at position 0.")
    scale = optics.px_per_mm_sigma / optics.px_per_mm * radius_mm
    return {
        "radius_mm": radius_mm,
        "origin_deg": float(np.degrees(np.arctan2(y_m, x_m))),
        "sigma_mm": float(np.hypot(scale, optics.clamp_sigma_px / optics.px_per_mm)),
    }


def write_optics(optics: Optics, path: Path) -> str | None:
    """Write and rename; return the name NAME.DATE.json under which an older file is kept."""
    part = path.with_name(path.name + ".part")
    kept = None
    try:
        part.write_text(optics.to_json(), encoding="utf-8")
        if path.exists():
            kept = _free_name(path)
            path.replace(kept)
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise not_written(path, error) from None
    return None if kept is None else kept.name


def _free_name(path: Path) -> Path:
    day = dt.datetime.fromtimestamp(path.stat().st_mtime, dt.UTC).date().isoformat()
    names = (f"{path.stem}.{day}{n}{path.suffix}" for n in ("", *(f".{i}" for i in range(1, 1000))))
    return next(path.with_name(name) for name in names if not path.with_name(name).exists())
