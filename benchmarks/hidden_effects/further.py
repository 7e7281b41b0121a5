"""The further measurement that a diagnosis asks for, made on the same sheet and rig."""

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
    first: Hidden, bare: Measurements, extra: str, exclude: Sequence[str] = ()
) -> tuple[Measurements, Visible]:
    """Both sessions taken together, and what can be seen in them.

    `extra` is an entry of the menu; `bare` the first session with nothing hidden. Set-ups and noise
    are those of another day, the hidden effect is the same. It is recorded whole, whatever there is
    of the first one.
    """
    case = replace(
        first.case,
        seed=first.case.seed + _DAY,
        further=extra,
        extras=Extras(),
        outlier=False,
        streams="all",
    )
    both = _joined(first.measurements, hidden_session(case).measurements)
    plain = _joined(bare, hidden_session(case.bare).measurements)
    yardstick = Yardstick(plain, case.symmetric)
    return both, yardstick.visible(both, [both], first.truth.names, exclude)


def _joined(first: Measurements, second: Measurements) -> Measurements:
    return together([(Path("first"), first), (Path("second"), second)])
