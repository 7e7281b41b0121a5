"""From a design to a session: order, clocks, set-ups, noise, readings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._splines_rig import (
    RATE_HZ,
    Rig,
    Run,
    curves_m,
    forces_N,
    state,
    tables,
)
from benchmarks.worlds.generators._splines_sheet import A, Sheet
from model.measurements import (
    Condition,
    Curve,
    Kind,
    Measurements,
    Reading,
    SheetGeometry,
    TimeSeries,
)

MOVE_S, WETTED_S = 70.0, 12.0  # between two runs; from the moistening to the run
NODES_M = 51  # of the stated rest curvature
# set-ups and noise
EIBM, STIFFNESS, PLACE_M = 0.01, 0.01, 5e-5
READING_N, SAMPLE_N, WALK_N = 3e-5, 6e-5, 6e-6
OUTLIERS, OUTLIER_N = 0.003, 3e-4
IMAGE_M, FRAME_M, ALONG_M = 2e-5, 4e-5, 3e-3


def true_sheets(seed: int) -> dict[str, Sheet]:
    """Return the sheets of a seed, with nothing hidden."""
    rng = np.random.default_rng([seed, 1])
    return {
        "long": _sheet(rng, "long", 0.050, 0.0, (1.27e-6, 24.0, 25.0)),
        "short": _sheet(rng, "short", 0.0045, 0.046, (0.85e-6, 28.0, 68.0)),
    }


def _sheet(
    rng: np.random.Generator, name: str, length_m: float, ray_m: float, usual: tuple[float, ...]
) -> Sheet:
    """Draw B, k0 and Me/B about what is usual."""
    spread = np.exp(rng.normal(0.0, [0.1, 0.08, 0.1, 0.08]))
    B, bent, driven = np.array(usual) * spread[:3]

    def rest(s: A) -> A:
        return np.asarray(bent * (0.35 + 0.65 / (1.0 + (s / 0.03) ** 1.5)))

    return Sheet(
        name=name,
        length_m=length_m,
        elongation_m=ray_m,
        radius_m=0.04,
        origin_rad=0.0,
        B_Nm2=float(B),
        driven_per_m={1: float(driven), -1: float(0.85 * driven * spread[3])},
        rest=[rest],
    )


def geometry(sheet: Sheet) -> SheetGeometry:
    """Return the sheet as the operator states it; rest curvature is stated as it is."""
    s = np.linspace(0.0, sheet.length_m, NODES_M)
    return SheetGeometry(
        configuration=sheet.name,
        free_length_m=sheet.length_m,
        width_m=0.011,
        thickness_m=0.00021,
        elongation_m=sheet.elongation_m,
        arc_radius_m=sheet.radius_m,
        arc_origin_rad=sheet.origin_rad,
        initial_curvature=(s, sheet.rest_per_m(s)),
        clamped_length_m=0.0015,
    )


# -------------------------------------------------------------------------------- runs


def planned(design: Design, seed: int, exact: bool) -> list[Run]:
    """Return the runs of a session, in their order, with their set-ups."""
    rng = np.random.default_rng([seed, 2])
    order: list[tuple[str, float | None, int]] = []
    for name, positions in design.positions_m.items():
        anew = positions[1::2] + positions[::2]
        again: list[tuple[float | None, int]] = [
            (anew[i % len(anew)], 1 + i // len(anew)) for i in range(design.remounts)
        ]
        places: list[tuple[float | None, int]] = [(p, 0) for p in positions] + again
        if design.random_order:
            places = [places[int(i)] for i in rng.permutation(len(places))]
        places += [(None, i) for i in range(design.free_shapes)]
        order += [(name, p, m) for p, m in places]
    pulses = design.readings + design.discarded + 2 * design.readings
    lasts_s = pulses * design.pulse_s
    gaps = np.full(len(order), MOVE_S) if exact else rng.uniform(0.8, 1.2, len(order)) * MOVE_S
    begin = np.cumsum(gaps + lasts_s) - lasts_s
    whole = begin[-1] + lasts_s
    runs: list[Run] = []
    for (name, place, mounting), begin_s in zip(order, begin.tolist(), strict=True):
        scatter = 0.0 * rng.normal(size=3) if exact else rng.normal(size=3)
        wetted = WETTED_S if exact else WETTED_S * rng.uniform(0.8, 1.2)
        run = _run(design, name, place, float(begin_s), exact, float(whole))
        run.mounting, run.wetted_s = mounting, wetted
        run.approach = _approach(runs[-1] if runs else None, run)
        run.eibm, run.stiffness = 1.0 + EIBM * scatter[0], 1.0 + STIFFNESS * scatter[1]
        run.moved_m = float(PLACE_M * scatter[2])
        runs.append(run)
    return runs


def _approach(before: Run | None, run: Run) -> str:
    if run.position_m is None:
        return ""
    if before is None or before.position_m is None or before.configuration != run.configuration:
        return "up"
    return "up" if run.position_m >= before.position_m else "down"


def _run(
    design: Design, name: str, place: float | None, begin_s: float, exact: bool, whole_s: float
) -> Run:
    """Return a run with its clock: 0 V, then pulses of either voltage in turn."""
    volts = [0.0] * design.readings + [
        design.voltages_V[i % 2] for i in range(design.discarded + 2 * design.readings)
    ]
    time_s = (np.arange(round(len(volts) * design.pulse_s * RATE_HZ)) + 0.5) / RATE_HZ
    which = np.minimum((time_s / design.pulse_s).astype(int), len(volts) - 1)
    share = np.full_like(time_s, 0.5) if exact else (begin_s + time_s) / whole_s
    return Run(
        configuration=name,
        position_m=place,
        mounting=0,
        approach="",
        begin_s=whole_s / 2.0 if exact else begin_s,
        wetted_s=0.0,
        sample_s=design.sample_s,
        time_s=time_s,
        drive_V=np.array(volts)[which],
        pulse=np.maximum(which - design.readings, -1).astype(float),
        edge_s=time_s - which * design.pulse_s,
        share=share,
    )


# ------------------------------------------------------------------------------- noise


class Noise:
    """The noise of a session: the same for a seed and a design, whatever is hidden."""

    def __init__(self, seed: int, whole_s: float, exact: bool) -> None:
        self.rng = np.random.default_rng([seed, 3])
        self.on = 0.0 if exact else 1.0
        steps = self.rng.normal(size=int(whole_s) + 2) / np.sqrt(whole_s)
        self.walk_N: A = WALK_N * np.cumsum(steps) * self.on

    def reading_N(self, session_s: A) -> A:
        """Return Laplace noise, rare outliers, and a zero that walks."""
        count = len(session_s)
        noise = self.rng.laplace(0.0, READING_N / np.sqrt(2.0), count)
        far = self.rng.uniform(size=count) < OUTLIERS
        noise += far * self.rng.normal(0.0, OUTLIER_N, count)
        return self.on * noise + self.drift_N(session_s)

    def drift_N(self, session_s: A) -> A:
        """Return how far the load cell's zero has walked."""
        return np.interp(session_s, np.arange(len(self.walk_N)), self.walk_N)

    def sample_N(self, count: int) -> A:
        """Return noise of single samples."""
        return self.on * self.rng.laplace(0.0, SAMPLE_N / np.sqrt(2.0), count)

    def along_m(self, curves: int, points_m: A, sigma_m: float) -> A:
        """Return displacements along the normal, correlated along the sheet: (curves, points)."""
        keep = np.exp(-np.diff(points_m) / ALONG_M)
        white = self.rng.normal(size=(curves, len(points_m)))
        for i, k in enumerate(keep, start=1):
            white[:, i] = k * white[:, i - 1] + np.sqrt(1.0 - k**2) * white[:, i]
        return self.on * sigma_m * white


# ------------------------------------------------------------------------- measurements


@dataclass(frozen=True)
class Recorded:
    """Arrays of one run, (readings,) and (readings, points)."""

    force_N: A
    s_m: A
    x_m: A
    y_m: A
    frame_noise_m: A


def measured(rig: Rig, design: Design, seed: int, exact: bool) -> Measurements:
    """Return the session."""
    runs = planned(design, seed, exact)
    noise = Noise(seed, runs[-1].begin_s + 60.0, exact)
    conditions: list[Condition] = []
    series: list[TimeSeries] = []
    for name in design.positions_m:
        mine = [run for run in runs if run.configuration == name]
        sheet = rig.sheets[name]
        points = np.linspace(0.0, sheet.length_m + sheet.elongation_m, design.curve_points)
        for run, table in zip(mine, tables(rig, name, mine, points), strict=True):
            now = state(rig, run)
            shown = forces_N(rig, run, table, now)
            at = np.arange(round(run.time_s[-1] / design.pulse_s)) * design.pulse_s
            at = at + design.sample_s
            felt = np.interp(at, run.time_s, shown) + noise.reading_N(run.begin_s + at)
            seen = curves_m(rig, run, table, now, at, points)
            frames = noise.along_m(len(at), points, FRAME_M)
            recorded = Recorded(felt, *seen, frames)
            conditions += _conditions(run, design, at, recorded, noise, points)
            if design.series:
                series.append(_series(run, shown, noise))
    sheets = {name: geometry(rig.sheets[name]) for name in design.positions_m}
    return Measurements(sheets=sheets, conditions=tuple(conditions), series=tuple(series))


def _series(run: Run, shown_N: A, noise: Noise) -> TimeSeries:
    felt = shown_N + noise.sample_N(len(shown_N)) + noise.drift_N(run.begin_s + run.time_s)
    charge = np.diff(run.drive_V, prepend=0.0)
    edges = np.maximum.accumulate(np.where(charge != 0.0, np.arange(len(charge)), 0))
    current = run.drive_V / 40.0 + charge[edges] / 12.0 * np.exp(-run.edge_s / 0.08)
    return TimeSeries(
        configuration=run.configuration,
        position_m=run.position_m,
        time_s=run.time_s,
        drive_V=run.drive_V,
        force_N=None if run.position_m is None else felt,
        current_A=current,
        mounting=run.mounting,
    )


def _conditions(
    run: Run, design: Design, at_s: A, recorded: Recorded, noise: Noise, points_m: A
) -> list[Condition]:
    """Return one condition for 0 V and each of the two voltages."""
    made = []
    index, zeros = np.arange(len(at_s)), design.readings
    image = noise.along_m(3, points_m, IMAGE_M)
    for which, voltage_V in enumerate((0.0, *design.voltages_V)):
        mine = index[:zeros] if which == 0 else index[zeros + which - 1 :: 2]
        kept = mine[mine >= zeros + design.discarded] if which else mine
        readings = tuple(_reading(run, int(i), at_s, recorded, design) for i in mine)
        moved = recorded.frame_noise_m[kept].mean(axis=0) + image[which]
        s, x, y = (v[kept].mean(axis=0) for v in (recorded.s_m, recorded.x_m, recorded.y_m))
        sigma = np.hypot(IMAGE_M, FRAME_M / np.sqrt(len(kept)))
        made.append(
            Condition(
                configuration=run.configuration,
                position_m=run.position_m,
                voltage_V=voltage_V,
                readings=readings,
                curve=_curve(s, x, y, moved, sigma),
                mounting=run.mounting,
                approach=run.approach,  # type: ignore[arg-type]
            )
        )
    return made


def _reading(run: Run, i: int, at_s: A, recorded: Recorded, design: Design) -> Reading:
    zeros = design.readings
    kind: Kind = "zero" if i < zeros else "kept"
    if zeros <= i < zeros + design.discarded:
        kind = "discarded"
    curve = None
    if design.series:
        rows = (recorded.s_m[i], recorded.x_m[i], recorded.y_m[i], recorded.frame_noise_m[i])
        curve = _curve(*rows, FRAME_M)
    return Reading(
        index=i,
        kind="no_contact" if run.position_m is None else kind,
        force_N=float(recorded.force_N[i]),
        time_s=float(at_s[i]),
        session_s=float(run.begin_s + at_s[i]),
        wetted_s=float(run.wetted_s + at_s[i]),
        curve=curve,
    )


def _curve(s: A, x: A, y: A, moved_m: A, sigma_m: float) -> Curve:
    """Return a curve displaced along its normal."""
    way = np.arctan2(np.gradient(y), np.gradient(x))
    return Curve(
        s_m=s.copy(),
        x_m=x - moved_m * np.sin(way),
        y_m=y + moved_m * np.cos(way),
        sigma_m=np.full_like(s, sigma_m),
    )
