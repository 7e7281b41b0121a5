"""A soak in figures."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.soak.faults import Fault
from benchmarks.soak.judge import Verdict


@dataclass(frozen=True)
class Figures:
    """Of all runs with one fault, or of several."""

    name: str
    runs: int
    energised: int  # at the moment of the fault
    median_s: float  # from the fault to 0 V, of those
    longest_s: float
    largest_V: float  # ever at the sheet
    finished: int  # readings that were over before the fault
    missing: int  # of those
    invalid: int  # readings that the program itself has marked, on a busy computer
    disturbed: int  # attempts that ended before their fault, and were made again
    failed: int  # runs that were not as they should be


def figures(name: str, verdicts: Sequence[Verdict]) -> Figures:
    """The figures of some verdicts."""
    times_s = [v.zero_s for v in verdicts if v.zero_s is not None]
    return Figures(
        name=name,
        runs=len(verdicts),
        energised=len(times_s),
        median_s=statistics.median(times_s) if times_s else 0.0,
        longest_s=max(times_s, default=0.0),
        largest_V=max((v.largest_V for v in verdicts), default=0.0),
        finished=sum(v.finished for v in verdicts),
        missing=sum(v.missing for v in verdicts),
        invalid=sum(v.invalid for v in verdicts),
        disturbed=sum(v.disturbed for v in verdicts),
        failed=sum(bool(v.faults) for v in verdicts),
    )


def summary(verdicts: Sequence[Verdict]) -> list[str]:
    """A table, as lines of Markdown: each fault, and all of them."""
    rows = [figures(f.value, [v for v in verdicts if v.fault is f]) for f in Fault]
    rows = [row for row in rows if row.runs]
    rows.append(figures("all", verdicts))
    head = (
        "| fault | runs | under voltage | 0 V after: median | longest | largest voltage "
        "| readings over | not recovered | marked late | made again | runs failed |"
    )
    return [head, "|---" * 11 + "|", *(_row(f) for f in rows)]


def _row(f: Figures) -> str:
    return (
        f"| {f.name} | {f.runs} | {f.energised} | {f.median_s:.3f} s | {f.longest_s:.3f} s "
        f"| {f.largest_V:.3f} V | {f.finished} | {f.missing} | {f.invalid} "
        f"| {f.disturbed} | {f.failed} |"
    )


def line(v: Verdict) -> str:
    """One run on a line."""
    moment = f"{v.after_s:5.2f} s" if v.after_s >= 0 else f"start + {-v.after_s:.2f} s"
    zero = "was at 0 V" if v.zero_s is None else f"0 V after {v.zero_s:.3f} s"
    said = "; ".join(v.faults) or "ok"
    code = "-" if v.code is None else str(v.code)
    return (
        f"{v.number:4d}  {v.fault.value:10s}  {moment:>14s}  {zero:17s}  code {code:>3s}  "
        f"{v.present}/{v.finished} readings  {said}"
    )
