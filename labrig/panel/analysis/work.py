"""The work of each analysis job: the functions that the command line calls, and their outputs."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.errors import BadInputError, LabrigError
from labrig.files import write_text
from labrig.panel.analysis.order import AnalysisKind, AnalysisOrder
from labrig.panel.analysis.outputs import output_path

if TYPE_CHECKING:
    from model import ConfigurationFit, Measurements

Progress = Callable[[float, str], None]
Work = Callable[[AnalysisOrder, Progress], "Done"]
ANALYZE_SHARE = 0.5  # of the progress of a job that may have to analyse first


@dataclass(frozen=True, kw_only=True)
class Done:
    """How a job ended well."""

    message: str  # one sentence
    files: tuple[str, ...] = ()  # names of `outputs.ENDINGS` that were written
    notes: list[str] = field(default_factory=list)  # what else the user should know


def analyze(order: AnalysisOrder, progress: Progress) -> Done:
    """Measure forces and curves; the session keeps them."""
    from labrig.analysis import analyze as analyze_session

    found = analyze_session(Path(order.session), progress, workers=order.workers)
    curves = sum(condition.curve is not None for condition in found.conditions)
    message = f"{len(found.conditions)} conditions were measured, {curves} of them with a curve."
    return Done(message=message, notes=list(found.warnings))


def fit(order: AnalysisOrder, progress: Progress) -> Done:
    """Fit all configurations that allow it and write the model with constant EIBM."""
    from labrig.model_file import save_model
    from labrig.report.data.fitted import fit_what_can_be

    notes: list[str] = []
    measurements, rest = _measured(order, progress, notes)
    rest(0.0, "fit")
    fitted = fit_what_can_be(measurements)
    if fitted.fit is None:
        why = "; ".join(dict.fromkeys(why.rstrip(".") for why in fitted.missing.values()))
        raise BadInputError(f"no configuration can be fitted: {why or 'nothing was measured'}.")
    lacking = {name: why.rstrip(".") for name, why in fitted.missing.items()}
    notes += [f"{name}: could not be fitted: {why}." for name, why in lacking.items()]
    save_model(fitted.fit.model, output_path(Path(order.session), "model"))
    found = [_parameters(one) for one in fitted.fit.configurations.values()]
    return Done(message=f"{'; '.join(found)}.", files=("model",), notes=notes)


def diagnose(order: AnalysisOrder, progress: Progress) -> Done:
    """Find what the model is missing; the session keeps the diagnosis."""
    from labrig.analysis.driven import require_driven
    from labrig.experiment.next_measurement.next_protocol import with_protocol
    from labrig.model_file import save_model
    from labrig.report.data.kept_diagnosis import keep_diagnosis
    from labrig.serialise import finite
    from model.discrepancy import DiagnoseOptions
    from model.discrepancy import diagnose as find

    session, notes = Path(order.session), list[str]()
    measurements, rest = _measured(order, progress, notes)
    require_driven(measurements)
    found = find(measurements, DiagnoseOptions(), lambda step, fraction: rest(fraction, step))
    found = with_protocol(found, measurements, session)
    try:
        keep_diagnosis(session, found)
    except LabrigError as error:
        notes.append(f"not kept in the session: {error}")
    save_model(found.model, output_path(session, "completed_model"))
    text = json.dumps(finite(found.to_json()), indent=2) + "\n"
    write_text(output_path(session, "diagnosis"), text)
    return Done(
        message=found.sentence, files=("completed_model", "diagnosis"), notes=[*notes, *found.notes]
    )


def report(order: AnalysisOrder, progress: Progress) -> Done:
    """Write the report as one self-contained page."""
    from labrig.report.page.write import write_report

    session, notes = Path(order.session), list[str]()
    try:
        _, rest = _measured(order, progress, notes)
    except BadInputError as error:  # the report says so, too, and shows what there is
        notes.append(str(error))
        rest = progress
    rest(0.0, "fit")
    with tempfile.TemporaryDirectory() as folder:
        page = write_report(session, Path(folder), progress=rest, tell=notes.append)
        text = page.read_text(encoding="utf-8")
    write_text(output_path(session, "report"), text)
    return Done(message="The report is written.", files=("report",), notes=notes)


def next_measurement(order: AnalysisOrder, progress: Progress) -> Done:
    """Find the measurement that separates two effects and write its protocol."""
    from labrig.experiment.next_measurement.next_protocol import protocol_text
    from labrig.experiment.next_measurement.proposal import pair_of, proposal
    from labrig.report.data.kept_diagnosis import kept_diagnosis
    from labrig.report.diagnosis.tables import next_sentence

    session, notes = Path(order.session), list[str]()
    measurements, rest = _measured(order, progress, notes)
    diagnosis = kept_diagnosis(session)
    if order.between is None and diagnosis is None:
        raise BadInputError("this session has no diagnosis yet; diagnose it first.")
    if order.between is None and diagnosis is not None and pair_of(diagnosis) is None:
        return Done(message=f"There are no two effects to tell apart: {diagnosis.sentence}")
    rest(0.0, "comparing candidate measurements")
    found = proposal(measurements, diagnosis, order.between)
    text = protocol_text(found, measurements, session)
    write_text(output_path(session, "next"), text)
    return Done(message=next_sentence(found), files=("next",), notes=notes)


WORK: dict[AnalysisKind, Work] = {
    "analyze": analyze,
    "fit": fit,
    "diagnose": diagnose,
    "report": report,
    "next": next_measurement,
}


def _measured(
    order: AnalysisOrder, progress: Progress, notes: list[str]
) -> tuple[Measurements, Progress]:
    """Return the session's measurements, analysed now where it has none, and the later progress."""
    from labrig.report.data.findings import measured
    from labrig.session import open_session

    with open_session(Path(order.session)) as session:
        share = 0.0 if session.has_measurements else ANALYZE_SHARE

    def analyzing(fraction: float, text: str) -> None:
        progress(share * fraction, f"analyze: {text}")

    def rest(fraction: float, text: str) -> None:
        progress(share + (1 - share) * fraction, text)

    found = measured(Path(order.session), analyzing, notes.append, processes=order.workers)
    return found, rest


def _parameters(one: ConfigurationFit) -> str:
    from labrig.report.parts.table import volts, with_sigma

    B = with_sigma(1e6 * one.B.value, 1e6 * one.B.sigma)
    eibm = [
        f"EIBM at {volts(voltage_V)} {with_sigma(1e6 * p.value, 1e6 * p.sigma)} µN·m"
        for voltage_V, p in sorted(one.eibm.items(), reverse=True)
    ]
    return f"{one.configuration}: " + ", ".join([f"B {B} µN·m²", *eibm])
