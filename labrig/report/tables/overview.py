"""What a session holds, without its measurements: outcome, runs, losses, lateness, its log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from labrig.report.parts.table import Table, fixed
from labrig.report.tables.channels import ChannelSummary, channel_table, channels_as_table
from labrig.report.tables.devices import device_row, devices_as_table, settings_as_table
from labrig.report.tables.marks import marks_as_table
from labrig.session import Mark, RecordedSession, RunRecord, load_measurements
from protocols import free_shapes_in_words


@dataclass(frozen=True, kw_only=True)
class Overview:
    """Read from a session once; prints as tables or as JSON."""

    facts: tuple[tuple[str, str], ...]
    runs: tuple[dict[str, Any], ...]
    log: tuple[tuple[str, ...], ...]
    channels: tuple[ChannelSummary, ...] = ()
    devices: tuple[dict[str, Any], ...] = ()
    marks: tuple[Mark, ...] = ()  # after the end, oldest first

    def as_dict(self) -> dict[str, Any]:
        """Return what JSON holds."""
        return {
            "session": dict(self.facts),
            "runs": list(self.runs),
            "channels": [asdict(channel) for channel in self.channels],
            "devices": list(self.devices),
            "marks": [mark.as_dict() for mark in self.marks],
        }

    def runs_table(self) -> Table:
        """Return a row for each run."""
        rows = tuple(map(_row, self.runs))
        return Table(title="Runs", columns=tuple(_COLUMNS.values()), rows=rows)

    def tables(self, *, log: bool = False) -> list[Table]:
        """Return the tables of the command line and the report."""
        found = [Table(title="Session", columns=("property", "value"), rows=self.facts, text=True)]
        if self.runs:
            found.append(self.runs_table())
        if self.channels:
            found.append(channels_as_table(self.channels))
        if self.devices:
            found.append(devices_as_table(self.devices))
            settings = settings_as_table(self.devices)
            found += [settings] if settings else []
        if self.marks:
            found.append(marks_as_table(self.marks, "Marks after the end"))
        if log:
            found.append(
                Table(
                    title="Log",
                    columns=("s since start", "event", "run", "text"),
                    rows=self.log,
                    text=True,
                )
            )
        return found


_COLUMNS = {
    "run": "run",
    "purpose": "purpose",
    "configuration": "sheet",
    "position_mm": "p, mm",
    "state": "state",
    "readings": "readings",
    "invalid": "invalid",
    "lost_samples": "lost samples",
    "frames_dropped": "lost frames",
    "late_median_ms": "median lateness, ms",
    "late_worst_ms": "largest lateness, ms",
}


def overview(session: RecordedSession) -> Overview:
    """Look through an open session; images and samples are not read."""
    runs = tuple(_run(run) for run in session.runs)
    channels = channel_table(session)
    others = _parts_of_others(session.versions)
    imported = _imported(session)
    # nothing was driven for tables that were imported
    rig = [("clock", session.clock), ("boards", session.boards)]
    facts = (
        ("file", str(session.path)),
        ("identifier", session.identifier),
        ("outcome", session.outcome.value),
        ("reason", session.reason),
        ("output", "none: imported" if imported else session.output_state.value),
        ("started", session.started),
        ("ended", session.ended),
        *([] if imported else rig),
        *([("analysis", session.outdated)] if session.outdated else []),
        *([("replay of", session.replay_of)] if session.replay_of else []),
        ("protocol", session.schedule.protocol),
        *(imported or _recorded(session, runs)),
        ("labrig", session.versions.get("labrig", "-")),
        *([("other parts", others)] if others else []),
    )
    log = tuple(
        (
            f"{event.time_s - session.began_s:.3f}",
            event.kind,
            str(event.run + 1) if event.run >= 0 else "",
            event.text,
        )
        for event in session.events
    )
    devices = tuple(device_row(device) for device in session.devices)
    return Overview(
        facts=facts,
        runs=runs,
        log=log,
        channels=channels,
        devices=devices,
        marks=session.marks_after_end,
    )


def _recorded(
    session: RecordedSession, runs: Sequence[Mapping[str, Any]]
) -> tuple[tuple[str, str], ...]:
    """Return how much a session recorded."""
    done = sum(run["state"] == "complete" for run in runs)
    shapes = free_shapes_in_words(session.schedule)
    return (
        ("runs complete", f"{done} of {len(runs)}"),
        *([("free shapes", shapes)] if shapes else []),
        ("readings", str(sum(run["readings"] for run in runs))),
        ("sample rate", f"{session.rate_hz:g} Hz x {len(session.channels)} channels"),
    )


def _imported(session: RecordedSession) -> tuple[tuple[str, str], ...]:
    """Return what a session of imported tables holds, which has no runs; nothing of others."""
    if not session.imported:
        return ()
    conditions = load_measurements(session.path).conditions
    sheets = ", ".join(dict.fromkeys(each.configuration for each in conditions))
    readings = [reading for each in conditions for reading in each.readings]
    curves = [each.curve for each in conditions] + [reading.curve for reading in readings]
    return (
        ("imported conditions", f"{len(conditions)} of {sheets}"),
        ("readings", str(len(readings))),
        ("neutral curves", str(sum(curve is not None for curve in curves))),
    )


def _parts_of_others(versions: Mapping[str, str]) -> str:
    """Return which parts are of other distributions: "hstage, saw (labrig-h2 0.3)"."""
    by_origin: dict[str, list[str]] = {}
    for key, origin in sorted(versions.items()):
        _, _, part = key.partition(".")
        if part and " " in origin:  # else it is the version of a package
            by_origin.setdefault(origin, []).append(part)
    return "; ".join(f"{', '.join(parts)} ({origin})" for origin, parts in by_origin.items())


def _run(run: RunRecord) -> dict[str, Any]:
    planned = run.planned
    late_s = run.writes["lateness_s"]
    position_m = planned.position_m
    return {
        "run": planned.index + 1,
        "purpose": planned.in_words,
        "configuration": planned.configuration,
        "position_mm": None if position_m is None else round(1e3 * position_m, 6),
        "state": "complete" if run.completed else "begun" if run.started else "not begun",
        "readings": len(run.readings),
        "invalid": int(np.count_nonzero(~run.readings["valid"])),
        "lost_samples": run.counts.lost_samples,
        "frames_dropped": run.counts.frames_dropped,
        "late_median_ms": 1e3 * float(np.median(late_s)) if len(late_s) else None,
        "late_worst_ms": 1e3 * float(np.max(late_s)) if len(late_s) else None,
    }


def _row(run: dict[str, Any]) -> tuple[str, ...]:
    cells = dict(run)
    cells["position_mm"] = "free" if run["position_mm"] is None else f"{run['position_mm']:g}"
    for key in ("late_median_ms", "late_worst_ms"):
        cells[key] = fixed(run[key], 2)
    return tuple(str(cells[key]) for key in _COLUMNS)
