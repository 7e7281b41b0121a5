"""The noise of a recording, from itself: white noise from neighbours, drift and hum from residuals.

Before there is a model the residuals of force and current are not known; what is usual of a load
cell then stands for its drift and hum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from drivers.interfaces import FloatArray
from model.dynamics import DynamicBeam, Resolution
from model.dynamics.identification import ChannelNoise, RecordedRun, RecordingNoise
from model.dynamics.identification.predicted_run import predict

EDGE_S = 1e-3  # the amplifier's output has changed, and the sample's clock is known so well
USUAL_FORCE = {"zero": 2e-4, "drift_per_sqrt_s": 3e-5, "hum": 3e-5}  # N, N/sqrt(s), N
USUAL_CURRENT = {"zero": 5e-5, "drift_per_sqrt_s": 1e-5, "hum": 1e-5}  # A
LEAST_FORCE_N, LEAST_CURRENT_A, LEAST_CURVE_M = 1e-6, 1e-7, 1e-5
USUAL_CURVE_M = 3e-5
BLOCK_S = 0.5  # of a residual, whose mean shows the drift
MAINS_HZ = (50.0, 60.0)
FEW = 50  # samples, from which no noise is estimated


def noise_at_first(runs: Sequence[RecordedRun]) -> RecordingNoise:
    """Return white noise from differences of neighbouring samples, the rest as it is usual."""
    force = [np.diff(run.force_N) for run in runs if run.force_N is not None]
    current = [np.diff(run.current_A) for run in runs if run.current_A is not None]
    return RecordingNoise(
        force=ChannelNoise(white=max(_of_differences(force), LEAST_FORCE_N), **USUAL_FORCE),
        current=ChannelNoise(white=max(_of_differences(current), LEAST_CURRENT_A), **USUAL_CURRENT),
        curve_m=USUAL_CURVE_M,
        edge_s=_edge_s(runs),
    )


def noise_of_residuals(
    beam: DynamicBeam, runs: Sequence[RecordedRun], before: RecordingNoise
) -> RecordingNoise:
    """Return the noise that the residuals of a fitted sheet show. Raises ModelError."""
    kinds: dict[str, list[tuple[FloatArray, FloatArray]]] = {"force": [], "current": []}
    across: list[FloatArray] = []
    for run in runs:
        said = predict(beam, run.plan, Resolution())
        away = _away_from_edges(run, before.edge_s)
        if run.force_N is not None:
            kinds["force"].append((run.plan.time_s, run.force_N - said.force_N))
        if run.current_A is not None:
            kinds["current"].append((run.plan.time_s[away], (run.current_A - said.current_A)[away]))
        if run.x_m is not None and run.y_m is not None:
            dx, dy = run.x_m - said.x_m, run.y_m - said.y_m
            across.append((np.cos(said.phi_rad) * dy - np.sin(said.phi_rad) * dx).ravel())
    mains_hz = _mains_hz(kinds["force"] or kinds["current"])
    curve_m = before.curve_m
    if across:
        curve_m = max(LEAST_CURVE_M, _rms(np.concatenate(across)))
    return RecordingNoise(
        force=_channel(kinds["force"], mains_hz, LEAST_FORCE_N, before.force),
        current=_channel(kinds["current"], mains_hz, LEAST_CURRENT_A, before.current),
        curve_m=curve_m,
        mains_hz=mains_hz,
        edge_s=before.edge_s,
    )


def _channel(
    parts: list[tuple[FloatArray, FloatArray]], mains_hz: float, least: float, before: ChannelNoise
) -> ChannelNoise:
    parts = [part for part in parts if len(part[0]) > FEW]
    if not parts:
        return before
    amplitude = _weighed(parts, lambda t, r: _hum(t, r, mains_hz))
    smooth = [(t, _without_hum(t, r, mains_hz)) for t, r in parts]
    white = max(least, _of_differences([np.diff(r) for _, r in smooth]))
    means = [_block_means(t, r) for t, r in smooth]
    steps = np.concatenate([np.diff(one) for one in means])
    zeros = np.array([one[0] for one in means])
    drift = float(np.mean(steps**2)) / BLOCK_S if steps.size else before.drift_per_sqrt_s**2
    return ChannelNoise(
        white=white,
        zero=float(max(np.sqrt(np.mean(zeros**2)), white / np.sqrt(FEW))),
        drift_per_sqrt_s=float(np.sqrt(drift)),
        hum=float(amplitude / np.sqrt(2.0)),
    )


def _of_differences(parts: list[FloatArray]) -> float:
    """Return the noise of one sample: half the samples differ by less than 0.6745 sqrt(2) of it."""
    if not parts or not sum(len(part) for part in parts):
        return 0.0
    return float(np.median(np.abs(np.concatenate(parts))) / (0.6745 * np.sqrt(2.0)))


def _edge_s(runs: Sequence[RecordedRun]) -> float:
    """Return how near an edge a sample of the current is left out; less for many writes."""
    widths = [np.diff(run.plan.drive.time_s) for run in runs if len(run.plan.drive.time_s) > 2]
    if not widths:
        return EDGE_S
    return min(EDGE_S, 0.25 * float(np.min(np.concatenate(widths))))


def _away_from_edges(run: RecordedRun, edge_s: float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    edges, times = run.plan.drive.time_s, run.plan.time_s
    place = np.searchsorted(edges, times)
    last = len(edges) - 1
    nearest = np.minimum(
        np.abs(times - edges[np.clip(place - 1, 0, last)]),
        np.abs(times - edges[np.clip(place, 0, last)]),
    )
    return np.asarray(nearest > edge_s)


def _mains_hz(parts: list[tuple[FloatArray, FloatArray]]) -> float:
    parts = [part for part in parts if len(part[0]) > FEW]
    if not parts:
        return MAINS_HZ[0]
    return max(MAINS_HZ, key=lambda hz: _weighed(parts, lambda t, r: _hum(t, r, hz)))


def _weighed(
    parts: list[tuple[FloatArray, FloatArray]], of: Callable[[FloatArray, FloatArray], float]
) -> float:
    """Return the root mean square of a figure of each part, weighed by its samples."""
    squares = [len(t) * of(t, r) ** 2 for t, r in parts]
    return float(np.sqrt(sum(squares) / sum(len(t) for t, _ in parts)))


def _hum(time_s: FloatArray, residual: FloatArray, mains_hz: float) -> float:
    """Return the amplitude at the mains' frequency."""
    found = _wave(time_s, residual, mains_hz)[1]
    return float(np.hypot(*found))


def _without_hum(time_s: FloatArray, residual: FloatArray, mains_hz: float) -> FloatArray:
    waves, found = _wave(time_s, residual, mains_hz)
    return residual - waves @ found


def _wave(
    time_s: FloatArray, residual: FloatArray, mains_hz: float
) -> tuple[FloatArray, FloatArray]:
    turn = 2.0 * np.pi * mains_hz * time_s
    waves = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return waves, np.linalg.lstsq(waves, residual - residual.mean(), rcond=None)[0]


def _block_means(time_s: FloatArray, residual: FloatArray) -> FloatArray:
    return np.array(list(_means(time_s, residual)))


def _means(time_s: FloatArray, residual: FloatArray) -> Iterator[float]:
    block = np.floor((time_s - time_s[0]) / BLOCK_S).astype(int)
    for number in np.unique(block):
        yield float(np.mean(residual[block == number]))


def _rms(values: FloatArray) -> float:
    seen = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(seen**2))) if seen.size else 0.0
