"""Read the sheet's file beside an image; write the JSON and the overlay of a curve."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import Field

from labrig.config.base import ClosedModel, parse_toml, read_text, validate
from labrig.config.file_kinds import SHEET, refuse_other_kind
from labrig.config.sheet import Sheet
from labrig.errors import BadInputError
from labrig.files import write_text
from labrig.vision.calibration.drawing import write_drawing
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.image.reading import PictureLabel

OVERLAY_WIDTH_MIN_PX = 800  # of an overlay; and the size of what is written on it
LETTER_WIDTH_PX, LINE_HEIGHT_PX = 10, 20


class _Strip(ClosedModel):
    """What the extraction needs of a sheet.toml."""

    free_length_mm: float = Field(gt=0, le=1000)
    elongation_mm: float = Field(0.0, ge=0, le=1000)
    thickness_mm: float | None = Field(None, gt=0, le=10)


def load_strip(path: Path, configuration: str | None = None, strip: str = "") -> StripGeometry:
    """Return the strip of a sheet.toml, which may be as little as `free_length_mm = 50`.

    Where it states no thickness, the image decides. `strip`: the name of one of several strips;
    it takes the table of that name where there is one.
    """
    text = read_text(path)
    refuse_other_kind(text, str(path), SHEET)
    data = parse_toml(text, str(path))
    data.pop("arc", None)
    if strip and isinstance(data.get(strip), dict):
        configuration = strip
    table = data if "free_length_mm" in data else _chosen(data, configuration, path)
    known = {key: value for key, value in table.items() if key in _Strip.model_fields}
    unused = [key for key in table if key not in Sheet.model_fields]
    stated = validate(_Strip, known | {key: table[key] for key in unused}, str(path))
    free_m, elongation_m = stated.free_length_mm / 1000, stated.elongation_mm / 1000
    if stated.thickness_mm is None:
        guess_m = min(StripGeometry.thickness_m, 0.1 * free_m)
        return StripGeometry(free_m, elongation_m, guess_m, thickness_known=False)
    return StripGeometry(free_m, elongation_m, stated.thickness_mm / 1000)


def _chosen(data: dict[str, Any], configuration: str | None, path: Path) -> dict[str, Any]:
    tables = {key: value for key, value in data.items() if isinstance(value, dict)}
    if configuration is None and len(tables) == 1:
        return dict(next(iter(tables.values())))
    if configuration in tables:
        return dict(tables[configuration])
    if not tables:
        raise BadInputError(f"{path}: free_length_mm is missing; it is required.")
    why = f"there is no [{configuration}]" if configuration else "it holds several configurations"
    raise BadInputError(f"{path}: {why}; choose one of {', '.join(sorted(tables))}.")


def curve_json(curve: NeutralCurve) -> dict[str, Any]:
    """Return one curve as the JSON object that `labrig curves` writes."""

    def rounded(values: npt.NDArray[np.float64], digits: int) -> list[Any]:
        out: list[Any] = np.round(values, digits).tolist()
        return out

    return {
        "ok": curve.ok,
        "x_mm": rounded(curve.x_m * 1000, 6),
        "y_mm": rounded(curve.y_m * 1000, 6),
        "s_mm": rounded(curve.s_m * 1000, 6),
        "curvature_per_m": rounded(curve.curvature_per_m, 5),
        "sigma_mm": rounded(curve.sigma_m * 1000, 7),
        "curvature_sigma_per_m": rounded(curve.curvature_sigma_per_m, 5),
        "points_px": rounded(curve.points_px, 5),
        "seen": curve.seen.tolist(),
        "covered": round(curve.covered, 4),
        "residual_px": round(curve.residual_px, 5),
        "warnings": list(curve.warnings),
        "why": curve.why,
    }


def labelled_json(label: PictureLabel, curve: NeutralCurve) -> dict[str, Any]:
    """Return the same with the picture's name, frame and time."""
    about: dict[str, Any] = {"image": label.name, "frame": label.frame, "time_s": label.time_s}
    if label.strip:
        about["strip"] = label.strip
    return about | curve_json(curve)


def write_json(path: Path, label: PictureLabel, curve: NeutralCurve) -> None:
    """`labelled_json` into a file."""
    write_text(path, json.dumps(labelled_json(label, curve), allow_nan=False) + "\n")


def write_overlay(path: Path, image: npt.NDArray[Any], curve: NeutralCurve) -> None:
    """Write the image, enlarged, with the curve on it: red where seen, yellow where not."""
    import cv2

    zoom = max(2, round(OVERLAY_WIDTH_MIN_PX / image.shape[1]))
    canvas = cv2.resize(_colour(image), None, fx=zoom, fy=zoom, interpolation=cv2.INTER_NEAREST)
    message = curve.why
    if curve.ok:
        nodes = np.round(((curve.points_px + 0.5) * zoom - 0.5) * 16).astype(np.int32)
        for first, second, seen in zip(nodes[:-1], nodes[1:], curve.seen, strict=False):
            colour = (40, 40, 255) if seen else (0, 220, 255)
            cv2.line(canvas, tuple(map(int, first)), tuple(map(int, second)), colour, 1, 16, 4)
        message = f"covered {curve.covered:.0%}, residual {curve.residual_px:.3f} px"
    lines = textwrap.wrap(message, canvas.shape[1] // LETTER_WIDTH_PX)
    canvas[: LINE_HEIGHT_PX * len(lines) + LINE_HEIGHT_PX // 2] //= (
        3  # so that it can be read on any ground
    )
    for k, line in enumerate(lines, 1):
        at = (LETTER_WIDTH_PX, LINE_HEIGHT_PX * k)
        cv2.putText(
            canvas,
            line,
            at,
            cv2.FONT_HERSHEY_SIMPLEX,
            fontScale=0.5,
            color=(90, 255, 90),
            thickness=1,
            lineType=16,
        )
    write_drawing(path, canvas)


def _colour(image: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    grey = image if image.ndim == 2 else image[:, :, :3].mean(axis=2)
    if grey.dtype != np.uint8:
        low, high = float(grey.min()), float(grey.max())
        grey = ((grey - low) * (255 / max(high - low, 1e-9))).astype(np.uint8)
    return np.ascontiguousarray(np.repeat(grey[:, :, None], 3, axis=2))
