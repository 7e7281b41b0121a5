"""The numbers that a report begins with, and what must be known before trusting them."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.report.findings import Findings
from labrig.report.paper import PAPER
from labrig.report.table import fixed, volts, with_sigma
from model import Parameter
from protocols.events import Outcome, OutputState


@dataclass(frozen=True)
class Card:
    """A few numbers of one kind: (name, value, the paper's)."""

    title: str
    lines: tuple[tuple[str, str, str], ...]


def cards(found: Findings) -> list[Card]:
    """The session itself first, then the sheet's parameters and the model's errors."""
    made = [_session(found)]
    fit = found.fit
    if fit is None:
        return made
    parts = fit.configurations
    made.append(_parameters("Bending stiffness B, µN·m²", {n: p.B for n, p in parts.items()}))
    top = max((v for p in parts.values() for v in p.eibm), default=None)
    if top is not None:
        eibm = {n: p.eibm[top] for n, p in parts.items() if top in p.eibm}
        made.append(_parameters(f"Constant EIBM at {volts(top)}, µN·m", eibm))
    errors = {n: {str(k): v for k, v in p.rmse.items()}["varying"] for n, p in parts.items()}
    made.append(
        Card(
            "Force, simulated - measured, RMSE, mN",
            tuple((n, fixed(1e3 * e.force_N, 3), _quoted(n, "force")) for n, e in errors.items()),
        )
    )
    made.append(
        Card(
            "Curve, simulated - measured, RMSE, mm",
            tuple((n, fixed(1e3 * e.curve_m, 3), _quoted(n, "curve")) for n, e in errors.items()),
        )
    )
    return made


def _session(found: Findings) -> Card:
    session = found.session
    done = sum(run.completed for run in session.runs)
    lines = [
        ("outcome", session.outcome.value, ""),
        ("runs complete", f"{done} of {len(session.runs)}", ""),
    ]
    if found.measurements is not None:
        readings = [r for c in found.measurements.conditions for r in c.readings]
        good = sum(r.valid for r in readings)
        lines.append(("readings valid", f"{good} of {len(readings)}", ""))
        curves = sum(c.curve is not None for c in found.measurements.conditions)
        lines.append(("neutral curves", f"{curves} of {len(found.measurements.conditions)}", ""))
    return Card("Session", tuple(lines))


def _parameters(title: str, values: dict[str, Parameter]) -> Card:
    lines = ((n, with_sigma(1e6 * p.value, 1e6 * p.sigma), "") for n, p in values.items())
    return Card(title, tuple(lines))


def _quoted(name: str, what: str) -> str:
    if name not in PAPER:
        return ""
    paper = PAPER[name]
    return fixed(paper.force_rmse_mN[0], 3) if what == "force" else fixed(paper.curve_rmse_mm[0], 2)


def remarks(found: Findings) -> list[str]:
    """What is missing or out of the ordinary, a sentence each; empty when nothing is."""
    session, said = found.session, []
    if session.outcome is not Outcome.COMPLETED:
        reason = session.reason.rstrip(".") or "no reason was recorded"
        said.append(f"The session did not end as planned: {session.outcome.value} ({reason}).")
    if session.output_state is not OutputState.SAFE:
        said.append(f"The output was left {session.output_state.value}.")
    if found.measurements is None:
        said.append(f"Nothing could be measured: {found.why_not}")
    elif not found.names:
        said.append("No condition was measured.")
    if len(found.names) == 1:
        said.append(f"Only the configuration {found.names[0]} was measured.")
    for name, why in found.fitted.missing.items():
        said.append(f"The configuration {name} could not be fitted: {why.rstrip('.')}.")
    said += found.quality.remarks
    if found.measurements is not None:
        said += [text.rstrip(".") + "." for text in found.measurements.warnings]
    return said
