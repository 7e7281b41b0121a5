"""The free-ended sheet with a force at its tip: of fixed direction, or turning with the tip.

Collocation backward from the tip in the tip's frame. With (t, n) the components of the force on the
sheet over B in that frame: k = k* + c (a n - b t), where a and b are the tip's distance along and
across. The load grows in steps, so that the shape is the one reached from rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, isfinite, sin

import numpy as np

from model.measurements import FloatArray, ModelError
from model.mechanics.collocation import rule
from model.mechanics.equilibrium import check_softness, finer
from model.mechanics.field import Field, merged_breaks

NODES = 12
STEP = 4.0  # of force times length^2 over B, to begin with
LARGEST = 200.0


@dataclass(frozen=True, kw_only=True)
class TipLoaded:
    """The shape under a tip load; angles at the clamp are 0."""

    s_m: FloatArray  # nodes, descending from the tip, then the clamp
    x_m: FloatArray  # of the same points
    y_m: FloatArray
    tip_x_m: float
    tip_y_m: float
    tip_rad: float
    root_moment_per_m: float  # M(0)/B


def tip_load(
    kappa: Field,
    force_per_m2: tuple[float, float],
    follows: bool,
    softness: Field | None = None,
) -> TipLoaded:
    """Equilibrium under the force (x, y) over B on the tip.

    `follows`: the components stay those along and across the tip's direction.
    """
    from model.mechanics.kernel.tip import grow  # numba is slow to import

    along, across = float(force_per_m2[0]), float(force_per_m2[1])
    size, length = hypot(along, across), kappa.length_m
    if not isfinite(size):
        raise ModelError("a tip load must be finite")
    if size * length**2 > LARGEST:
        raise ModelError(
            f"a tip load of {size * length**2:.3g} B/l^2 is beyond any sheet: at most {LARGEST:g}"
        )
    if not isfinite(kappa.largest):
        raise ModelError("the sheet's free curvature is not finite everywhere")
    breaks, bend = kappa.breaks_m, size * length
    if softness is not None:
        check_softness(softness, length)
        bend *= softness.largest
        breaks = merged_breaks([breaks, softness.breaks_m])
    # a load that keeps its direction turns the sheet into it and no further
    breaks = finer(breaks, kappa.largest + (1.0 if follows else 0.4) * bend, length)
    soft = softness.on(breaks).coefficients if softness else np.zeros((len(breaks) - 1, 0))
    out = np.zeros((3, (len(breaks) - 1) * NODES + 1))
    first = min(1.0, STEP / max(bend * length, 1e-300))
    good, tip = grow(
        breaks=breaks,
        kappa=kappa.on(breaks).coefficients,
        soft=soft,
        rule=rule(NODES),
        along=along,
        across=across,
        follows=follows,
        first=first,
        out=out,
    )
    if not good:
        raise ModelError("no equilibrium was found under this tip load: it is too large")
    s, x, y = out
    tip_x, tip_y = float(x[-1]), float(y[-1])
    x[-1] = y[-1] = 0.0
    fx, fy = along, across
    if follows:
        fx, fy = cos(tip) * fx - sin(tip) * fy, sin(tip) * fx + cos(tip) * fy
    return TipLoaded(
        s_m=s,
        x_m=x,
        y_m=y,
        tip_x_m=tip_x,
        tip_y_m=tip_y,
        tip_rad=tip,
        root_moment_per_m=tip_x * fy - tip_y * fx,
    )
