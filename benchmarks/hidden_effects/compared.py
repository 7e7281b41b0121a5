"""The simpler methods and `diagnose` side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.score import SEEN, STANDS_OUT, THIRTY, clear, wilson


def table(records: Sequence[Record]) -> str:
    """The methods side by side, on the sessions that all of them were given."""
    use = [r for r in records if r.baselines and not r.error]
    methods = ["diagnose", *dict.fromkeys(m for r in use for m in r.baselines)]
    lines = ["| | cases | " + " | ".join(methods) + " |", "|---" * (len(methods) + 2) + "|"]
    for what, chosen, right in _ROWS:
        cases = [r for r in use if chosen(r)]
        cells = [_share(cases, m, right) for m in methods]
        lines.append(f"| {what} | {len(cases)} | " + " | ".join(cells) + " |")
    for what, chosen in _CLOSED:
        cases = [r for r in use if chosen(r) and (r.chi2_before or 0.0) > STANDS_OUT]
        cells = [_closed(cases, m) for m in methods]
        lines.append(f"| {what} | {len(cases)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def as_if(r: Record, method: str) -> tuple[str, ...] | None:
    """What a method named; None: it names nothing, by its nature."""
    if method == "diagnose":
        return r.said
    named = r.baselines[method].get("named")
    return None if named is None else tuple(named)


def _share(
    cases: Sequence[Record], method: str, right: Callable[[Record, tuple[str, ...]], bool]
) -> str:
    told = [(r, as_if(r, method)) for r in cases]
    if not told or told[0][1] is None:
        return "-"
    hits = sum(right(r, said) for r, said in told if said is not None)
    low, high = wilson(hits, len(told))
    return f"{hits / len(told):.0%} ({low:.0%} - {high:.0%})"


def _closed(cases: Sequence[Record], method: str) -> str:
    if method == "diagnose":
        found = [r.closed for r in cases]
    else:
        found = [r.baselines[method]["closed"] for r in cases if "closed" in r.baselines[method]]
    return f"{np.median([v or 0.0 for v in found]):.0%}" if found else "-"


def _same(r: Record, said: tuple[str, ...]) -> bool:
    return sorted(said) == sorted(r.names)


_ROWS: tuple[
    tuple[str, Callable[[Record], bool], Callable[[Record, tuple[str, ...]], bool]], ...
] = (
    ("nothing hidden: something named", lambda r: r.family == "nothing", lambda _, s: bool(s)),
    ("catalogue's form, d >= 8: exactly the truth",
     lambda r: r.family == "own_form" and r.d >= SEEN and clear(r), _same),
    ("other form, d >= 8: exactly the truth",
     lambda r: r.family == "other_form" and r.d >= SEEN and clear(r), _same),
    ("realistic gap, other form: exactly the truth",
     lambda r: r.family == "realistic" and r.d >= SEEN and clear(r), _same),
    ("two effects: exactly both", lambda r: r.family == "pair" and r.d >= SEEN and clear(r), _same),
)  # fmt: skip
_CLOSED: tuple[tuple[str, Callable[[Record], bool]], ...] = (
    ("left-out gap closed, d 20 - 45, median",
     lambda r: r.family in ("own_form", "other_form") and THIRTY[0] <= r.d <= THIRTY[1]),
    ("left-out gap closed, realistic, median", lambda r: r.family == "realistic"),
    ("left-out gap closed, outside the catalogue, median", lambda r: r.family == "outside"),
)  # fmt: skip
