"""The devices of a session: what each reported of itself, and its calibration."""

from __future__ import annotations

from typing import Any

from labrig.config.templates import NOT_CALIBRATED
from labrig.report.parts.table import Table
from labrig.session.format.devices import NOT_KNOWN, RecordedDevice, acquisition_in_words

_STATES = {True: "yes", False: "no", None: NOT_KNOWN}


def device_row(device: RecordedDevice) -> dict[str, Any]:
    """Return what JSON and tables hold of a device."""
    identity, calibration = device.identity, device.calibration
    return {
        "part": device.part.replace("_", " "),
        "kind": device.kind,
        "name": identity.name,
        "product": " ".join(text for text in (identity.maker, identity.product) if text),
        "serial": identity.serial,
        "driver": identity.driver,
        "simulated": identity.is_simulated,
        "settings": acquisition_in_words(device.acquisition),
        "calibration": None if calibration is None else calibration.name,
        "calibrated": None if calibration is None else calibration.date,
        "calibration_sha256": None if calibration is None else calibration.sha256,
    }


def devices_as_table(rows: tuple[dict[str, Any], ...]) -> Table:
    """Return the table of the command line and the report."""
    return Table(
        title="Devices",
        columns=("part", "name", "product", "serial", "driver", "simulated", "calibrated"),
        rows=tuple(_cells(row) for row in rows),
        note=f"What a device did not report is {NOT_KNOWN}.",
    )


def settings_as_table(rows: tuple[dict[str, Any], ...]) -> Table | None:
    """Return what cameras had set, as read back from them; None: none said it."""
    cells = tuple((row["name"] or row["kind"], row["settings"]) for row in rows if row["settings"])
    if not cells:
        return None
    return Table(title="Camera settings", columns=("camera", "as read back"), rows=cells)


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    known = [row[key] or NOT_KNOWN for key in ("product", "serial", "driver")]
    calibrated = "-"
    if row["calibration"] is not None:
        date = row["calibrated"] or NOT_KNOWN
        when = "never" if date == NOT_CALIBRATED.isoformat() else date
        calibrated = f"{when} ({row['calibration']})"
    name = row["name"] or row["kind"] or "-"
    return (row["part"], name, *known, _STATES[row["simulated"]], calibrated)
