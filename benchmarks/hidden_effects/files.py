"""A session as the files that a user hands to `labrig import`; the truth beside them."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.hidden_effects.sessions import Hidden
from labrig.session.tables.write import write_tables
from model import SheetGeometry


def write(hidden: Hidden, folder: Path, truth: Path | None = None) -> list[Path]:
    """Write sheet.toml, forces.csv, curves.csv and signals.csv; their paths.

    The truth goes to a file apart: `truth`, or beside the folder under its name with `.truth.json`.
    """
    folder = Path(folder)
    paths = write_tables(hidden.measurements, folder)
    sheet = folder / "sheet.toml"
    sheet.write_text(sheet_text(hidden.measurements.sheets), encoding="utf-8")
    apart = truth or folder.with_name(folder.name + ".truth.json")
    apart.write_text(json.dumps(hidden.truth.to_dict(), indent=1), encoding="utf-8")
    return [sheet, *paths]


def sheet_text(sheets: dict[str, SheetGeometry]) -> str:
    """sheet.toml."""
    first = next(iter(sheets.values()))
    tables = [f"[arc]\nradius_mm = {first.arc_radius_m * 1e3:.12g}\norigin_deg = 0.0\n"]
    return "\n".join(tables + [_table(sheet) for sheet in sheets.values()])


def _table(sheet: SheetGeometry) -> str:
    lines = [f"[{sheet.configuration}]"]
    for key, metres in (
        ("free_length", sheet.free_length_m), ("width", sheet.width_m),
        ("thickness", sheet.thickness_m), ("elongation", sheet.elongation_m),
    ):  # fmt: skip
        lines.append(f"{key}_mm = {metres * 1e3:.12g}")
    lines.append(f"rise_time_s = {sheet.rise_time_s:.12g}")
    if sheet.initial_curvature is not None:
        s_m, per_m = sheet.initial_curvature
        places = ", ".join(f"{s * 1e3:.12g}" for s in s_m)
        values = ", ".join(f"{k:.12g}" for k in per_m)
        lines.append(f"initial_curvature_per_m = {{ s_mm = [{places}], per_m = [{values}] }}")
    return "\n".join(lines) + "\n"
