"""How well the catalogue could describe each hidden form at best: nothing is searched or diagnosed.

    python -m benchmarks.hidden_effects.described [D]

For each form at about this d (default 30): the share of d^2 that its own entry leaves, as written
and with its form tolerated, and the same of the two other effects that come nearest. What its own
entry leaves, no search can name. An effect below `APART` sigmas from the next is one of a class.
"""

from __future__ import annotations

import sys

from benchmarks.hidden_effects.cases import Case, Hiding
from benchmarks.hidden_effects.forms import Form
from benchmarks.hidden_effects.run import made
from benchmarks.hidden_effects.suite import Task, forms

SEED = 5


def line(form: Form, d: float) -> str:
    """One row of Markdown."""
    case = Case((Hiding(form.effect, form.form),), seed=SEED, symmetric=form.symmetric)
    one = made(Task(form.effect, "described", case, "d", (d,)))
    seen, name = one.visible, form.effect
    others = sorted((share, n) for n, share in seen.left_tolerant.items() if n != name)[:2]
    next_at = min(seen.near.values())
    return (
        f"| {name} | {form.form} | {one.hidden.truth.effects[0].size:.3g} | {seen.d[0]:.1f}"
        f" | {seen.left[name]:.1%} | {seen.left_tolerant[name]:.1%}"
        f" | {', '.join(f'{n} {share:.1%}' for share, n in others)} | {next_at:.1f} |"
    )


def main() -> None:
    d = float(sys.argv[1]) if len(sys.argv) > 1 else 30.0
    print("| effect | form | size | d | own entry leaves | form tolerated | others | next at |")
    print("|---|---|---|---|---|---|---|---|")
    for form in [*forms(own=True), *forms(own=False)]:
        print(line(form, d), flush=True)


if __name__ == "__main__":
    main()
