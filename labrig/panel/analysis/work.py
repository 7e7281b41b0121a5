"""The work of each analysis job: the functions that the command line calls, and their outputs."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.errors import BadInputError, LabrigError
from labrig.files import write_text, write_zip
from labrig.panel.analysis.order import AnalysisKind, AnalysisOrder
from labrig.panel.analysis.outputs import output_path
from labrig.progress import Progress, within

if TYPE_CHECKING:
    from model import ConfigurationFit, Measurements
    from model.discrepancy import Diagnosis

Work = Callable[[AnalysisOrder, Progress], "Done"]
FIGURE_FORMATS = ("pdf", "svg")
ANALYZE_SHARE = 0.5  # of the progress of a job that may have to analyse first
DIAGNOSE_SHARE = 0.9  # of the progress of a proposal that has to diagnose first
DIAGNOSED = ("completed_model", "diagnosis")  # what a diagnosis writes beside its session


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
    """Fit all configurations that allow it and write the model that describes them."""
    from labrig.model_file import save_model
    from labrig.report.data.fitted import fit_what_can_be
    from labrig.report.data.suspicions import suspicions
    from labrig.report.diagnosis.tables import suspicion_sentence

    notes: list[str] = []
    measurements, rest = _measured(order, progress, notes)
    rest(0.0, "fit")
    notes += [suspicion_sentence(one) for one in suspicions(measurements)]
    fitted = fit_what_can_be(measurements)
    if fitted.fit is None:
        why = "; ".join(dict.fromkeys(why.rstrip(".") for why in fitted.missing.values()))
        raise BadInputError(f"no configuration can be fitted: {why or 'nothing was measured'}.")
    lacking = {name: why.rstrip(".") for name, why in fitted.missing.items()}
    notes += [f"{name}: could not be fitted: {why}." for name, why in lacking.items()]
    save_model(fitted.fit.preferred_model, output_path(Path(order.session), "model"), force=True)
    found = [_parameters(one) for one in fitted.fit.configurations.values()]
    return Done(message=f"{'; '.join(found)}.", files=("model",), notes=notes)


def diagnose(order: AnalysisOrder, progress: Progress) -> Done:
    """Find what the model is missing; the session keeps the diagnosis."""
    notes = list[str]()
    measurements, rest = _measured(order, progress, notes)
    found = _diagnosed(order, measurements, rest, notes)
    return Done(message=found.sentence, files=_written(found), notes=[*notes, *found.notes])


def _written(found: Diagnosis) -> tuple[str, ...]:
    """Return what a diagnosis wrote beside its session: no model where nothing was searched."""
    return DIAGNOSED if found.searched else DIAGNOSED[1:]


def _diagnosed(
    order: AnalysisOrder, measurements: Measurements, progress: Progress, notes: list[str]
) -> Diagnosis:
    """Diagnose a session and write what came out, in the session and beside it."""
    from labrig.analysis.driven import require_driven
    from labrig.experiment.next_measurement.next_protocol import with_protocol
    from labrig.model_file import save_model
    from labrig.report.data.kept_diagnosis import keep_diagnosis
    from labrig.report.diagnosis.tables import data_check_sentences
    from labrig.serialise import finite
    from model.discrepancy import DiagnoseOptions
    from model.discrepancy import diagnose as find

    session = Path(order.session)
    require_driven(measurements)
    found = find(measurements, DiagnoseOptions(), progress)
    found = with_protocol(found, measurements, session)
    try:
        keep_diagnosis(session, found)
    except LabrigError as error:
        notes.append(f"not kept in the session: {error}")
    if found.searched:
        save_model(found.model, output_path(session, "completed_model"), force=True)
    notes += data_check_sentences(found)
    text = json.dumps(finite(found.to_json()), indent=2) + "\n"
    write_text(output_path(session, "diagnosis"), text)
    return found


def report(order: AnalysisOrder, progress: Progress) -> Done:
    """Write the report as one self-contained page, and its figures for a paper as one archive."""
    from labrig.report.page.write import write_report

    session, notes = Path(order.session), list[str]()
    try:
        _, rest = _measured(order, progress, notes)
    except BadInputError as error:  # the report says so, too, and shows what there is
        notes.append(str(error))
        rest = progress
    rest(0.0, "fit")
    archive = output_path(session, "figures")
    with tempfile.TemporaryDirectory() as folder:
        page = write_report(
            session,
            Path(folder),
            formats=FIGURE_FORMATS,
            figures_named=archive.name,
            progress=rest,
            tell=notes.append,
            processes=order.workers,
        )
        text = page.read_text(encoding="utf-8")
        figures = sorted((Path(folder) / "figures").iterdir())
        write_zip(archive, {figure: figure.name for figure in figures})
    write_text(output_path(session, "report"), text)
    return Done(message="The report is written.", files=("report", "figures"), notes=notes)


def next_measurement(order: AnalysisOrder, progress: Progress) -> Done:
    """Find the measurement that separates two effects and write its protocol.

    Without two effects named, those that the diagnosis leaves open; it is made where there is none.
    """
    from labrig.experiment.next_measurement.next_protocol import protocol_text
    from labrig.experiment.next_measurement.proposal import pair_of, proposal
    from labrig.report.data.kept_diagnosis import kept_diagnosis
    from labrig.report.diagnosis.tables import next_sentence

    session, notes, files = Path(order.session), list[str](), tuple[str, ...]()
    measurements, rest = _measured(order, progress, notes)
    diagnosis = kept_diagnosis(session)
    if order.between is None:
        if diagnosis is None:
            diagnosis = _diagnosed(order, measurements, _first(rest), notes)
            notes.append(f"It was diagnosed first: {diagnosis.sentence}")
            rest, files = _then(rest), _written(diagnosis)
        if pair_of(diagnosis) is None:
            message = f"There are no two effects to tell apart: {diagnosis.sentence}"
            return Done(message=message, files=files, notes=notes)
    rest(0.0, "comparing candidate measurements")
    found = proposal(measurements, diagnosis, order.between)
    text = protocol_text(found, measurements, session)
    write_text(output_path(session, "next"), text)
    return Done(message=next_sentence(found), files=(*files, "next"), notes=notes)


def _first(progress: Progress) -> Progress:
    """Progress of a diagnosis that another job needs."""
    return lambda fraction, text: progress(DIAGNOSE_SHARE * fraction, f"diagnose: {text}")


def _then(progress: Progress) -> Progress:
    return within(progress, DIAGNOSE_SHARE, 1.0)


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

    if not one.B_known:
        ratio = [
            f"EIBM/B at {volts(voltage_V)} {with_sigma(p.value, p.sigma)} 1/m"
            for voltage_V, p in sorted(one.eibm_over_B.items(), reverse=True)
        ]
        return f"{one.configuration}, by shapes alone: " + ", ".join(ratio)
    B = with_sigma(1e6 * one.B.value, 1e6 * one.B.sigma)
    eibm = [
        f"EIBM at {volts(voltage_V)} {with_sigma(1e6 * p.value, 1e6 * p.sigma)} µN·m"
        for voltage_V, p in sorted(one.eibm.items(), reverse=True)
    ]
    return f"{one.configuration}: " + ", ".join([f"B {B} µN·m²", *eibm])
