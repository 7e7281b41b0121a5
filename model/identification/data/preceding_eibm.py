"""The EIBM just before the last edge of the voltage, over that after it.

Effects that follow the voltage with a lag begin at what the voltage before had brought. In the
paper's pulse train that is the other polarity; other protocols have several levels, or stairs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from model.identification.data.run_key import RunKey, run_key
from model.measurements import Condition, FloatArray

MOST = 3.0  # by which the EIBM per volt differs from one voltage to the other


@dataclass(frozen=True, kw_only=True)
class PrecedingEibm:
    """Which voltage comes before each reading of each run, and what EIBM a voltage brings."""

    order_V: Mapping[RunKey, Mapping[int, float]] = field(default_factory=dict)  # by index
    per_volt: Mapping[float, float] = field(default_factory=dict)  # in proportion to the EIBM's
    usual_V: Mapping[float, float] = field(default_factory=dict)  # before a voltage, mostly
    rests: bool = False  # between two pulses lies a time at 0 V

    @staticmethod
    def of(conditions: Sequence[Condition], *, rests: bool = False) -> PrecedingEibm:
        """Return those of one configuration. Of the EIBM's size the forces tell, roughly."""
        order_V = dict[RunKey, dict[int, float]]()
        for c in conditions:
            order_V.setdefault(run_key(c), {}).update({r.index: c.voltage_V for r in c.readings})
        pairs = Counter(
            (volts, run[index - 1])
            for run in order_V.values()
            for index, volts in run.items()
            if volts and run.get(index - 1)
        )
        usual_V = {volts: before_V for (volts, before_V), _ in reversed(pairs.most_common())}
        return PrecedingEibm(
            order_V=order_V, per_volt=_moved_per_volt(conditions), usual_V=usual_V, rests=rests
        )

    def voltages_V(self, key: RunKey | None, voltage_V: float, index: Sequence[int]) -> FloatArray:
        """Return the voltage before each reading of this voltage with these indices: (n,).

        Where it is not recorded, the one counts that mostly is before this one, or else the other
        polarity. Between two pulses of the same voltage lies a rest at 0 V.
        """
        if self.rests:
            return np.zeros(len(index))
        run = self.order_V.get(key, {}) if key else {}
        usual_V = self.usual_V.get(voltage_V, -voltage_V)
        found_V = np.array([run.get(one - 1, usual_V) for one in index], dtype=float)
        return np.where(found_V == voltage_V, 0.0, found_V)

    def eibm(self, before_V: FloatArray, voltage_V: float) -> FloatArray:
        """Return the EIBM of voltages (n,) over that of this one, which is not 0 V."""
        return np.array([self._per_volt(v, voltage_V) for v in before_V]) * before_V / voltage_V

    def _per_volt(self, before_V: float, voltage_V: float) -> float:
        sizes = [self.per_volt.get(volts, 0.0) for volts in (before_V, voltage_V)]
        size = sizes[0] / sizes[1] if min(sizes) > 0.0 else 1.0
        return float(np.clip(size, 1.0 / MOST, MOST))


def _moved_per_volt(conditions: Sequence[Condition]) -> dict[float, float]:
    """By how much each volt moves the force from that at 0 V, in the mean over the positions, N."""
    means = dict[tuple[RunKey, float], float]()
    for c in conditions:
        if c.position_m is not None and c.used():
            means[run_key(c), c.voltage_V] = float(np.mean([r.force_N for r in c.used()]))
    moved = dict[float, list[float]]()
    for (key, volts), force_N in means.items():
        if volts and (key, 0.0) in means:
            moved.setdefault(volts, []).append((force_N - means[key, 0.0]) / volts)
    return {volts: abs(float(np.mean(each))) for volts, each in moved.items()}
