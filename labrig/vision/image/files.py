"""Read the sheet's file beside an image; write the JSON of a curve."""

from __future__ import annotations

import json
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
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.image.names import PictureLabel


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
    text = read_text(path, SHEET)
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
        return StripGeometry(free_length_m=free_m, elongation_m=elongation_m)
    return StripGeometry(
        free_length_m=free_m, elongation_m=elongation_m, thickness_m=stated.thickness_mm / 1000
    )


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
        "refused_at_px": curve.refused_at_px and [round(place, 1) for place in curve.refused_at_px],
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
