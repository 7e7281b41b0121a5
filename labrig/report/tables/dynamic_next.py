"""What further runs would determine of the sheet in time: expected 90 % intervals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import exp
from typing import Any

from labrig.analysis.motion.proposals import Proposal
from labrig.report.parts.table import Table, number
from labrig.report.tables.dynamic_fit import shown
from model.dynamics.identification import DynamicParameter

_INTERVAL = 1.6449  # standard deviations to either side hold 90 %


def next_table(configuration: str, offered: Sequence[Proposal]) -> Table:
    """Return half the 90 % interval of each parameter, now and with each run."""
    now = offered[0].parameters
    rows = [
        (shown(one.name).text, *(_cell(each.parameters[i]) for each in offered))
        for i, one in enumerate(now)
    ]
    return Table(
        title=f"{configuration} in time: half of the 90 % interval, %",
        columns=("parameter", "now", *(f"+ {each.name}" for each in offered[1:])),
        rows=tuple(rows),
        note="-: not determined. Cramer and Rao's bounds, for this noise and a right model.",
    )


def next_text(offered: Sequence[Proposal]) -> Iterator[str]:
    """Yield a sentence for each run: what it determines that is not determined now."""
    now = {one.name for one in offered[0].parameters if not one.determined}
    for each in offered[1:]:
        more = [one.name for one in each.parameters if one.determined and one.name in now]
        what = ", ".join(shown(name).text for name in more) or "nothing that is unknown now"
        yield f"{each.name} ({each.key}, {each.seconds:.3g} s) determines {what}."


def _cell(one: DynamicParameter) -> str:
    if not one.determined:
        return "-"
    return number(50.0 * (exp(_INTERVAL * one.log_sigma) - exp(-_INTERVAL * one.log_sigma)), 2)


def proposals_json(offered: Sequence[Proposal]) -> list[dict[str, Any]]:
    """Return the same for --json."""
    return [
        {
            "run": each.name or "now",
            "protocol": each.key,
            "seconds": each.seconds,
            "parameters": {
                one.name: one.parameter.to_json()
                | {"prior_share": one.prior_share, "determined": one.determined}
                for one in each.parameters
            },
        }
        for each in offered
    ]
