"""CSV tables: forces, curves, signals and control, with about.toml, notes and photographs."""

from __future__ import annotations

from pathlib import Path

from labrig.session import export_session


class _Csv:
    summary = "Forces, curves, signals and control as CSV, about.toml, notes.csv and photographs."
    extra = ""

    def write(self, session: Path, folder: Path) -> list[Path]:
        return export_session(session, folder)


FORMAT = _Csv()
