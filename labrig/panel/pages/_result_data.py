"""What the page of results shows of a session, from its file and those beside it."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from labrig.analysis import measure
from labrig.analysis.results import Convergence, converging_steps, result_of
from labrig.errors import BadInputError, LabrigError
from labrig.model_file import load_model
from labrig.report.data.fitted import FittedSheets, fit_what_can_be
from labrig.report.data.kept_diagnosis import kept_diagnosis
from labrig.report.diagnosis.tables import next_sentences, verdict_sentences, verdict_title
from labrig.session import load_measurements, open_session
from model import Measurements
from model.discrepancy.verdict.result import Diagnosis

BESIDE = (".model.toml", ".model+.toml", ".diagnosis.json", ".report.html")
KEPT = 4  # sessions whose results are open in pages at the same time
_REPORT_HEAD = 2000  # characters, in which it states what it was made of
_STATE = re.compile(r'name="labrig-session-state" content="([0-9a-f]+)"')


def beside(path: Path, suffix: str) -> Path:
    """Return the file that an analysis writes beside a session: NAME.model.toml and so on."""
    return path.with_name(f"{path.stem}{suffix}")


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What was measured in a session, as it is now."""

    measurements: Measurements
    analysed: bool  # else they are forces alone
    state: str  # of the whole file; see `RecordedSession.state_checksum`
    outdated: bool  # by marks that were made after the analysis

    def out_of_date(self, path: Path) -> Iterator[str]:
        """Yield what of the files beside the session, and in it, was made of something else."""
        if self.outdated:
            yield (
                "readings or runs were marked after the analysis, and what is shown here was made "
                "without these marks. Analyse takes them into account."
            )
        yield from _models_of_others(path, self.measurements)
        report = beside(path, ".report.html")
        if (made_of := state_of_report(report)) and made_of != self.state:
            yield (
                f"{report.name} was written before the last change of the session (its analysis, "
                "diagnosis, marks or notes). Report writes it again."
            )


def measured_of(path: Path) -> Measured:
    """Return a session's measurements; forces alone where it was not analysed."""
    with open_session(path) as session:
        analysed, outdated = session.has_measurements, session.outdated
        state = session.state_checksum
        found = None if analysed else measure(session, curves=False)
    found = found or load_measurements(path)
    found = replace(found, warnings=tuple(one for one in found.warnings if one != outdated))
    return Measured(measurements=found, analysed=analysed, state=state, outdated=bool(outdated))


def state_of_report(report: Path) -> str:
    """Return the state of the session that a report was made of; empty where it states none."""
    try:
        with report.open(encoding="utf-8", errors="replace") as file:
            head = file.read(_REPORT_HEAD)
    except OSError:
        return ""
    found = _STATE.search(head)
    return found[1] if found else ""


def measured_result(path: Path, name: str) -> dict[str, Any]:
    """Return what was measured, which takes a moment."""
    found = measured_of(path)
    missing = list(_analysis(path, found.analysed))
    out_of_date = list(found.out_of_date(path))
    return result_of(found.measurements, session=name, missing=missing, out_of_date=out_of_date)


class FittedResult:
    """The same with models and their bands; and B and EIBM as positions are added, step by step."""

    def __init__(self, path: Path, name: str) -> None:
        """Fit it, which takes a second."""
        measured = measured_of(path)
        measurements = measured.measurements
        fitted = fit_what_can_be(measurements)
        diagnosis, faults = _diagnosis(path)
        missing = [*_analysis(path, measured.analysed), *_unfitted(fitted)]
        missing += _files(path, diagnosis)
        self.result = result_of(
            measurements,
            session=name,
            fitted=fitted.fit,
            with_effects=None if diagnosis is None or not diagnosis.effects else diagnosis.model,
            diagnosis=None if diagnosis is None else _words(diagnosis),
            missing=missing,
            out_of_date=[*faults, *measured.out_of_date(path)],
        )
        self._steps = converging_steps(measurements, whole=fitted.fit)
        self._convergence: Convergence = {}
        self._complete = False

    def settling(self, seconds: float) -> dict[str, Any]:
        """Return the steps that are known after at least one more, and `seconds` of computing."""
        until = time.monotonic() + seconds
        while not self._complete:
            step = next(self._steps, None)
            if step is None:
                self._complete = True
            else:
                self._convergence.setdefault(step[0], []).append(step[1])
                if time.monotonic() > until:
                    break
        return {"convergence": self._convergence, "complete": self._complete}

    def whole(self) -> dict[str, Any]:
        """Return everything; computes all steps that are not known yet."""
        return {**self.result, **self.settling(math.inf)}


@lru_cache(maxsize=KEPT)
def fitted_result(
    path: Path,
    name: str,
    state: str,  # noqa: ARG001 - a part of the key
) -> FittedResult:
    """Return a session's result; `state` is that of its files. The last ones are kept."""
    return FittedResult(path, name)


def _analysis(path: Path, analysed: bool) -> Iterator[dict[str, Any]]:
    if not analysed:
        yield not_analysed(path)


def not_analysed(path: Path) -> dict[str, Any]:
    """Return what is missing of a session that holds no measurements."""
    text = (
        f"{path.name} is not analysed yet: until Analyse has found the curves in its images, "
        "models are fitted to the forces alone."
    )
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
        "title": verdict_title(found),
        "sentences": verdict_sentences(found),
        "next": next_sentences(found)[:1],  # without the command that writes its protocol
    }


def _models_of_others(path: Path, measurements: Measurements) -> Iterator[str]:
    for suffix, job in ((".model.toml", "Fit"), (".model+.toml", "Diagnose")):
        file = beside(path, suffix)
        if not file.is_file():
            continue
        try:
            model = load_model(file)
        except LabrigError as error:
            yield str(error)
            continue
        if model.checksum != measurements.checksum:
            why = "was fitted to other data than this session's"
            yield f"{file.name} {why}. {job} writes it again."
