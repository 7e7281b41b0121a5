"""The sheet in time from one session: pulses at one position and a free release.

The session is recorded in a moving world whose set-ups do not scatter, so that its parameters are
known. CPU times of one process; numba's code is compiled before.
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.report import Report, Table, busy
from labrig.analysis.motion import MotionRecord, motion_record
from labrig.analysis.motion.beginning import StatedValues
from labrig.analysis.motion.dynamic_fit import DynamicFit, dynamic_fit
from labrig.report.tables.in_time.parameters import shown
from labrig.session import open_session
from model.dynamics import Resolution
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import predict
from tests.labrig.moving_session import TRUTH, record

AIM_S = 10.0


def measure() -> Report:
    """Run it."""
    note = busy()
    with tempfile.TemporaryDirectory() as folder:
        path = record(Path(folder))
        begin_s = time.process_time()
        with open_session(path) as session:
            found = motion_record(session)
        read_s = time.process_time() - begin_s
    for run in found.runs:
        predict(TRUTH, run.plan, Resolution())  # compiles
    begin_s = time.process_time()
    fit = dynamic_fit([found], StatedValues())
    fit_s = time.process_time() - begin_s
    figures = {"read_s": read_s, "fit_s": fit_s, "parameters": _figures(fit)}
    notes = (
        f"aim: reading and fit within {AIM_S:g} s of CPU",
        f"chi2 per value {fit.found.chi2 / fit.found.count:.2f}, {fit.found.steps} last steps",
        note,
    )
    return Report((_times(found, read_s, fit_s), _parameters(fit)), figures, notes)


def _times(found: MotionRecord, read_s: float, fit_s: float) -> Table:
    frames = sum(len(run.plan.frame_s) for run in found.runs)
    samples = sum(len(run.plan.time_s) for run in found.runs)
    rows = (
        (f"read {samples} samples, measure {frames} frames", f"{read_s:.1f}"),
        ("fit", f"{fit_s:.1f}"),
    )
    return Table("one position and one release", ("", "CPU s"), rows)


def _parameters(fit: DynamicFit) -> Table:
    true = dict(_true())
    rows = []
    for one in fit.found.parameters:
        text, unit, scale, _ = shown(one.name)
        low, high = one.parameter.interval()
        off = np.log(one.parameter.value / true[one.name])
        rows.append((
            text, f"{scale * true[one.name]:.4g}", f"{scale * one.parameter.value:.4g}",
            f"{scale * low:.4g} to {scale * high:.4g}", unit, f"{100 * off:+.1f}",
            f"{off / one.log_sigma:+.1f}",
        ))  # fmt: skip
    columns = ("parameter", "true", "found", "90 %", "unit", "off, %", "off, sigma")
    return Table("parameters", columns, tuple(rows))


def _figures(fit: DynamicFit) -> dict[str, dict[str, float]]:
    return {
        one.name: {
            "true": true, "found": one.parameter.value, "log_sigma": one.log_sigma,
            "prior_share": one.prior_share,
        }
        for one, (_, true) in zip(fit.found.parameters, _true(), strict=True)
    }  # fmt: skip


def _true() -> list[tuple[str, float]]:
    parameters = LogParameters(TRUTH)
    values = np.exp(parameters.theta).tolist()
    return list(zip([one.name for one in parameters.quantities], values, strict=True))
