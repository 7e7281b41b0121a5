"""The strip of the world `legendre` with all that is hidden in it.

A setting names what it changes: functions of s and the sheet are added to the rest curvature and
to the even moment (`rest`, `even`), or multiply EIBM and softness (`profile`, `soft`); numbers are
added to the strip's field of that name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.worlds.generators._legendre_ritz import Array, Strip
from benchmarks.worlds.generators._legendre_specimen import RADIUS_M, Specimen
from benchmarks.worlds.session.effects import Acting

Along = Callable[[Array, Specimen], Array]
ADDED = {"rest": "rest_per_m", "even": "even_per_m"}
FACTORS = {"profile": "driven_per_m", "soft": "soft"}


def strip_of(true: Specimen, acts: Sequence[tuple[Acting, float]]) -> Strip:
    """Return the strip."""
    true = _lengthened(true, acts)
    s, rest = true.grid()
    strip = Strip(
        s_m=s, rest_per_m=rest, driven_per_m=np.full(len(s), true.eibm_per_m),
        even_per_m=np.zeros(len(s)), soft=np.ones(len(s)), stiffness_Nm2=true.stiffness_Nm2,
        radius_m=RADIUS_M, elongation_m=true.elongation_m,
    )  # fmt: skip
    for one, size in acts:
        if one.law is not None:
            strip = replace(strip, law=one.law(size))
        for name, value in (one.setting(size) if one.setting else {}).items():
            if name != "longer":
                strip = _changed(strip, true, name, value)
    return strip


def _changed(strip: Strip, true: Specimen, name: str, value: float | Along) -> Strip:
    if not callable(value):
        return replace(strip, **{name: getattr(strip, name) + value})
    along = value(strip.s_m, true)
    if name in ADDED:
        return replace(strip, **{ADDED[name]: getattr(strip, ADDED[name]) + along})
    return replace(strip, **{FACTORS[name]: getattr(strip, FACTORS[name]) * along})


def _lengthened(true: Specimen, acts: Sequence[tuple[Acting, float]]) -> Specimen:
    """Return a sheet of which a piece has come out of the clamp: it bends as its neighbour does."""
    out = sum(one.setting(size).get("longer", 0.0) for one, size in acts if one.setting)
    if not out:
        return true
    nodes = np.concatenate([[0.0], np.maximum(true.nodes_m + out, 0.0)])
    rest = np.concatenate([true.rest_per_m[:1], true.rest_per_m])
    return replace(true, length_m=true.length_m + out, nodes_m=nodes, rest_per_m=rest)


def mean_one(shape: Array) -> Array:
    """Return a shape on the strip's grid over its mean."""
    return np.asarray(shape / np.mean(0.5 * (shape[1:] + shape[:-1])))


def only(name: str, along: Along, else_: float = 0.0) -> Along:
    """Return what acts in one configuration alone."""
    return lambda s, true: along(s, true) if true.name == name else np.full(len(s), else_)
