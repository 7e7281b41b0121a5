"""The further measurements that a diagnosis asks for, made on the same sheet and rig."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.hidden_effects.cases import Extras
from benchmarks.hidden_effects.sessions import Hidden, hidden_session
from benchmarks.hidden_effects.visible import Visible, Yardstick
from labrig.analysis.together import together
from model import Measurements

_DAY = 2**31  # from the seed of a session, below this, to that of its further one


def with_further(
    first: Hidden, bare: Measurements, extras: Sequence[str], exclude: Sequence[str] = ()
) -> tuple[Measurements, Visible]:
    """All sessions taken together, and what can be seen in them.

    `extras` are entries of the menu, each measured on a day of its own; `bare` is the first session
    with nothing hidden. Set-ups and noise are those of another day, the hidden effect is the same.
    They are recorded whole, whatever there is of the first one.
    """
    cases = [
        replace(
            first.case, seed=first.case.seed + day * _DAY, further=extra, extras=Extras(),
            outlier=False, streams="all",
        )
        for day, extra in enumerate(extras, 1)
    ]  # fmt: skip
    whole = _joined([first.measurements, *(hidden_session(c).measurements for c in cases)])
    plain = _joined([bare, *(hidden_session(c.bare).measurements for c in cases)])
    yardstick = Yardstick(plain, first.case.symmetric)
    return whole, yardstick.visible(whole, [whole], first.truth.names, exclude)


def _joined(sessions: Sequence[Measurements]) -> Measurements:
    return together([(Path(f"session {i}"), one) for i, one in enumerate(sessions)])
