"""Gradient-boosted trees on the evidence of all signatures, trained on open worlds.

python -m benchmarks.worlds.methods.boosted --cases 300 --seed 500000 --jobs 2

makes the training sessions and keeps their features and labels in `TRAINED`; further cases are
added to those that are there. One classifier for each effect, and one for 'in no catalogue', each
a probability; what is more likely than not is named. Needs scikit-learn (`pip install -e
".[worlds]"`).
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: a process is a core here

import argparse
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from benchmarks._batched import done
from benchmarks.hidden_effects.records import Name, Unseen
from benchmarks.hidden_effects.run import ROOT
from benchmarks.worlds.cases import Task, made, names, tasks
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.methods._foretell import likeliest_shapes, of_effects
from benchmarks.worlds.methods._signatures import Started
from benchmarks.worlds.sealed import open_worlds
from model.discrepancy.search.evidence import Projected, score
from model.discrepancy.search.nonparametric_terms import unknowns
from model.measurements import FloatArray, Measurements

TRAINED = ROOT / "benchmarks" / "results" / "boosted.npz"
OUTSIDE = "unknown"
FEWEST = 4  # cases of an effect from which it can be learned
LIKELY = 0.5
TREES = 60
TRAINING_SEEDS_FROM = 500_000  # seeds from here on are for training, others never are


def answer(measurements: Measurements) -> Answer:
    """Return what is more likely than not; raise `ValueError` where nothing was trained."""
    started = Started.of(measurements)
    chances = {name: p for name, p in _chances(features(started)).items() if p > LIKELY}
    unknown = Unseen("", "", "", 0.0) if OUTSIDE in chances else None
    named = sorted((p, name) for name, p in chances.items() if name != OUTSIDE)
    chosen = likeliest_shapes(started.base, started.pool, [name for _, name in named])
    return Answer(
        named=[Name(n, p, [], 0.0, {}) for p, n in named[::-1]], unknown=unknown,
        foretell=of_effects(started.base, chosen, measurements),
    )  # fmt: skip


def features(started: Started) -> FloatArray:
    """Return the evidence of each effect and each location, and each less the largest."""
    forward, base = started.base.problem.forward, started.base
    projected = Projected.of(forward, base.linear, base.solution)
    best: dict[str, float] = {}
    for one in (*started.pool, *unknowns(base)):
        told = f"{one.name} {one.part}"
        best[told] = max(best.get(told, -np.inf), score(forward, projected, one).log_bayes)
    values = np.array([best[k] for k in sorted(best)])
    squeezed = np.sign(values) * np.log1p(np.abs(values))
    return np.concatenate([squeezed, np.tanh((values - np.max(values)) / 10.0)])


def _chances(one: FloatArray) -> dict[str, float]:
    if not TRAINED.exists():
        raise ValueError(f"{TRAINED} is missing: run python -m benchmarks.worlds.methods.boosted")
    return {
        name: float(trees.predict_proba(one[None, :])[0, 1])
        for name, trees in _trained().items()
    }  # fmt: skip


@cache
def _trained() -> dict[str, Any]:
    with np.load(TRAINED) as kept:
        return learned(kept["features"], [str(t).split("+") for t in kept["truth"]])


def learned(rows: FloatArray, truth: Sequence[Sequence[str]]) -> dict[str, Any]:
    """Return a classifier for each label that is there often enough."""
    from sklearn.ensemble import GradientBoostingClassifier

    result = {}
    for name in sorted({n for own in truth for n in own if n}):
        there = np.array([name in own for own in truth])
        if FEWEST <= there.sum() < len(there):
            trees = GradientBoostingClassifier(
                n_estimators=TREES, max_depth=3, max_features="sqrt", random_state=0
            )
            result[name] = trees.fit(rows, there)
    return result


# ------------------------------------------------------------------------------ training


def example(task: Task) -> tuple[str, FloatArray, str]:
    """Return the key of a case, its features and what is hidden; no features: it failed."""
    try:
        one = made(task)
        found = features(Started.of(one.session))
    except Exception as error:  # noqa: BLE001 - one example less, and it is told
        return task.key, np.zeros(0), f"{type(error).__name__}: {error}"
    told = [OUTSIDE] if task.family == "outside" else names(one.world, one.sizes)
    return task.key, found, "+".join(told)


def _lost(task: Task, error: BaseException) -> tuple[str, FloatArray, str]:
    del error
    return task.key, np.zeros(0), "its process was killed"


def _kept() -> dict[str, tuple[FloatArray, str]]:
    if not TRAINED.exists():
        return {}
    with np.load(TRAINED) as kept:
        columns = (kept[k] for k in ("keys", "features", "truth"))
        return {str(k): (f, str(t)) for k, f, t in zip(*columns, strict=True)}


def _keep(examples: Mapping[str, tuple[FloatArray, str]]) -> None:
    TRAINED.parent.mkdir(parents=True, exist_ok=True)
    found, truth = zip(*examples.values(), strict=True)
    np.savez_compressed(
        TRAINED, keys=np.array(list(examples)), features=np.array(found), truth=np.array(truth)
    )


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.worlds.methods.boosted")
    parser.add_argument("--cases", type=int, default=300, help="of each open world (default: 300)")
    parser.add_argument("--seed", type=int, default=TRAINING_SEEDS_FROM)
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    if chosen.seed < TRAINING_SEEDS_FROM:
        print(f"seeds for training begin at {TRAINING_SEEDS_FROM}", file=sys.stderr)
        return 2
    examples = _kept()
    todo = [
        t for name in open_worlds() for t in tasks(name, chosen.cases, chosen.seed)
        if t.key not in examples
    ]  # fmt: skip
    for i, (key, found, truth) in enumerate(done(todo, chosen.jobs, example, _lost), 1):
        print(f"{i}/{len(todo)} {key} {truth or 'nothing'}", file=sys.stderr, flush=True)
        if len(found):
            examples[key] = (found, truth)
            _keep(examples)
    print(f"{len(examples)} examples in {TRAINED}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
