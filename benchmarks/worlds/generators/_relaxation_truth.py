"""What is true at every sample of a session of the world `relaxation`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._relaxation_acting import Act, Picture
from benchmarks.worlds.generators._relaxation_shape import Held, contact_m, drawn, equilibria
from benchmarks.worlds.generators._relaxation_specimen import LAYOUT
from benchmarks.worlds.generators._relaxation_strip import Array, Lanes, Setting, Strip
from benchmarks.worlds.session.effects import Acting, Image, Load, Taken
from benchmarks.worlds.session.layout import FRAME, Run, Samples, samples_of

FINER = 4  # places to one point of a curve
RUBBING_ROUNDS = 3  # until the rolls' drag and the sheet's sliding agree

Acts = list[tuple[Act, float]]


def taken(
    strip: Strip, runs: list[Run], design: Design, acts: Sequence[tuple[Acting, float]]
) -> Taken:
    """Return the samples of a configuration and what was true at them."""
    own = [(cast("Act", act), size) for act, size in acts]
    delay = sum(act.delay_s(size) for act, size in own if act.delay_s)
    at = Samples.joined([samples_of(LAYOUT, run, design, delay) for run in runs])
    setting, lanes = Setting(), _lanes(strip, runs, at)
    for act, size in own:
        if act.alters:
            act.alters(setting, strip, size)
    for act, size in own:
        if act.lanes:
            act.lanes(lanes, at, strip, size)
    lanes.eibm_Nm[:] = strip.eibm_Nm(lanes.volts_V) * lanes.gain
    held = _settled(strip, setting, lanes, at, own)
    load = _load(runs, at, lanes, held)
    touched = lanes.free == 0.0
    more = sum((act.felt(load, strip, size) for act, size in own if act.felt), np.zeros(1))
    load.force_N = load.force_N + np.where(touched & held.ok, more, 0.0)
    return Taken(at, load, held.ok, _image(strip, setting, lanes, at, held, design, own))


def _lanes(strip: Strip, runs: list[Run], at: Samples) -> Lanes:
    """Return the base model's circumstances at samples."""
    lanes, of = Lanes.nominal(strip, len(at.run)), {run.number: run for run in runs}

    def each(name: str) -> Array:
        value = {number: getattr(run, name) for number, run in of.items()}
        return np.array([value[number] for number in at.run.tolist()], dtype=float)

    place = _stated(runs, at)
    lanes.free[:] = np.isnan(place)
    lanes.beta_rad[:] = np.nan_to_num(place + each("moved_m")) / strip.radius_m
    lanes.volts_V[:] = at.sheet_V
    lanes.gain[:] = each("eibm")
    lanes.stiffness[:] = each("stiffness")
    return lanes


def _stated(runs: list[Run], at: Samples) -> Array:
    places = {r.number: np.nan if r.position_m is None else r.position_m for r in runs}
    return np.array([places[number] for number in at.run.tolist()], dtype=float)


def _settled(strip: Strip, setting: Setting, lanes: Lanes, at: Samples, acts: Acts) -> Held:
    """Return the equilibria; with rolls that rub, after the sheet has slid."""
    held = equilibria(strip, setting, lanes)
    rubbing = [(act.rubs, size) for act, size in acts if act.rubs]
    for _ in range(RUBBING_ROUNDS if rubbing else 0):
        place = np.where(held.ok, contact_m(strip, lanes, held.at), strip.radius_m)
        lanes.rub[:] = sum(rub(place, at, size) for rub, size in rubbing)
        held = equilibria(strip, setting, lanes)
    return held


def _load(runs: list[Run], at: Samples, lanes: Lanes, held: Held) -> Load:
    def shown(values: Array) -> Array:
        return np.where(held.ok & (lanes.free == 0.0), values, 0.0)

    return Load(
        shown(held.force_N(lanes)), shown(held.outward_N(lanes)), shown(held.lean_rad(lanes)),
        _stated(runs, at), at,
    )  # fmt: skip


def _image(
    strip: Strip, setting: Setting, lanes: Lanes, at: Samples, held: Held, design: Design,
    acts: Acts,
) -> Image:  # fmt: skip
    """Return the frames as they are seen."""
    frames = np.flatnonzero(at.role == FRAME)
    end = strip.length_m + strip.elongation_m
    s = np.linspace(0.0, end, (design.curve_points - 1) * FINER + 1)
    own, solution = lanes.take(frames), held.at.take(frames)
    touch = np.where(own.free > 0.0, 2.0 * end, contact_m(strip, own, solution))
    picture = Picture(strip, at.take(frames), touch, s, *drawn(strip, setting, own, solution, s))
    for act, size in acts:
        if act.seen:
            act.seen(picture, size)
    across = np.tile(s, (len(frames), 1))
    return Image(across, picture.x_m, picture.y_m, picture.phi_rad)
