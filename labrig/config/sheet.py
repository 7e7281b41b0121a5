"""sheet.toml: the geometry of each configuration of the sheet."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, model_validator

from labrig.config.base import ClosedModel, parse_toml, read_text, validate
from labrig.config.file_kinds import SHEET, refuse_other_kind
from labrig.errors import BadInputError
from model.measurements import SheetGeometry


class ArcConfig(ClosedModel):
    """The arc on which the load cell sits, centred at the clamp."""

    radius_mm: float = Field(
        40.0, gt=0, le=1000.0, description="from the clamp to the load cell's contact"
    )
    origin_deg: float = Field(
        0.0, ge=-180.0, le=180.0, description="polar angle of position 0, from the clamp's tangent"
    )


class Curvature(ClosedModel):
    """Initial curvature k0 along the sheet, linear between the nodes."""

    s_mm: list[float] = Field(min_length=2, description="nodes along the sheet, from the clamp")
    per_m: list[float] = Field(min_length=2, description="curvature at each node")

    @model_validator(mode="after")
    def _nodes_match(self) -> Curvature:
        if len(self.s_mm) != len(self.per_m):
            raise ValueError(
                f"s_mm has {len(self.s_mm)} values and per_m {len(self.per_m)}; they must be equal"
            )
        if any(b <= a for a, b in zip(self.s_mm, self.s_mm[1:], strict=False)):
            raise ValueError("s_mm must rise from one value to the next")
        return self


class Sheet(ClosedModel):
    """One configuration of the sheet."""

    free_length_mm: float = Field(gt=0, le=1000.0, description="of the part that can bend")
    clamped_length_mm: float = Field(0.0, ge=0, description="of the part inside the clamp")
    width_mm: float = Field(gt=0, le=1000.0, description="of the sheet")
    thickness_mm: float = Field(gt=0, le=10.0, description="of the sheet, electrodes included")
    elongation_mm: float = Field(0.0, ge=0, le=1000.0, description="visible rigid elongation")
    rise_time_s: float = Field(0.0, ge=0, description="known time constant of the voltage's rise")
    initial_curvature_per_m: float | Curvature | Literal["measured"] = Field(
        "measured", description="k0 without load and voltage: one number, nodes, or as images show"
    )

    def geometry(self, configuration: str, arc: ArcConfig) -> SheetGeometry:
        """Return the same in SI, as the model takes it."""
        return SheetGeometry(
            configuration=configuration,
            free_length_m=self.free_length_mm / 1000,
            width_m=self.width_mm / 1000,
            thickness_m=self.thickness_mm / 1000,
            elongation_m=self.elongation_mm / 1000,
            arc_radius_m=arc.radius_mm / 1000,
            arc_origin_rad=math.radians(arc.origin_deg),
            initial_curvature=self._nodes(),
            rise_time_s=self.rise_time_s,
            clamped_length_m=self.clamped_length_mm / 1000,
        )

    def _nodes(self) -> tuple[np.ndarray, np.ndarray] | None:
        k0 = self.initial_curvature_per_m
        if isinstance(k0, Curvature):
            return np.array(k0.s_mm) / 1000, np.array(k0.per_m, dtype=float)
        if isinstance(k0, str):
            return None
        return np.array([0.0, self.free_length_mm / 1000]), np.array([k0, k0], dtype=float)


def parse_sheet(text: str, name: str) -> dict[str, SheetGeometry]:
    """sheet.toml's text as geometries by configuration; a single one may stand at top level."""
    refuse_other_kind(text, name, SHEET)
    data = parse_toml(text, name)
    arc = validate(ArcConfig, data.pop("arc", {}), f"{name}: [arc]")
    tables = _tables(data, name)
    return {
        key: validate(Sheet, table, f"{name}: [{key}]").geometry(key, arc)
        for key, table in tables.items()
    }


def _tables(data: dict[str, Any], name: str) -> dict[str, dict[str, Any]]:
    if "free_length_mm" in data:
        return {"sheet": data}
    loose = [key for key, value in data.items() if not isinstance(value, dict)]
    if loose:
        raise BadInputError(
            f"{name}: {loose[0]} is not a known key at top level; put it in the table of a "
            "configuration such as [long]."
        )
    if not data:
        raise BadInputError(
            f"{name}: there is no configuration; add a table such as [long] with free_length_mm, "
            "width_mm and thickness_mm."
        )
    for key, table in data.items():
        if table and table.keys() <= ArcConfig.model_fields.keys():
            raise BadInputError(
                f"{name}: [{key}] is no sheet: it has {' and '.join(table)}, which belong to [arc]."
            )
    return data


def load_sheet(path: Path) -> dict[str, SheetGeometry]:
    """Read sheet.toml."""
    return parse_sheet(read_text(path, SHEET), str(path))
