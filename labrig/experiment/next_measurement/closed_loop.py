"""Measure, diagnose, and measure again until one candidate is named.

Each further measurement is a session of its own that names the first one by its identifier; all of
them are diagnosed together. It ends when the verdict is no class any more, when nothing on the menu
helps, when the operator declines, or after `MOST_ROUNDS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from labrig.errors import ExitCode
from model.discrepancy import Diagnosis, Next
from model.discrepancy.thresholds import LEAST_GAIN_SIGMA
from model.discrepancy.verdict.messages import shown_by

MOST_ROUNDS = 3


class MeasurementRig(Protocol):
    """What diagnoses, asks and measures for the loop."""

    def diagnose(self, sessions: list[Path]) -> Diagnosis:
        """Diagnose sessions together, and show what was found."""

    def agree(self, proposed: Next) -> bool:
        """Return whether to make a measurement; ask the operator, unless that was agreed before."""

    def measure(self, proposed: Next, sessions: list[Path], output: Path) -> ExitCode:
        """Run it as a session at `output` that follows the first of `sessions`."""


@dataclass(frozen=True)
class LoopResult:
    """How the loop ended."""

    sessions: tuple[Path, ...]
    diagnosis: Diagnosis
    why: str
    code: ExitCode = ExitCode.DONE


def closed_loop(first: Path, rig: MeasurementRig, report: Callable[[str], None]) -> LoopResult:
    """Measure further after a recorded session until an effect is named or nothing helps."""
    sessions = [first]
    found = rig.diagnose(sessions)
    for number in range(2, MOST_ROUNDS + 2):
        proposed, why = to_measure(found)
        if proposed is None:
            return LoopResult(tuple(sessions), found, why)
        if not rig.agree(proposed):
            return LoopResult(tuple(sessions), found, "the proposed measurement was not made")
        output = further_session(first, number)
        code = rig.measure(proposed, sessions, output)
        if code is not ExitCode.DONE:
            return LoopResult(tuple(sessions), found, f"{output} was not completed", code)
        sessions.append(output)
        report(f"diagnosing {', '.join(map(str, sessions))} together")
        found = rig.diagnose(sessions)
    why = to_measure(found)[1] or f"{MOST_ROUNDS} further measurements were made"
    return LoopResult(tuple(sessions), found, why)


def to_measure(found: Diagnosis) -> tuple[Next | None, str]:
    """Return what to measure now, or None and why not."""
    proposed = found.next_measurement
    if found.verdict != "indistinguishable":
        return None, "the data allow a verdict"
    if proposed is None or proposed.expected < proposed.separation + LEAST_GAIN_SIGMA:
        return None, f"nothing on the menu would separate the candidates{_besides(found)}"
    return proposed, ""


def _besides(found: Diagnosis) -> str:
    """Return in words what besides the menu shows each candidate."""
    names = dict.fromkeys(n for one in found.effects for n in (one.name, *one.confusable_with))
    return f". {shown_by(tuple(names))}" if names else ""


def further_session(first: Path, number: int) -> Path:
    """Return the path of the next session: a free name beside the first one."""
    path = first.with_name(f"{first.stem}-{number}{first.suffix}")
    while path.exists():
        number += 1
        path = first.with_name(f"{first.stem}-{number}{first.suffix}")
    return path
