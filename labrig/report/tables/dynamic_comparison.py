"""Models of the sheet in time beside one another."""

from __future__ import annotations

from labrig.analysis.comparison import ComparedModel, DynamicComparison
from labrig.report.parts.table import Table, fixed

COLUMNS = (
    ("force", "force", 1e3, "mN", 3),
    ("current", "current", 1e3, "mA", 3),
    ("shape", "shape", 1e3, "mm", 2),
)  # quantity, as people call it, scale, unit, decimals
WHOLE = 0.995  # less of the values that were held out is told beside the error


def dynamic_comparison_table(found: DynamicComparison) -> Table:
    """One row for each model, the largest ln evidence first."""
    columns = (
        "model",
        *(f"{name} RMSE, {unit}" for _, name, _, unit, _ in COLUMNS),
        "ln evidence",
        *(f"of the {name}" for _, name, *_ in COLUMNS),
    )
    best = max((m.ln_evidence for m in found.models if not m.why_not), default=0.0)
    tops = {
        key: max((m.quantities[key].ln_evidence for m in found.models if key in m.quantities),
                 default=0.0)
        for key, *_ in COLUMNS
    }  # fmt: skip
    rows = tuple(_row(model, best, tops) for model in found.models)
    count = ", ".join(f"{n} of {name}" for name, n in found.values.items())
    note = (
        f"RMSE: of what was held out ({found.held_out}); in brackets the share of it that a model"
        f" predicts. ln evidence: of what was fitted ({count}; samples at {found.rate_hz:g} Hz),"
        " less the largest of its column; of all, where what a model does not predict counts as"
        " normal about its mean, and of each quantity fitted alone. A model's misfit widens the"
        " noise of that quantity. -: not predicted."
    )
    return Table(
        title=f"Models in time: {found.configuration}", columns=columns, rows=rows, note=note
    )


def not_fitted(found: DynamicComparison) -> list[str]:
    """Return a sentence for each model that could not be fitted."""
    return [f"{one.title}: {one.why_not}." for one in found.models if one.why_not]


def _row(model: ComparedModel, best: float, tops: dict[str, float]) -> tuple[str, ...]:
    errors, evidence = [], []
    for key, _, scale, _, decimals in COLUMNS:
        one = model.quantities.get(key)
        text = fixed(None if one is None else scale * one.rmse, decimals)
        if one is not None and text != "-" and one.share < WHOLE:
            text += f" ({100 * one.share:.0f} %)"
        errors.append(text)
        evidence.append(fixed(None if one is None else one.ln_evidence - tops[key], 0))
    total = fixed(None if model.why_not else model.ln_evidence - best, 0)
    return (model.title, *errors, total, *evidence)
