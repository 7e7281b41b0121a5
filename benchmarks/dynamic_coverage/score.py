"""One session identified and compared with its truth; many of them counted."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.dynamic_coverage.drawn import DrawnSession, drawn_session
from benchmarks.dynamic_coverage.measured import SlippedError, measured
from benchmarks.interval_coverage import wilson
from benchmarks.report import Report, Table
from model import ModelError
from model.dynamics.identification import identify, information
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import FINE
from model.dynamics.identification.thresholds import MOST_PRIOR, MOST_SIGMA

LINKS, STEP_MS = 160, 0.5
FEW_LINKS = 64  # the shipped world's
SURE_SHARE, SURE_SIGMA = 2 * MOST_PRIOR, 2 * MOST_SIGMA  # beyond: surely not determined


def scored(seed: int, links: int = LINKS) -> dict[str, Any]:
    """Measure and identify one session; return what was found beside what is true."""
    session = drawn_session(seed, links, STEP_MS)
    row: dict[str, Any] = {"seed": seed, "kind": session.kind, "links": links}
    begin = time.process_time()
    try:
        runs = measured(session)
    except SlippedError:
        return row | {"skipped": "the sheet leaves the rolls"}
    row["world_s"] = time.process_time() - begin
    begin = time.process_time()
    try:
        found = identify(session.start, runs, session.noise)
    except ModelError as fault:
        return row | {"failed": str(fault)}
    row |= {
        "identify_s": time.process_time() - begin, "steps": found.steps,
        "converged": found.converged, "chi2": found.chi2, "count": found.count,
    }  # fmt: skip
    return row | {"parameters": _compared(session, found.parameters)}


def _compared(session: DrawnSession, found: Sequence[Any]) -> dict[str, Any]:
    """Each parameter with its truth, and with what the true information would say of it."""
    quantities = LogParameters(session.truth).quantities
    told = information(session.truth, session.plans, session.noise, FINE)
    out = {}
    for p, q, best in zip(found, quantities, told, strict=True):
        low, high = p.parameter.interval()
        out[p.name] = {
            "truth": q.value, "value": p.parameter.value, "low": low, "high": high,
            "log_sigma": p.log_sigma, "prior_share": p.prior_share, "determined": p.determined,
            "true_log_sigma": best.log_sigma, "true_prior_share": best.prior_share,
            "determinable": best.determined,
        }  # fmt: skip
    return out


def summary(rows: Sequence[dict[str, Any]]) -> Report:
    """Count."""
    good = [row for row in rows if "parameters" in row]
    names = list(good[0]["parameters"]) if good else []
    lines, totals = [], [0, 0]
    for name in names:
        each = [row["parameters"][name] for row in good]
        stated = [p for p in each if p["determined"]]
        inside = sum(p["low"] <= p["truth"] <= p["high"] for p in stated)
        totals[0] += inside
        totals[1] += len(stated)
        z = [np.log(p["value"] / p["truth"]) / p["log_sigma"] for p in stated] or [np.nan]
        width = float(np.median([p["log_sigma"] for p in stated] or [np.nan]))
        numbers = (_number(v) for v in (np.mean(z), np.std(z), 100.0 * width))
        holding = _share(inside, len(stated))
        lines.append((name, str(len(stated)), holding, *numbers, *_undetermined(each)))
    lines.append(("all", str(totals[1]), _share(*totals), "", "", "", *_undetermined(
        [p for row in good for p in row["parameters"].values()]
    )))  # fmt: skip
    columns = (
        "parameter", "intervals", "hold the truth (90 % Wilson)", "mean z", "sd z",
        "sigma, median, %", "not determinable: said so", "surely not: said so",
        "determinable: stated",
    )  # fmt: skip
    notes = _notes(rows, good)
    title = "90 % intervals of what is said to be determined; z: error over stated sigma"
    return Report(
        tables=(Table(title, columns, tuple(lines)),), figures={"rows": len(rows)}, notes=notes
    )


def _undetermined(each: Sequence[dict[str, Any]]) -> tuple[str, str, str]:
    """How often what cannot be determined is said to be so, and what can be is stated."""
    cannot = [p for p in each if not p["determinable"]]
    surely = [
        p for p in cannot if p["true_prior_share"] > SURE_SHARE or p["true_log_sigma"] > SURE_SIGMA
    ]
    can = [p for p in each if p["determinable"]]
    return (
        _share(sum(not p["determined"] for p in cannot), len(cannot)),
        _share(sum(not p["determined"] for p in surely), len(surely)),
        _share(sum(p["determined"] for p in can), len(can)),
    )


def _notes(rows: Sequence[dict[str, Any]], good: Sequence[dict[str, Any]]) -> tuple[str, ...]:
    failed = [row for row in rows if "failed" in row]
    skipped = sum("skipped" in row for row in rows)
    seconds = [row["identify_s"] for row in good] or [np.nan]
    ratios = [row["chi2"] / row["count"] for row in good] or [np.nan]
    kinds = sorted({row["kind"] for row in good})
    what = f"{skipped} not used (the sheet leaves the rolls), {len(failed)} not identified"
    return (
        f"{len(rows)} sessions, {what}",
        "of " + ", ".join(f"{sum(r['kind'] == k for r in good)} {k}" for k in kinds),
        f"search ended: {_share(sum(r['converged'] for r in good), len(good))}",
        f"chi2 per value: mean {np.mean(ratios):.3f}, sd {np.std(ratios):.3f}",
        f"CPU of `identify`: median {np.median(seconds):.1f} s, longest {max(seconds):.1f} s",
        *sorted({f"failed: {row['failed']}" for row in failed}),
    )


def _share(count: int, of: int) -> str:
    if not of:
        return "-"
    low, high = wilson(count / of, of)
    return f"{100.0 * count / of:.1f} ({100.0 * low:.1f} to {100.0 * high:.1f}) of {of}"


def _number(value: float) -> str:
    return f"{value:.2f}"
