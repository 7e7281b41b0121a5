"""Whether what goes with time may as well go with the position."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from model.identification.data.data_vector import DataVector
from model.identification.data.run_key import RunKey


def positions_in_order(sheets: Iterable[DataVector]) -> bool:
    """Return whether each sheet was measured once at each position, one after the other."""
    return all(_in_order(one) for one in sheets)


def _in_order(one: DataVector) -> bool:
    sessions = dict[int, dict[RunKey, float]]()
    for seen in one.seen:
        if not (seen.free or seen.zero):
            begun = sessions.setdefault(seen.session, {})
            first = float(np.min(seen.clock.session))
            begun[seen.run] = min(begun.get(seen.run, first), first)
    for begun in sessions.values():
        steps_m = np.diff([run[1] for run in sorted(begun, key=lambda run: begun[run])])
        if np.any(steps_m <= 0.0) and np.any(steps_m >= 0.0):
            return False
    return True
