"""Curves that a sheet may take, as exact as they are drawn."""

from __future__ import annotations

import numpy as np

from benchmarks._vision_recipe import Recipe


def truth_curve(recipe: Recipe, rng):
    """Curvature as beams and gels have it: exponentials along the sheet plus a contact's kink."""
    n = 4001
    length = recipe.free_mm + recipe.elongation_mm
    s = np.linspace(0, length, n)
    if recipe.physical:
        return _gel_curve(recipe, rng, s)
    free = s <= recipe.free_mm
    t = s / recipe.free_mm
    k = rng.normal(0, 1) + 1.5 * rng.normal() * np.exp(-t / rng.uniform(0.2, 0.9))
    k = k + 0.6 * rng.normal() * np.sin(np.pi * t * rng.uniform(0.5, 1.6) + rng.uniform(0, 6))
    where = rng.uniform(0.5, 0.95)
    k = k + rng.normal() * np.maximum(0, where - t)
    k = np.where(free, k, 0.0)
    ds = s[1] - s[0]
    turn = recipe.turn_rad if recipe.turn_rad is not None else rng.uniform(-4.19, 4.19)
    phi = np.concatenate([[0], np.cumsum((k[1:] + k[:-1]) / 2 * ds)])
    scale = turn / phi[-1] if abs(phi[-1]) > 0.3 * np.abs(phi).max() else 1.0 / np.abs(phi).max()
    k, phi = k * scale, phi * scale
    x = np.concatenate([[0], np.cumsum((np.cos(phi[1:]) + np.cos(phi[:-1])) / 2 * ds)])
    y = np.concatenate([[0], np.cumsum((np.sin(phi[1:]) + np.sin(phi[:-1])) / 2 * ds)])
    return s, np.stack([x, y], axis=1), k * 1000, phi


def _gel_curve(recipe, rng, s):
    """Initial curvature, a moment that decays from the root, and a force at a contact."""
    k = 24 * rng.uniform(0.8, 1.2) * np.exp(-s / 40)
    k = k + rng.choice([-80, 0, 100]) * rng.uniform(0.8, 1.2) * np.exp(-s / rng.uniform(9, 16))
    contact = rng.uniform(36, 44)
    k = k + rng.normal(0, 15) * np.maximum(0, 1 - s / contact)
    k = np.where(s <= recipe.free_mm, k, 0.0) * rng.choice([-1, 1]) / 1000
    ds = s[1] - s[0]
    phi = np.concatenate([[0], np.cumsum((k[1:] + k[:-1]) / 2 * ds)])
    x = np.concatenate([[0], np.cumsum((np.cos(phi[1:]) + np.cos(phi[:-1])) / 2 * ds)])
    y = np.concatenate([[0], np.cumsum((np.sin(phi[1:]) + np.sin(phi[:-1])) / 2 * ds)])
    return s, np.stack([x, y], axis=1), k * 1000, phi


def does_not_touch_itself(xy):
    p = xy[::40]
    d = np.hypot(*(p[:, None] - p[None]).transpose(2, 0, 1))
    i = np.arange(len(p))
    far = np.abs(i[:, None] - i[None]) * 40 * (50 / 4000) > 8
    return not (d[far] < 4).any()
