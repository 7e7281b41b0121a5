"""Hysteresis of a force: backlash, as in a bearing that follows only when pushed over."""

from __future__ import annotations

import numpy as np

from model.measurements import FloatArray


def hung(
    force_N: FloatArray,
    position_m: FloatArray,
    reach_N: float,
    *,
    from_no_load: bool,
    goes_on: bool = False,
) -> FloatArray:
    """By how much the force is ahead of what follows it, within +-reach_N.

    Arrays (..., n), the last axis in the order of time. It begins anew where the position changes:
    in the middle of the loop at no load, or in the middle of it at the first force. If it `goes_on`
    it begins at no load once, and each position begins where the one before has ended. It turns
    over as in Dahl's model, exp(-change/reach), so that small changes leave no corner.
    """
    force_N, reach = np.asarray(force_N, dtype=float), abs(reach_N)
    if reach == 0.0 or not force_N.size:
        return np.zeros_like(force_N)
    before = np.concatenate([np.zeros_like(force_N[..., :1]), force_N[..., :-1]], axis=-1)
    new = np.ones(force_N.shape, dtype=bool)
    new[..., 1:] = False if goes_on else position_m[..., 1:] != position_m[..., :-1]
    change = force_N - np.where(new, 0.0 if from_no_load or goes_on else force_N, before)
    left = np.where(change == 0.0, 1.0, np.exp(-np.abs(change) / reach))
    added, kept = reach * np.sign(change) * (1.0 - left), np.where(new, 0.0, left)
    sign = np.sign(reach_N)
    if force_N.ndim == 1:  # numbers by themselves are many times quicker than arrays of one
        return np.asarray(sign * np.array(_followed(added.tolist(), kept.tolist())))
    # the times first, so that the steps are from one piece of memory to the next
    ahead, kept = (np.ascontiguousarray(np.moveaxis(one, -1, 0)) for one in (added, kept))
    for k in range(1, len(ahead)):
        ahead[k] += kept[k] * ahead[k - 1]
    return np.asarray(sign * np.moveaxis(ahead, 0, -1))


def _followed(added: list[float], kept: list[float]) -> list[float]:
    """Return the course of one run of readings."""
    now, ahead = 0.0, list[float]()
    for more, share in zip(added, kept, strict=True):
        now = more + now * share
        ahead.append(now)
    return ahead
