"""labrig: `diagnose`, its model written to a file, read back and simulated."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.hidden_effects.predicted import read_back
from benchmarks.hidden_effects.run import name_of, unseen_of
from benchmarks.worlds.methods._contract import Answer
from model import predict
from model.discrepancy import diagnose
from model.measurements import Measurements

RANKED = 8


def answer(measurements: Measurements) -> Answer:
    """Return what labrig says."""
    found = diagnose(measurements)
    ranking = [(r.name, r.log_bayes) for r in found.ranking if not r.name.startswith("unknown")]
    return Answer(
        verdict=found.verdict,
        named=[name_of(n) for n in found.effects],
        unknown=unseen_of(found.unknown),
        invisible=list(found.invisible),
        ranking=ranking[:RANKED],
        base=found.base if found.searched else {},
        closed=float(found.closed) if np.isfinite(found.closed) else None,
        # data that contradict what is stated of them have no model
        foretell=partial(predict, read_back(found.model)) if found.searched else None,
        not_ruled_out=list(found.not_ruled_out),
        choice_sets=[one.to_json() for one in found.choice_sets],
    )
