"""The curve checks: what each looks at and what it says."""

from __future__ import annotations

from labrig.vision.checks.catalogue import curve_checks
from labrig.vision.checks.contract import CurveCheck

HEAD = """\
# Curve checks

Each curve that `labrig curves` finds is checked. A refusal means that there is no curve; its
sentence names the step that failed and the remedy. A warning is kept with the curve. Several checks
also widen the credible band. The checks run in this order; the first refusal is reported.

- `candidate`: runs on each fitted curve, to choose between them
- `chosen`: runs on the chosen curve
- `uncertainty`: runs on the chosen curve with its whole uncertainty
- `outline`: runs on a curve that was found between two edges, in place of all of these

[How to add a check](../../howto/extending.md#a-curve-check)

| name | runs on | looks at | finding |
|---|---|---|---|
"""


def page() -> str:
    """Return the page's text."""
    return HEAD + "".join(f"{_row(check)}\n" for check in curve_checks().values())


def _row(check: CurveCheck) -> str:
    said = [f"refuses: {check.refusal}"] if check.refusal else []
    said += [f"warns: {check.warning}"] if check.warning else []
    return f"| `{check.name}` | {check.stage} | {check.looks_at} | {'<br>'.join(said)} |"
