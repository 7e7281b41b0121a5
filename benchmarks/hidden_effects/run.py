"""Makes the sessions of tasks, has them diagnosed, and keeps what was said beside what is true."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from benchmarks._batched import done
from benchmarks.hidden_effects.cases import Case, Hiding
from benchmarks.hidden_effects.further import with_further
from benchmarks.hidden_effects.records import Further, Hid, Name, Record, Unseen
from benchmarks.hidden_effects.registry import form_of
from benchmarks.hidden_effects.sessions import Hidden, hidden_session
from benchmarks.hidden_effects.sizes import curve_gap_mm, force_gap_mN, size_for, size_for_gap
from benchmarks.hidden_effects.suite import Task, as_in_catalogue
from benchmarks.hidden_effects.visible import Visible, Yardstick
from labrig.experiment.next_measurement.closed_loop import MOST_ROUNDS, to_measure
from model import Measurements
from model.discrepancy import DiagnoseOptions, Diagnosis, Named, Unknown, diagnose

TOLERANCE = 0.15  # of a size found for a wanted d or gap
ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Made:
    """A session with all that is known of it."""

    task: Task
    hidden: Hidden
    bare: Measurements
    visible: Visible


def made(task: Task) -> Made:
    """The session, the sizes of what is hidden found as wanted."""
    bare = hidden_session(task.case.bare)
    if not task.case.hidden:
        return Made(task, bare, bare.measurements, Visible((), (), {}, {}, {}))
    yardstick = Yardstick(bare.measurements, task.case.symmetric)
    alone = [replace(task.case, hidden=(h,)) for h in task.case.hidden]
    if task.sizing != "form":
        alone = [_sized(c, task, w, yardstick) for c, w in zip(alone, task.wanted, strict=True)]
    case = replace(task.case, hidden=tuple(c.hidden[0] for c in alone))
    hidden = hidden_session(case)
    parts = [hidden] if len(alone) == 1 else [hidden_session(c) for c in alone]
    visible = yardstick.visible(
        hidden.measurements, [p.measurements for p in parts], hidden.truth.names, task.exclude
    )
    return Made(task, hidden, bare.measurements, visible)


def _sized(case: Case, task: Task, wanted: float, yardstick: Yardstick) -> Case:
    """With the size at which its one effect is as large as wanted, or the largest there is."""
    (hiding,) = case.hidden
    form = form_of(hiding.effect, hiding.form)
    try:
        if task.sizing == "gap":
            size = size_for_gap(case, wanted, TOLERANCE)
        else:
            size = size_for(case, wanted, yardstick.length, TOLERANCE)
    except ValueError:  # not even the largest that makes sense
        size = form.size if task.sizing == "gap" else form.largest
    if task.family == "means_only":  # no effect so large that it would be seen in any data
        size = min(size, form.size)
    return replace(case, hidden=(Hiding(hiding.effect, form.form, size),))


def options_of(task: Task) -> DiagnoseOptions:
    """As a person would choose them who knows how the session was measured."""
    return DiagnoseOptions(
        symmetric=task.case.symmetric, exclude=task.exclude, calibrate=task.calibrate
    )


Baselines = Callable[[Made], dict[str, dict[str, object]]]


def record(task: Task, baselines: Baselines | None = None) -> Record:
    """Make, diagnose, and put down."""
    try:
        one = made(task)
    except Exception as error:  # noqa: BLE001 - one session less, and it is told
        return _not_made(task, f"{type(error).__name__}: {error}")
    kept = _truth(one)
    began, cpu = time.perf_counter(), time.process_time()
    try:
        found = diagnose(one.hidden.measurements, options_of(task))
    except Exception as error:  # noqa: BLE001 - whatever it is, the case has failed
        return replace(kept, error=f"{type(error).__name__}: {error}")
    kept = answered(kept, found)
    kept = replace(kept, seconds=time.perf_counter() - began, cpu_s=time.process_time() - cpu)
    if task.family == "ambiguous":
        kept = _measured_further(one, found, kept)
    return kept if baselines is None else replace(kept, baselines=baselines(one))


def _measured_further(one: Made, found: Diagnosis, first: Record) -> Record:
    """What all sessions together say, measured one after the other as `run --diagnose` does.

    As it was where nothing is proposed.
    """
    now, extras, expected = first, list[str](), 0.0
    while (wanted := to_measure(found)[0]) and len(extras) < MOST_ROUNDS:
        extras.append(wanted.extra)
        expected = expected or wanted.expected
        further = Further(
            ", ".join(extras), list(first.said), sorted(first.reported), first.nearest, expected
        )
        try:
            whole, visible = with_further(one.hidden, one.bare, extras, one.task.exclude)
            found = diagnose(whole, options_of(one.task))
        except Exception as error:  # noqa: BLE001 - whatever it is, the case has failed
            return replace(now, further=further, error=f"{type(error).__name__}: {error}")
        truth = [
            replace(t, d=d, alone=alone)
            for t, d, alone in zip(first.truth, visible.d, visible.alone, strict=True)
        ]
        seen = replace(
            first,
            truth=truth,
            near=dict(visible.near),
            left=dict(visible.left),
            left_tolerant=dict(visible.left_tolerant),
            further=further,
        )
        now = answered(seen, found)
    return now


def _not_made(task: Task, why: str) -> Record:
    return Record(
        key=task.key,
        family=task.family,
        code=code_digest(),
        truth=[],
        near={},
        left={},
        left_tolerant={},
        force_gap_mN=0.0,
        curve_gap_mm=0.0,
        conditions=_in_words(task),
        error=f"not made: {why}",
    )


def _truth(one: Made) -> Record:
    visible = one.visible
    truth = [
        Hid(
            effect=e.effect,
            form=e.form,
            size=e.size,
            slot=e.slot,
            accepted_slots=list(e.accepted_slots),
            place_mm=None if e.place_mm is None else list(e.place_mm),
            parameters=e.parameters,
            as_in_catalogue=as_in_catalogue(e.effect, e.form),
            d=d,
            alone=alone,
        )
        for e, d, alone in zip(one.hidden.truth.effects, visible.d, visible.alone, strict=True)
    ]
    gaps = (0.0, 0.0)
    if truth:
        gaps = force_gap_mN(one.hidden, one.bare), curve_gap_mm(one.hidden, one.bare)
    return Record(
        one.task.key,
        one.task.family,
        code_digest(),
        truth,
        dict(visible.near),
        dict(visible.left),
        dict(visible.left_tolerant),
        *gaps,
        _in_words(one.task),
    )


def _in_words(task: Task) -> str:
    case, words = task.case, []
    if case.scatter != 1.0:
        words.append(f"scatter x {case.scatter:g}")
    words += [w for w in ("outlier", "correlated", "symmetric") if getattr(case, w)]
    if case.streams == "means":
        words.append("means only")
    if case.rest != "exp":
        words.append(f"rest {case.rest}")
    if case.extras != type(case.extras)():
        words.append("extras")
    if task.exclude:
        words.append("without " + ", ".join(task.exclude))
    return "; ".join(words)


def answered(kept: Record, found: Diagnosis) -> Record:
    """Add what a diagnosis says."""
    return replace(
        kept,
        verdict=found.verdict,
        sentence=found.sentence,
        named=[name_of(n) for n in found.effects],
        unknown=unseen_of(found.unknown),
        invisible=list(found.invisible),
        ranking=[(r.name, r.log_bayes) for r in found.ranking if not r.name.startswith("unknown")][
            :8
        ],
        closed=float(found.closed) if np.isfinite(found.closed) else None,
        chi2_before=found.held_out.before.chi2_per_dof,
    )


def unseen_of(unknown: Unknown | None) -> Unseen | None:
    """Return what is kept of an unknown."""
    if unknown is None:
        return None
    return Unseen(
        unknown.location, unknown.configuration, unknown.along, unknown.peak_mm,
        list(unknown.confusable_with), dict(unknown.locations),
    )  # fmt: skip


def name_of(one: Named) -> Name:
    """Return what is kept of an effect that was named."""
    by: dict[str, dict[str, list[float]]] = {}
    own = one.by_configuration or {"": one.parameters}
    for configuration, parameters in own.items():
        for name, p in parameters.items():
            by.setdefault(name, {})[configuration] = [p.value, *p.interval()]
    return Name(
        one.name, one.confidence, list(one.confusable_with), one.form_share, by, list(one.or_else)
    )


@cache
def code_digest() -> str:
    """Of everything that has a say in the answers."""
    digest = hashlib.sha256()
    for folder in ("model", "sim_hardware/world"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:10]


def run(todo: Sequence[Task], jobs: int, baselines: Baselines | None = None) -> Iterator[Record]:
    """Yield records as they are done, in `jobs` processes."""
    return done(todo, jobs, partial(record, baselines=baselines), _lost)


def _lost(task: Task, error: BaseException) -> Record:
    return _not_made(task, str(error))
