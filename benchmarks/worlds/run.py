"""Makes the sessions of tasks, asks the methods, and keeps what they say beside what is true."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np

from benchmarks._batched import done
from benchmarks.hidden_effects.predicted import errors, errors_of
from benchmarks.hidden_effects.records import Foretold, Hid, Record
from benchmarks.hidden_effects.run import code_digest
from benchmarks.worlds.base_parameters import beside_truth, true_values
from benchmarks.worlds.cases import Made, Task, made, names
from benchmarks.worlds.conditions import left_out, unmeasured, without
from benchmarks.worlds.methods._contract import Answer, Method
from benchmarks.worlds.registry import digest
from model import SheetModel
from model.identification.fit import fit
from model.measurements import Measurements

METHODS = Path(__file__).parent / "methods"


def methods() -> tuple[str, ...]:
    """Return the names of the methods in their folder."""
    return tuple(sorted(p.stem for p in METHODS.glob("*.py") if not p.stem.startswith("_")))


def method(name: str) -> Method:
    """Return a method; raise `ValueError` where there is none."""
    if name not in methods():
        raise ValueError(f"there is no method '{name}'; there are {', '.join(methods())}")
    found: Method = import_module(f"benchmarks.worlds.methods.{name}").answer
    return found


def run(todo: Sequence[Task], jobs: int) -> Iterator[list[Record]]:
    """Yield the records of each task as they are done, in `jobs` processes."""
    return done(todo, jobs, records, _lost)


def records(task: Task) -> list[Record]:
    """Make the session, and ask each method."""
    try:
        one = made(task)
    except Exception as error:  # noqa: BLE001 - one session less, and it is told
        return _not_made(task, f"{type(error).__name__}: {error}")
    truth = _truth(one)
    return [_asked(one, replace(truth, method=name, key=key(task, name))) for name in task.methods]


def key(task: Task, name: str) -> str:
    """Return the key of a method's record of a task."""
    return f"{task.key}/{name}"


def _lost(task: Task, error: BaseException) -> list[Record]:
    return _not_made(task, str(error))


def _not_made(task: Task, why: str) -> list[Record]:
    plain = Record(
        key="", family=task.family, code=_code(task), truth=[], near={}, left={},
        left_tolerant={}, force_gap_mN=0.0, curve_gap_mm=0.0, conditions=_in_words(task),
        error=f"not made: {why}",
    )  # fmt: skip
    return [replace(plain, method=name, key=key(task, name)) for name in task.methods]


def _code(task: Task) -> str:
    """Return what has a say in an answer: the states of the program and of the generator."""
    return f"{code_digest()}/{digest(task.world)[:10]}"


def _in_words(task: Task) -> str:
    return "free shapes, remounts, random order" if task.thorough else ""


def _truth(one: Made) -> Record:
    """Return the record of a session that nobody has been asked about."""
    visible, truth = one.visible, []
    called = zip(names(one.world, one.sizes), one.sizes.items(), strict=True)
    for (name, (kind, size)), d, alone in zip(called, visible.d, visible.alone, strict=True):
        told = one.world.kinds[kind]
        truth.append(Hid(
            effect=name, form=kind, size=size, slot=told.locations[0],
            accepted_slots=list(told.locations), place_mm=None,
            parameters=dict(one.world.parameters(kind, size)), as_in_catalogue=told.own_form,
            d=d, alone=alone,
        ))  # fmt: skip
    return Record(
        key="", family=one.task.family, code=_code(one.task), truth=truth, near=dict(visible.near),
        left=dict(visible.left), left_tolerant=dict(visible.left_tolerant), force_gap_mN=0.0,
        curve_gap_mm=0.0, conditions=_in_words(one.task),
    )  # fmt: skip


def _asked(one: Made, kept: Record) -> Record:
    """Ask a method, and compare what it foretells with what nobody measured."""
    ask = method(kept.method)
    began, cpu = time.perf_counter(), time.process_time()
    try:
        said = ask(one.session)
    except Exception as error:  # noqa: BLE001 - whatever it is, the case has failed
        return replace(kept, error=f"{type(error).__name__}: {error}")
    kept = replace(
        kept, verdict=_verdict(said), named=said.named, unknown=said.unknown,
        invisible=said.invisible, ranking=said.ranking, closed=said.closed,
        choice_sets=said.choice_sets, not_ruled_out=said.not_ruled_out,
        seconds=time.perf_counter() - began,
        cpu_s=time.process_time() - cpu,
    )  # fmt: skip
    if said.base:
        true = true_values(one.world, one.task.seed, one.task.design)
        kept = replace(kept, base=beside_truth(said.base, true))
    if not one.sizes or said.foretell is None:
        return kept
    try:
        kept = replace(kept, foretold=_foretold(one, said))
        if one.task.left_out:
            kept = replace(kept, left_out=_left_out(one, ask))
    except Exception as error:  # noqa: BLE001 - whatever it is, the case has failed
        return replace(kept, error=f"prediction: {type(error).__name__}: {error}")
    return kept


def _verdict(said: Answer) -> str:
    """Return what a method says in the words of `diagnose`."""
    if said.verdict:
        return said.verdict
    if said.unknown is not None:
        return "unknown_effect"
    if any(one.confusable_with for one in said.named):
        return "indistinguishable"
    return "effect_named" if said.named else "nothing_missing"


def _base(measurements: Measurements) -> SheetModel:
    return fit(measurements).model


def _foretold(one: Made, said: Answer) -> Foretold:
    """Compare with conditions half-way between the session's, without noise."""
    assert said.foretell is not None
    seed, design = one.task.seed, one.task.design
    truth = unmeasured(one.world, one.sizes, seed, design)
    plain = unmeasured(one.world, {}, seed, design)
    return Foretold(
        base=errors(_base(one.session), truth), written=errors_of(said.foretell, truth),
        floor=errors(_base(one.bare), plain),
    )  # fmt: skip


def _left_out(one: Made, ask: Method) -> Foretold | None:
    """Ask again without one position, and compare with what is true there."""
    positions = sorted({c.position_m for c in one.session.conditions if c.position_m is not None})
    place = positions[one.task.seed % len(positions)]
    part, bare = without(one.session, place), without(one.bare, place)
    truth, plain = (
        left_out(one.world, hidden, one.task.seed, one.task.design, place)
        for hidden in (one.sizes, {})
    )
    said = ask(part)
    if said.foretell is None or not (truth and plain):
        return None
    floor = errors(_base(bare), plain)
    if not np.all(np.isfinite(floor)):
        return None
    return Foretold(
        base=errors(_base(part), truth), written=errors_of(said.foretell, truth), floor=floor
    )
