"""The checks of a curve: what each looks at and what it says."""

from __future__ import annotations

from labrig.vision.checks.catalogue import curve_checks
from labrig.vision.checks.contract import CurveCheck

HEAD = """\
# Checks of a curve

Each curve that `labrig curves` finds is checked. A refusal means that there is no curve; its
sentence names the step that failed and what mends it. A warning goes with the curve. Several
checks also widen the credible band. The checks are asked in this order; the first refusal is told.

- `candidate`: asked of each fitted curve, to choose between them
- `chosen`: asked of the chosen curve
- `uncertainty`: asked of the chosen curve with its whole uncertainty

[How to add a check](../../howto/extending.md#a-check-of-a-curve)

| name | asked | looks at | says |
|---|---|---|---|
"""


def page() -> str:
    """Return the page's text."""
    return HEAD + "".join(f"{_row(check)}\n" for check in curve_checks().values())


def _row(check: CurveCheck) -> str:
    said = [f"refuses: {check.refusal}"] if check.refusal else []
    said += [f"warns: {check.warning}"] if check.warning else []
    return f"| `{check.name}` | {check.stage} | {check.looks_at} | {'<br>'.join(said)} |"
