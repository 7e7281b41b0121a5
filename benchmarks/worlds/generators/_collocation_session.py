"""A day at the rig: specimens, order, clocks, set-ups, noise, and the table that comes out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._collocation_bvp import A, Strip
from benchmarks.worlds.generators._collocation_plant import (
    HZ,
    RISE_S,
    Course,
    Grid,
    Plant,
    Stay,
    course,
    grids,
    seen_m,
    shown_N,
)
from model.measurements import (
    Condition,
    Curve,
    Kind,
    Measurements,
    Reading,
    SheetGeometry,
    TimeSeries,
)

PAUSE_S, MOIST_S = 55.0, 20.0
# set-ups, of which the stage's step is a part of the position's
EIBM, STIFFNESS, MOVED_M, STEP_M = 0.01, 0.01, 4.5e-5, 6e-5
# noise
WHITE_N, PINK_N, SAMPLE_N, ADC_N = 2.2e-5, 1.0e-5, 5e-5, 1e-5
FRAME_M, IMAGE_M, WAVES = 4e-5, 1.8e-5, 4


def specimens(seed: int) -> dict[str, Strip]:
    """Return the strips of a seed as they are when nothing is hidden."""
    rng = np.random.default_rng((seed, 11))
    made = {}
    for name, free_m, bar_m, B, falls, bent, plus, ratio in (
        ("long", 0.050, 0.0, 1.5e-6, 0.6, 25.0, 26.0, 0.9),
        ("short", 0.0045, 0.0475, 1.0e-6, 0.0, 27.0, 60.0, 0.8),
    ):
        draw = rng.uniform(-1.0, 1.0, 4)
        rest = bent * (1.0 + 0.15 * draw[0])

        def k0(s: A, rest: float = rest, falls: float = falls, free_m: float = free_m) -> A:
            return rest * (1.0 - falls * s / free_m)

        up = plus * (1.0 + 0.2 * draw[1])
        made[name] = Strip(
            name=name,
            free_m=free_m,
            bar_m=bar_m,
            arc_m=0.041,
            B_Nm2=B * (1.0 + 0.2 * draw[2]),
            bends_per_m=(up, -up * ratio * (1.0 + 0.12 * draw[3])),
            k0=[k0],
        )
    return made


def stated(strip: Strip) -> SheetGeometry:
    """Return what the operator knows; the rest curvature is linear in s and stated as it is."""
    s = np.linspace(0.0, strip.free_m, 6)
    return SheetGeometry(
        configuration=strip.name,
        free_length_m=strip.free_m,
        width_m=0.011,
        thickness_m=0.00021,
        elongation_m=strip.bar_m,
        arc_radius_m=strip.arc_m,
        arc_origin_rad=0.0,
        initial_curvature=(s, strip.stated(s)),
        rise_time_s=RISE_S,
        clamped_length_m=0.0015,
    )


# -------------------------------------------------------------------------------- order


def stays(design: Design, seed: int, exact: bool) -> list[Stay]:
    """Return where the load cell stands, and when."""
    rng = np.random.default_rng((seed, 12))
    phase_m = STEP_M * rng.uniform()
    lasts_s = (3 * design.readings + design.discarded) * design.pulse_s
    order = [stop for name in design.positions_m for stop in _stops(design, name, rng)]
    pause = PAUSE_S * (1.0 if exact else rng.uniform(0.7, 1.3, len(order)))
    begin = np.cumsum(np.ones(len(order)) * (pause + lasts_s)) - lasts_s
    end = float(begin[-1]) + lasts_s
    made: list[Stay] = []
    for (name, place, mounting), from_s in zip(order, begin.tolist(), strict=True):
        wrong, eibm, stiff, moist = rng.normal(size=4) * (0.0 if exact else 1.0)
        stay = _stay(design, name, place, end / 2.0 if exact else from_s)
        stay.mounting, stay.moist_s = mounting, MOIST_S * (1.0 + 0.1 * np.tanh(moist))
        stay.share = np.full_like(stay.t, 0.5) if exact else (from_s + stay.t) / end
        stay.eibm, stay.stiffness = 1.0 + EIBM * eibm, 1.0 + STIFFNESS * stiff
        if place is not None and not exact:
            stepped = STEP_M * np.round((place + phase_m) / STEP_M) - place - phase_m
            stay.wrong_m = float(MOVED_M * wrong + stepped)
        same = bool(made) and made[-1].configuration == name and made[-1].stated_m is not None
        stay.approach = "" if place is None else "up"
        if same and place is not None and place < (made[-1].stated_m or 0.0):
            stay.approach = "down"
        made.append(stay)
    return made


def _stops(
    design: Design, name: str, rng: np.random.Generator
) -> list[tuple[str, float | None, int]]:
    """Return configuration, position and mounting in their order; free shapes come first."""
    places = design.positions_m[name]
    stops = [(p, 0) for p in places]
    spread = [places[(len(places) // 2 + i) % len(places)] for i in range(len(places))]
    stops += [(spread[i % len(places)], 1 + i // len(places)) for i in range(design.remounts)]
    if design.random_order:
        stops = [stops[i] for i in rng.permutation(len(stops)).tolist()]
    free: list[tuple[str, float | None, int]] = [(name, None, i) for i in range(design.free_shapes)]
    return free + [(name, p, m) for p, m in stops]


def _stay(design: Design, name: str, place: float | None, from_s: float) -> Stay:
    zeros, driven = design.readings, design.discarded + 2 * design.readings
    t = (np.arange(round((zeros + driven) * design.pulse_s * HZ)) + 0.5) / HZ
    number = np.clip(np.floor(t / design.pulse_s + 1e-9), 0, zeros + driven - 1)
    count = np.maximum(number - zeros, -1.0)
    volts = np.where(count % 2 == 0, *design.voltages_V)
    return Stay(
        configuration=name,
        stated_m=place,
        mounting=0,
        approach="",
        from_s=from_s,
        moist_s=0.0,
        sample_s=design.sample_s,
        t=t,
        volts=np.where(count < 0, 0.0, volts),
        count=count,
        age_s=t - number * design.pulse_s,
        share=np.zeros_like(t),
        worked=np.maximum(t - zeros * design.pulse_s, 0.0) / 13.2,
    )


# -------------------------------------------------------------------------------- noise


class Noise:
    """White and pink noise, and the steps of a converter; nothing of it knows what is hidden."""

    def __init__(self, seed: int, exact: bool) -> None:
        self.rng = np.random.default_rng((seed, 13))
        self.on = 0.0 if exact else 1.0

    def pink_N(self, count: int) -> A:
        """Return noise whose power falls as 1/f, over the samples of a stay."""
        spectrum = self.rng.normal(size=(2, count // 2 + 1)).T @ np.array([1.0, 1j])
        frequency = np.arange(len(spectrum))
        spectrum[1:] /= np.sqrt(frequency[1:])
        spectrum[0] = spectrum[1]
        usual = np.sqrt(2.0 * np.sum(1.0 / frequency[1:]) + 1.0) * np.sqrt(2.0) / count
        return np.asarray(PINK_N * np.fft.irfft(spectrum, count) / usual * self.on)

    def read_N(self, pink: A, sigma_N: float) -> A:
        """Return what the converter adds: its steps fall anywhere on what it reads."""
        noise = pink + sigma_N * self.rng.normal(size=len(pink))
        phase = self.rng.uniform(0.0, ADC_N, len(pink))
        return np.asarray(self.on * (ADC_N * np.round((noise + phase) / ADC_N) - phase))

    def frames_m(self, count: int, points: int) -> A:
        """Return displacements of single points."""
        return self.on * FRAME_M * self.rng.normal(size=(count, points))

    def image_m(self, points: int) -> A:
        """Return a smooth displacement, as an uneven background makes it."""
        waves = self.rng.normal(size=WAVES) / np.sqrt(WAVES / 2.0)
        along = np.linspace(0.0, 1.0, points)
        wave = np.sin(np.pi * np.outer(along, np.arange(1, WAVES + 1) - 0.5))
        return np.asarray(self.on * IMAGE_M * wave @ waves)


# ------------------------------------------------------------------------------- tables


@dataclass(frozen=True)
class Log:
    """A stay as it was recorded: forces (readings,), curves (readings, points)."""

    stay: Stay
    at_s: A
    force_N: A
    s_m: A
    x_m: A
    y_m: A
    frame_m: A
    image_m: A  # (3, points), of 0 V and the two voltages


def session(plant: Plant, design: Design, seed: int, exact: bool) -> Measurements:
    """Return everything that is measured."""
    noise = Noise(seed, exact)
    conditions: list[Condition] = []
    series: list[TimeSeries] = []
    order = stays(design, seed, exact)
    for name in design.positions_m:
        mine = [stay for stay in order if stay.configuration == name]
        strip = plant.strips[name]
        points = np.linspace(0.0, strip.free_m + strip.bar_m, design.curve_points)
        for stay, grid in zip(mine, grids(plant, strip, mine, points), strict=True):
            now = course(plant, stay)
            display = shown_N(plant, stay, grid, now)
            pink = noise.pink_N(len(stay.t))
            conditions += _conditions(
                _log(plant, design, stay, grid, now, display, pink, noise), design
            )
            force = display + noise.read_N(pink, SAMPLE_N)
            if design.series:
                series.append(_series(stay, now, force))
    sheets = {name: stated(plant.strips[name]) for name in design.positions_m}
    return Measurements(sheets=sheets, conditions=tuple(conditions), series=tuple(series))


def _log(
    plant: Plant, design: Design, stay: Stay, grid: Grid, now: Course, display: A, pink: A,
    noise: Noise,
) -> Log:  # fmt: skip
    count, points = 3 * design.readings + design.discarded, design.curve_points
    at = np.arange(count) * design.pulse_s + design.sample_s
    along = np.linspace(0.0, plant.strips[stay.configuration].free_m, points)
    along = along * (1.0 + plant.strips[stay.configuration].bar_m / along[-1])
    force = np.interp(at, stay.t, display) + noise.read_N(np.interp(at, stay.t, pink), WHITE_N)
    s, x, y = seen_m(plant, stay, grid, now, at, along)
    image = np.array([noise.image_m(points) for _ in range(3)])
    return Log(stay, at, force, s, x, y, noise.frames_m(count, points), image)


def _series(stay: Stay, now: Course, force_N: A) -> TimeSeries:
    volts = stay.volts
    charging = np.diff(now.alpha, prepend=0.0) * HZ * 0.002
    return TimeSeries(
        configuration=stay.configuration,
        position_m=stay.stated_m,
        time_s=stay.t,
        drive_V=volts,
        force_N=None if stay.stated_m is None else force_N,
        current_A=volts / 60.0 + charging,
        mounting=stay.mounting,
    )


def _conditions(log: Log, design: Design) -> Iterator[Condition]:
    """Yield 0 V, then the two voltages."""
    zeros = design.readings
    whole = np.arange(len(log.at_s))
    for turn, voltage_V in enumerate((0.0, *design.voltages_V)):
        mine = whole[:zeros] if turn == 0 else whole[zeros + turn - 1 :: 2]
        counted = [i for i in mine.tolist() if turn == 0 or i >= zeros + design.discarded]
        mean = [v[counted].mean(axis=0) for v in (log.s_m, log.x_m, log.y_m, log.frame_m)]
        mean[3] = mean[3] + log.image_m[turn]
        yield Condition(
            configuration=log.stay.configuration,
            position_m=log.stay.stated_m,
            voltage_V=voltage_V,
            readings=tuple(_reading(log, i, design) for i in mine.tolist()),
            curve=_curve(mean, float(np.hypot(IMAGE_M, FRAME_M / np.sqrt(len(counted))))),
            mounting=log.stay.mounting,
            approach=log.stay.approach,  # type: ignore[arg-type]
        )


def _reading(log: Log, i: int, design: Design) -> Reading:
    after = i - design.readings
    kind: Kind = "zero" if after < 0 else "discarded" if after < design.discarded else "kept"
    curve = None
    if design.series:
        curve = _curve([log.s_m[i], log.x_m[i], log.y_m[i], log.frame_m[i]], FRAME_M)
    return Reading(
        index=i,
        kind="no_contact" if log.stay.stated_m is None else kind,
        force_N=float(log.force_N[i]),
        time_s=float(log.at_s[i]),
        session_s=float(log.stay.from_s + log.at_s[i]),
        wetted_s=float(log.stay.moist_s + log.at_s[i]),
        curve=curve,
    )


def _curve(columns: list[A], sigma_m: float) -> Curve:
    """Return a curve whose points are moved along its normal."""
    s, x, y, moved = columns
    tx, ty = np.gradient(x, s), np.gradient(y, s)
    size = np.hypot(tx, ty)
    return Curve(
        s_m=s.copy(),
        x_m=x - moved * ty / size,
        y_m=y + moved * tx / size,
        sigma_m=np.full_like(s, sigma_m),
    )
