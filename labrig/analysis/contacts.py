"""The contact as the images show it, against the position that the stage was set to."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from labrig.analysis.curves import ConditionCurves, place_of
from labrig.session import RecordedSession, RunRecord
from model.measurements import Contact, SheetGeometry

SIGMAS = 3.0
SETTING_SIGMA_M = 0.1e-3  # how well a stage, or a person, sets a position
LEAST_RUNS = 3  # that must agree before their common cause is named
CLAMP_SIGMA_PX = 0.5  # of the clamp's end along the sheet, in the image


def contact_warnings(
    session: RecordedSession,
    sheets: Mapping[str, SheetGeometry],
    curves: Sequence[ConditionCurves],
    px_per_m: float,
) -> list[str]:
    """Return a sentence for each run whose images show the contact away from where the stage is."""
    by_run: dict[int, list[Contact]] = {}
    for each in curves:
        if each.contact is not None:
            by_run.setdefault(each.run, []).append(each.contact)
    warnings: list[str] = []
    shifts: list[float] = []
    for number, contacts in by_run.items():
        run = session.run(number)
        shift = middle_position(contacts) - _stage_m(run)
        shifts.append(shift)
        if abs(shift) > tolerance_m(contacts):
            warnings.append(_elsewhere(run, contacts))
    if len(warnings) >= LEAST_RUNS:
        warnings += _common_cause(shifts)
    return [*warnings, *_other_radius(session, sheets, by_run, px_per_m)]


def middle_position(contacts: Sequence[Contact]) -> float:
    """Return the position on the arc that the images of one run show, m; of the rolls, if any."""
    seen = [c.position_m for c in contacts if c.rolls_m]
    return float(np.median(seen or [c.position_m for c in contacts]))


def tolerance_m(contacts: Sequence[Contact]) -> float:
    """Return how far image and stage may differ."""
    # voltages share the clamp and the calibration, so their median is hardly better than one
    sigma = min(c.position_sigma_m for c in contacts)
    return SIGMAS * math.hypot(sigma, SETTING_SIGMA_M)


def _stage_m(run: RunRecord) -> float:
    """Return where the stage reports to be, or was sent."""
    reported = run.stage_position_m
    planned = run.planned.position_m
    return float(reported if reported is not None else planned or 0.0)


def _elsewhere(run: RunRecord, contacts: Sequence[Contact]) -> str:
    sigma_mm = max(0.01, 1e3 * min(c.position_sigma_m for c in contacts))
    place = f"{run.planned.configuration}, {place_of(run.planned.position_m)}"
    found = f"{1e3 * middle_position(contacts):.2f} ± {sigma_mm:.2f} mm"
    if any(c.rolls_m for c in contacts):
        return f"{place}: the image shows the contact at {found}; check the stage's position"
    return (
        f"{place}: the image shows the sheet on the arc at {found}, and no rolls there; check "
        "the stage's position, and whether the sheet is between the rolls"
    )


def _common_cause(shifts: Sequence[float]) -> Iterator[str]:
    spread_m = float(np.std(shifts))
    if spread_m < 2 * SETTING_SIGMA_M:
        yield (
            f"all {len(shifts)} runs show the contact {1e3 * float(np.mean(shifts)):+.2f} mm from "
            "where the stage was; check the arc's origin_deg in sheet.toml, the stage's zero and "
            "roll_rad in optics.json"
        )


def _other_radius(
    session: RecordedSession,
    sheets: Mapping[str, SheetGeometry],
    by_run: Mapping[int, Sequence[Contact]],
    px_per_m: float,
) -> Iterator[str]:
    """Return the rolls' distance from the clamp, against the arc's radius."""
    ratios = [
        contact.radius_m / sheets[session.run(number).planned.configuration].arc_radius_m
        for number, contacts in by_run.items()
        for contact in contacts
        if contact.rolls_m
    ]
    if not ratios:
        return
    radius_m = next(iter(sheets.values())).arc_radius_m
    found_m = float(np.median(ratios)) * radius_m
    if abs(found_m - radius_m) > SIGMAS * math.hypot(SETTING_SIGMA_M, CLAMP_SIGMA_PX / px_per_m):
        yield (
            f"the rolls are {1e3 * found_m:.2f} mm from the clamp in the images, but sheet.toml "
            f"has an arc of {1e3 * radius_m:g} mm; check radius_mm of the arc, and px_per_mm"
        )
