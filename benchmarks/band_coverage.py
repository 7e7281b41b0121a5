"""How many left-out measurements lie in the 90 % bands of the page of results.

Sessions are simulated as in `interval_coverage`. Of each, one position is left out of the fit; its
mean forces and curves are compared with the bands about both models' lines there.

    python -m benchmarks.band_coverage [SESSIONS] [FIRST_SEED]
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from benchmarks.interval_coverage import Z90, measurements
from labrig.analysis.results.models import models_of
from labrig.analysis.results.predicted import predicted_by
from model import Condition, Measurements, fit
from sim_hardware.world import WorldSettings, load_world
from sim_hardware.world.reduced import reduced_session

Tally = dict[str, list[bool]]  # by model and kind: whether each left-out measurement is inside


def tally(world: WorldSettings, seeds: Iterable[int]) -> Tally:
    """Leave out one position of one session for each seed, a different one each time."""
    found: Tally = {}
    for seed in seeds:
        data = measurements(reduced_session(world, seed=seed), world)
        place = _inner_places(data)[seed % len(_inner_places(data))]
        out = [c for c in data.conditions if (c.configuration, c.position_m) == place]
        kept = [c for c in data.conditions if not any(c is one for one in out)]
        for model in models_of(fit(replace(data, conditions=tuple(kept))), None):
            everywhere = predicted_by(model, replace(data, conditions=tuple(kept)))
            for condition in out:
                line = next(
                    one
                    for one in everywhere.lines[condition.configuration]
                    if one["voltage_V"] == condition.voltage_V
                )
                found.setdefault(f"{model.id} force", []).append(_force_inside(condition, line))
            there = predicted_by(model, data)
            for i, condition in enumerate(data.conditions):
                if any(condition is one for one in out):
                    near = _nearest(kept, condition)
                    half = everywhere.conditions[near]["curve"]["half90_mm"]
                    inside = _curve_inside(condition, there.conditions[i]["curve"], half)
                    found.setdefault(f"{model.id} curve", []).extend(inside)
    return found


def _inner_places(data: Measurements) -> list[tuple[str, float]]:
    """Return configuration and position where others were measured on both sides."""
    places = dict.fromkeys(
        (c.configuration, c.position_m) for c in data.conditions if c.position_m is not None
    )
    ends = {
        name: (min(p for n, p in places if n == name), max(p for n, p in places if n == name))
        for name in data.sheets
    }
    return sorted((name, p) for name, p in places if p not in ends[name])


def _force_inside(condition: Condition, line: dict) -> bool:
    at_mm = 1e3 * (condition.position_m or 0.0)
    force_mN = 1e3 * float(np.mean([r.force_N for r in condition.used()]))
    middle, half = (np.interp(at_mm, line["p_mm"], line[key]) for key in ("F_mN", "half90_mN"))
    return bool(abs(force_mN - middle) <= half)


def _nearest(kept: list[Condition], condition: Condition) -> int:
    """Return the condition next to one that was left out; the band is much the same there."""
    same = [
        (abs((c.position_m or 0.0) - (condition.position_m or 0.0)), i)
        for i, c in enumerate(kept)
        if (c.configuration, c.voltage_V) == (condition.configuration, condition.voltage_V)
        and c.position_m is not None
    ]
    return min(same)[1]


def _curve_inside(condition: Condition, curve: dict, half_mm: list[float]) -> list[bool]:
    """Whether measured points at a half, three quarters and the end are in the band."""
    model = np.array([curve["x_mm"], curve["y_mm"]], dtype=float).T
    t = np.gradient(model, axis=0)
    normal = np.stack([-t[:, 1], t[:, 0]], axis=1) / np.hypot(*t.T)[:, None]
    result = []
    for share in (0.5, 0.75, 1.0):
        i = round(share * (len(condition.curve.s_m) - 1))
        point = 1e3 * np.array([condition.curve.x_m[i], condition.curve.y_m[i]])
        k = int(np.argmin(np.hypot(*(model - point).T)))
        off = abs(float((point - model[k]) @ normal[k]))
        result.append(bool(off <= np.interp(k / len(model), *_shares(half_mm))))
    return result


def _shares(values: list[float]) -> tuple[np.ndarray, list[float]]:
    return np.linspace(0.0, 1.0, len(values)), values


def over_sessions(shares: list[float]) -> tuple[float, float, float]:
    """Return the mean and its 90 % interval: sessions are independent, their measurements not."""
    mean, sigma = np.mean(shares), np.std(shares, ddof=1) / np.sqrt(len(shares))
    return float(mean), float(mean - Z90 * sigma), float(mean + Z90 * sigma)


def main(arguments: list[str]) -> None:
    count = max(2, int(arguments[0])) if arguments else 40
    first = int(arguments[1]) if len(arguments) > 1 else 3000
    world = load_world(None)
    sessions = [tally(world, [seed]) for seed in range(first, first + count)]
    print(f"{count} sessions from seed {first} on, one position of each left out")
    for name in sessions[0]:
        shares = [float(np.mean(one[name])) for one in sessions]
        mean, low, high = over_sessions(shares)
        print(f"{name:15} {mean:.3f}  ({low:.3f} .. {high:.3f})")


if __name__ == "__main__":
    main(sys.argv[1:])
