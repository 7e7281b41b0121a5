"""What the page of results shows of a session, from its file and those beside it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from labrig.analysis import measure
from labrig.analysis.results import converging, result_of
from labrig.errors import BadInputError, LabrigError
from labrig.model_file import load_model
from labrig.report.data.fitted import FittedSheets, fit_what_can_be
from labrig.report.data.kept_diagnosis import kept_diagnosis
from labrig.report.diagnosis.tables import VERDICTS, next_sentences, verdict_sentences
from labrig.session import load_measurements, open_session
from model import Measurements
from model.discrepancy.verdict.result import Diagnosis

BESIDE = (".model.toml", ".model+.toml", ".diagnosis.json", ".report.html")
Missing = list[dict[str, Any]]


def beside(path: Path, suffix: str) -> Path:
    """Return the file that an analysis writes beside a session: NAME.model.toml and so on."""
    return path.with_name(f"{path.stem}{suffix}")


def measured_of(path: Path) -> tuple[Measurements, bool]:
    """Return a session's measurements, and whether it was analysed; else they are forces alone."""
    with open_session(path) as session:
        if not session.has_measurements:
            return measure(session, curves=False), False
    return load_measurements(path), True


def measured_result(path: Path, name: str) -> dict[str, Any]:
    """Return what was measured, which takes a moment."""
    measurements, analysed = measured_of(path)
    return result_of(measurements, session=name, missing=list(_analysis(path, analysed)))


@lru_cache(maxsize=1)
def fitted_result(
    path: Path,
    name: str,
    state: str,  # noqa: ARG001 - a part of the key
) -> tuple[Measurements, dict[str, Any]]:
    """Return the same with models and their bands, which takes a second; and the measurements.

    `state` is that of the files: the last result is kept for `complete_result`, which adds to it.
    """
    measurements, analysed = measured_of(path)
    fitted = fit_what_can_be(measurements)
    diagnosis, faults = _diagnosis(path)
    missing = [*_analysis(path, analysed), *_unfitted(fitted), *_files(path, diagnosis)]
    return measurements, result_of(
        measurements,
        session=name,
        fitted=fitted.fit,
        with_effects=None if diagnosis is None or not diagnosis.effects else diagnosis.model,
        diagnosis=None if diagnosis is None else _words(diagnosis),
        missing=missing,
        out_of_date=[*faults, *_out_of_date(path, measurements)],
    )


def complete_result(path: Path, name: str, state: str) -> dict[str, Any]:
    """Return all of it, with how B and EIBM settled: takes some more seconds."""
    measurements, found = fitted_result(path, name, state)
    return {**found, "convergence": converging(measurements)}


def _analysis(path: Path, analysed: bool) -> Iterator[dict[str, Any]]:
    if not analysed:
        yield not_analysed(path)


def not_analysed(path: Path) -> dict[str, Any]:
    """Return what is missing of a session that holds no measurements."""
    text = f"{path.name} is not analysed yet: its images hold no curves. Analyze finds them."
    return {"kind": "analyze", "text": text}


def _unfitted(fitted: FittedSheets) -> Iterator[dict[str, Any]]:
    for name, why in fitted.missing.items():
        yield {"kind": None, "text": f"{name}: B and EIBM cannot be found: {why.rstrip('.')}."}


def _files(path: Path, diagnosis: Diagnosis | None) -> Iterator[dict[str, Any]]:
    model, report = beside(path, ".model.toml"), beside(path, ".report.html")
    if not model.is_file():
        yield {"kind": "fit", "text": f"There is no {model.name} yet. Fit writes it."}
    if diagnosis is None:
        text = "There is no diagnosis yet. Diagnose makes it."
        yield {"kind": "diagnose", "text": text}
    if not report.is_file():
        yield {"kind": "report", "text": f"There is no {report.name} yet. Report writes it."}


def _diagnosis(path: Path) -> tuple[Diagnosis | None, list[str]]:
    try:
        return kept_diagnosis(path), []
    except BadInputError as error:
        return None, [str(error)]


def _words(found: Diagnosis) -> dict[str, Any]:
    return {
        "verdict": found.verdict,
        "title": VERDICTS[found.verdict],
        "sentences": verdict_sentences(found),
        "next": next_sentences(found),
    }


def _out_of_date(path: Path, measurements: Measurements) -> Iterator[str]:
    for suffix in (".model.toml", ".model+.toml"):
        file = beside(path, suffix)
        if not file.is_file():
            continue
        try:
            model = load_model(file)
        except LabrigError as error:
            yield str(error)
            continue
        if model.checksum != measurements.checksum:
            yield f"{file.name} was fitted to other data than this session's. Fit writes it again."
