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
    towards = reach * np.sign(change)
    left = np.where(change == 0.0, 1.0, np.exp(-np.abs(change) / reach))
    sign = np.sign(reach_N)
    if force_N.ndim == 1:  # numbers by themselves are many times quicker than arrays of one
        return np.asarray(sign * np.array(_followed(*(a.tolist() for a in (towards, left, new)))))
    ahead, now = np.zeros_like(force_N), np.zeros(force_N.shape[:-1])
    for k in range(force_N.shape[-1]):
        now = np.where(new[..., k], 0.0, now)
        now = towards[..., k] + (now - towards[..., k]) * left[..., k]
        ahead[..., k] = now
    return np.asarray(sign * ahead)


def _followed(towards: list[float], left: list[float], new: list[bool]) -> list[float]:
    """Return the course of one run of readings."""
    now, ahead = 0.0, list[float]()
    for end, share, begins in zip(towards, left, new, strict=True):
        now = end + ((0.0 if begins else now) - end) * share
        ahead.append(now)
    return ahead
