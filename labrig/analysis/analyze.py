"""A recorded session in, its measurements out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

from drivers.load_cell import LoadCellCalibration
from labrig.analysis.conditions import conditions_of, turns_of
from labrig.analysis.contacts import contact_warnings
from labrig.analysis.curves import ConditionCurves, measure_curves
from labrig.analysis.dead_weights import dead_weight_warnings
from labrig.analysis.forces import measure_forces
from labrig.analysis.held_voltage import held_voltage_warnings
from labrig.analysis.series import time_series
from labrig.analysis.wetting import wetting_warnings
from labrig.config import parse_sheet, recorded_calibration
from labrig.errors import BadInputError
from labrig.extractors.choice import BUILT_IN, chosen_extractor
from labrig.files import AnyPath, path_of
from labrig.progress import Progress
from labrig.session import RecordedSession, open_session, store_measurements
from labrig.session.supplements.store import check_can_be_added_to
from model.measurements import CameraUncertainty, Measurements, SheetGeometry, TimeSeries
from model.measurements.known_arguments import known_arguments
from protocols.planning.schedule import Purpose

if TYPE_CHECKING:
    from labrig.vision import Optics


@known_arguments
def analyze(
    path: AnyPath,
    progress: Progress | None = None,
    *,
    workers: int = 1,
    extractor: str = BUILT_IN,
) -> Measurements:
    """Measure forces and curves of a session and keep them in it, in place of those it held.

    `progress(fraction, text)` is called now and then; `workers` processes look for curves
    with the curve extractor of that name.
    Raises BadInputError when the session holds nothing that can be measured.
    """
    path = path_of(path)
    with open_session(path) as session:
        check_can_be_added_to(path)
        measurements = measure(session, progress, workers=workers, extractor=extractor)
    store_measurements(path, measurements, curve_extractor=_record_of(extractor))
    return measurements


def measure(
    session: RecordedSession,
    progress: Progress | None = None,
    *,
    workers: int = 1,
    extractor: str = BUILT_IN,
    curves: bool = True,
) -> Measurements:
    """Return the same without keeping it; without `curves` the images are left alone."""
    if not any(run.started for run in session.runs):
        raise BadInputError(
            f"{session.path}: no run was recorded in it, so there is nothing to analyze."
        )
    given = inputs_of(session)
    forces = {run.planned.index: measure_forces(run, given.calibration) for run in session.runs}
    seen, notes = _curves(session, given, progress, workers, extractor) if curves else ([], [])
    warnings = [
        *notes,
        *wetting_warnings(session),
        *dead_weight_warnings(session, forces, given.calibration),
        *_controlled(session),
        *held_voltage_warnings(session),
    ]
    warnings += [text for each in seen for text in each.warnings]
    return Measurements(
        sheets=given.sheets,
        conditions=conditions_of(session, forces, seen),
        series=tuple(_series(session, given.calibration)),
        source=session.path.name,
        checksum=session.data_checksum,
        warnings=tuple(warnings),
        camera=given.camera_uncertainty(seen),
    )


def _controlled(session: RecordedSession) -> list[str]:
    """Return why a session under a controller has no readings."""
    if not any(run.planned.reference for run in session.runs):
        return []
    return [
        (
            "A controller set the voltage: such a run has no readings to analyze; `labrig export`"
            " writes what was measured each period to control.csv."
        )
    ]


@dataclass(frozen=True)
class AnalysisInputs:
    """What a session's analysis needs beside its runs."""

    sheets: dict[str, SheetGeometry]
    calibration: LoadCellCalibration
    optics: Optics | None  # None: there are no curves
    why_no_curves: str

    def camera_uncertainty(self, curves: Sequence[ConditionCurves]) -> CameraUncertainty:
        """Return how well camera and curves are known, however many images there are."""
        if self.optics is None:
            return CameraUncertainty()
        looks = [one.systematic_px for one in curves if one.systematic_px is not None]
        return CameraUncertainty(
            scale=self.optics.px_per_mm_sigma / self.optics.px_per_mm,
            roll_rad=self.optics.roll_sigma_rad,
            origin_m=self.optics.origin_sigma_px / self.optics.px_per_m,
            curve_m=median(looks) / self.optics.px_per_m if looks else 0.0,
        )


def inputs_of(session: RecordedSession) -> AnalysisInputs:
    """Read them from the texts that the session holds. Raises BadInputError."""
    sheets = parse_sheet(_text(session, "sheet.toml"), f"{session.path}: sheet.toml")
    calibration = recorded_calibration(
        _text(session, "load_cell.toml"), f"{session.path}: load_cell.toml", session.resolved
    )
    _check_configurations(session, sheets)
    if session.frame_shape is None:
        why = "The session was recorded without a camera; it has no curves."
        return AnalysisInputs(sheets, calibration, None, why)
    if "optics.json" not in session.texts:
        why = "The session holds no optics.json; its frames cannot be measured."
        return AnalysisInputs(sheets, calibration, None, why)
    from labrig.vision import Optics

    optics = Optics.from_json(session.texts["optics.json"], f"{session.path}: optics.json")
    return AnalysisInputs(sheets, calibration, optics, "")


def _text(session: RecordedSession, name: str) -> str:
    try:
        return session.texts[name]
    except KeyError:
        raise BadInputError(f"{session.path}: holds no {name}, which its analysis needs.") from None


def _check_configurations(session: RecordedSession, sheets: dict[str, SheetGeometry]) -> None:
    for run in session.runs:
        if run.planned.configuration not in sheets:
            raise BadInputError(
                f"{session.path}: its sheet.toml has no table [{run.planned.configuration}], which "
                f"run {run.planned.index + 1} needs."
            )


def _curves(
    session: RecordedSession,
    given: AnalysisInputs,
    progress: Progress | None,
    workers: int,
    extractor: str,
) -> tuple[list[ConditionCurves], list[str]]:
    if given.optics is None:
        return [], [given.why_no_curves]
    curves = measure_curves(
        session, given.optics, given.sheets,
        progress=progress, workers=workers, extractor=extractor,
    )  # fmt: skip
    from labrig.vision.checks.catalogue import origins as curve_check_origins

    made_by = _record_of(extractor)
    notes = [f"The curves are those of the curve extractor {made_by}."] if made_by else []
    if curves and not any(one.mean is not None or one.by_reading for one in curves):
        notes.append(
            "No image of the session shows a curve, each for the reason below; check px_per_mm and "
            "clamp_px of optics.json, and the length and thickness of the sheet."
        )
    if not made_by and (checked_by := curve_check_origins()):
        named = ", ".join(f"{name} ({origin})" for name, origin in checked_by.items())
        notes.append(f"The curves were also checked by {named}.")
    return curves, [*notes, *contact_warnings(session, given.sheets, curves, given.optics.px_per_m)]


def _record_of(extractor: str) -> str:
    """Return name, distribution and version of an extractor; nothing for the built-in one."""
    chosen = chosen_extractor(extractor)
    return "" if chosen.is_built_in else f"{chosen.name} ({chosen.origin})"


def _series(session: RecordedSession, calibration: LoadCellCalibration) -> list[TimeSeries]:
    shunt, turns = shunt_ohm(session), turns_of(session)
    return [
        time_series(run, calibration, shunt, turns[run.planned.index])
        for run in session.runs
        if run.started and run.planned.purpose in (Purpose.MEASUREMENT, Purpose.FREE_SHAPE)
    ]


def shunt_ohm(session: RecordedSession) -> float | None:
    """Return the shunt that turns the current channel's volts into amperes; None: not known."""
    sense = session.resolved.get("rig", {}).get("current_sense", {})
    value = sense.get("shunt_ohm")
    return float(value) if isinstance(value, int | float) and value > 0 else None
