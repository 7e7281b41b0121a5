"""Which effects would be seen in the data, and from which amplitude on."""

from __future__ import annotations

from labrig.report.parts.table import Table, number
from model.discrepancy.verdict.messages import listed
from model.discrepancy.verdict.result import Diagnosis
from model.effects import catalogue, title


def visibility(found: Diagnosis) -> list[str]:
    """Return which effects the data could have shown at all, and which were tried."""
    return [
        *_seen(found),
        *_tried_of_others(found),
        *(
            "Indistinguishable in these data, at the size found or when just seen:"
            f" {listed([title(n) for n in one])}."
            for one in found.classes
        ),
    ]


def _seen(found: Diagnosis) -> list[str]:
    names = found.signatures.names
    if not names:
        return []
    seen = len(names) - len([n for n in names if n in found.invisible])
    several = [
        name
        for name, effect in catalogue().items()
        if name not in (*names, *found.invisible) and effect.for_sessions(1) is None
    ]
    said = f"{seen} of {len(names)} effects would be seen in these data if large."
    if not several:
        return [said]
    need = "need" if len(several) > 1 else "needs"
    return [f"{said} {len(several)} more {need} several sessions, given together."]


def _tried_of_others(found: Diagnosis) -> list[str]:
    """Return the effects of other distributions that were tried and are not named."""
    named = {one.name for one in found.effects}
    tried = [
        f"{title(name)} ({found.plugins[name]})"
        for name in found.signatures.names
        if name in found.plugins and name not in named
    ]
    return [f"Also tried: {listed(tried)}."] if tried else []


def limits_table(found: Diagnosis) -> Table | None:
    """Return detection limits beside what is named, of effects that are not; the tightest first."""
    some = [item for item in found.limits.items() if item[0] not in found.invisible]
    if not some:
        return None
    some.sort(key=lambda item: item[1].ratio)
    rows = tuple(
        (
            title(name),
            one.parameter,
            number(one.value),
            one.unit or "-",
            number(one.ratio),
        )
        for name, one in some
    )
    return Table(
        title="Detection limits",
        columns=("effect", "parameter", "seen from", "unit", "over its usual size"),
        rows=rows,
        note="Less than that (4 standard deviations, beside what is named) is not ruled out.",
    )
