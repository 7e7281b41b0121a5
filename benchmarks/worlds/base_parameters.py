"""B and EIBM: what is true of them in a world, and how often their 90 % intervals hold it.

A generator does not tell its B and EIBM. A session of it without noise, in nominal set-ups and with
nothing hidden does: the base model fitted to it has them to 1e-4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.score import SEEN, exactly
from benchmarks.worlds.contract import Design, World
from model.identification.fit import fit
from model.parameter import Parameter

Table = Mapping[str, Mapping[str, Parameter]]  # configuration -> quantity -> value, as `diagnose`
STIFFNESS = "B_Nm2"


def true_values(one: World, seed: int, recorded: Design) -> dict[str, float]:
    """Return B (N m^2) and the EIBM (N m) at each voltage, by configuration and quantity."""
    plain = replace(recorded, series=False, free_shapes=0, remounts=0)
    found = fit(one.measure(plain, {}, seed, exact=True)).model
    result = dict[str, float]()
    for name, sheet in found.sheets.items():
        result[_key(name, STIFFNESS)] = sheet.B.value
        for volts, along in sheet.eibm.items():
            result[_key(name, f"EIBM {volts:+g} V")] = float(along.values[0])
    return result


def beside_truth(said: Table, true: Mapping[str, float]) -> dict[str, list[float]]:
    """Return value, ends of the 90 % interval and true value of what was said."""
    told = {_key(name, what): one for name, own in said.items() for what, one in own.items()}
    return {
        key: [one.value, *one.interval(), true[key]] for key, one in told.items() if key in true
    }


@dataclass(frozen=True)
class Held:
    """Whether an interval holds the truth."""

    key: str  # of the case
    quantity: str
    ok: bool


def held(records: Sequence[Record]) -> list[Held]:
    """Return the intervals of all cases.

    Of right verdicts, where what is hidden has the catalogue's own form: with another form B and
    EIBM mean something else.
    """
    return [
        Held(r.key, key.split(": ")[1], low <= true <= high)
        for r in records if _counts(r)
        for key, (_, low, high, true) in r.base.items()
    ]  # fmt: skip


def by_quantity(records: Sequence[Record]) -> list[tuple[str, str]]:
    """Return for each quantity how many intervals hold the truth, of how many."""
    told: dict[str, list[bool]] = {}
    for one in held(records):
        told.setdefault(one.quantity, []).append(one.ok)
    return [(name, f"{sum(own)}/{len(own)}") for name, own in sorted(told.items())]


def _counts(r: Record) -> bool:
    if r.family == "nothing":
        return not r.said and r.unknown is None
    return exactly(r) and r.d >= SEEN and all(t.as_in_catalogue for t in r.truth)


def _key(configuration: str, quantity: str) -> str:
    return f"{configuration}: {quantity}"
