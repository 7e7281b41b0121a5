"""A chain of rigid links with springs in its joints: at rest against the load cell.

Link j of n lies between j h and (j + 1) h, h = l/n. Its joint carries the curvature of the cell
around it: half a cell at the clamp. An elongation is one more link, after half a cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from model.dynamics.models.contract import DrivenSheet
from model.measurements import FloatArray, ModelError

LINKS = 10
GRID_PER_M = 10.0  # of Me/B, where the contact is solved; splines between


@dataclass(frozen=True)
class Chain:
    """Lengths of the links and of the cells at their joints, and the joints' angles at rest."""

    link_m: FloatArray  # (n,)
    cell_m: FloatArray  # (n,)
    rest_rad: FloatArray  # (n,)

    def angles(self, kappa_per_m: float) -> FloatArray:
        """Return the directions (n,) of the links of the free chain at rest."""
        return np.cumsum(self.rest_rad + self.cell_m * kappa_per_m)

    def joints(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return x, y (..., n + 1) of the joints and the end, of directions (..., n)."""
        clamp = np.zeros((*angles.shape[:-1], 1))
        x = np.concatenate([clamp, np.cumsum(self.link_m * np.cos(angles), axis=-1)], axis=-1)
        y = np.concatenate([clamp, np.cumsum(self.link_m * np.sin(angles), axis=-1)], axis=-1)
        return x, y


def chain_of(run: DrivenSheet, links: int = LINKS) -> Chain:
    """Return the chain of a run's sheet, in contact with its elongation."""
    sheet = run.sheet
    h = sheet.free_length_m / links
    cells = np.full(links, h)
    cells[0] = 0.5 * h
    rest = cells * run.rest(h * np.arange(links, dtype=np.float64))
    rest[0] = 0.5 * h * run.rest.mean(0.5 * h)
    lengths = np.full(links, h)
    if not run.free and sheet.elongation_m > 0.0:
        end = run.rest(sheet.free_length_m - 0.25 * h)
        lengths = np.append(lengths, sheet.elongation_m)
        cells, rest = np.append(cells, 0.5 * h), np.append(rest, 0.5 * h * end)
    return Chain(lengths, cells, rest)


@dataclass(frozen=True)
class ChainContact:
    """F/B and directions of the links against Me/B at one place of the load cell."""

    chain: Chain
    radius_m: float
    angle_rad: float

    def at(self, kappa_per_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return F/B (n,) and directions (n, links), by splines between solved contacts."""
        from scipy.interpolate import CubicSpline  # slow to import

        first = int(np.floor(np.min(kappa_per_m) / GRID_PER_M)) - 1
        last = int(np.ceil(np.max(kappa_per_m) / GRID_PER_M)) + 1
        grid = GRID_PER_M * np.arange(first, last + 1)
        values = CubicSpline(grid, [_solved(self._key, float(k)) for k in grid])(kappa_per_m)
        return values[:, 0], values[:, 1:]

    @property
    def _key(self) -> tuple[bytes, bytes, bytes, float, float]:
        c = self.chain
        return (
            c.link_m.tobytes(), c.cell_m.tobytes(), c.rest_rad.tobytes(),
            self.radius_m, self.angle_rad,
        )  # fmt: skip


@lru_cache(maxsize=4096)
def _solved(key: tuple[bytes, bytes, bytes, float, float], kappa_per_m: float) -> FloatArray:
    """Return F/B and the links' directions in contact; `ModelError` where there is none."""
    from scipy.optimize import root  # slow to import

    chain = Chain(*(np.frombuffer(one) for one in key[:3]))
    R, beta = key[3:]
    free = chain.rest_rad + chain.cell_m * kappa_per_m

    def contact(angles: FloatArray) -> tuple[int, FloatArray, FloatArray, FloatArray]:
        x, y = chain.joints(angles)
        far = np.flatnonzero(np.hypot(x, y)[1:] >= R)
        link = int(far[0]) if len(far) else len(angles) - 1
        along = np.array([np.cos(angles[link]), np.sin(angles[link])])
        start = np.array([x[link], y[link]])
        b = along @ start  # |start + d along| = R
        d = -b + np.sqrt(max(b**2 + R**2 - start @ start, 0.0))
        return link, start + d * along, x, y

    def unbalanced(unknown: FloatArray) -> FloatArray:
        angles, push = unknown[:-1], unknown[-1] / R**2
        link, p, x, y = contact(angles)
        nx, ny = -np.sin(angles[link]), np.cos(angles[link])
        moment = -push * ((p[0] - x[:-1]) * ny - (p[1] - y[:-1]) * nx)
        moment[link + 1 :] = 0.0
        turned = np.diff(angles, prepend=0.0) - free - chain.cell_m * moment
        return np.append(turned, np.arctan2(p[1], p[0]) - beta)

    k = 2.0 * np.sin(beta) / R
    start = np.append(np.cumsum(chain.cell_m) * k, 2.0 * R * (kappa_per_m - k))
    found = root(unbalanced, start, tol=1e-12)
    angles = np.asarray(found.x[:-1])
    link, _, x, y = contact(angles)
    reached = np.hypot(x, y)[link + 1] >= R * (1.0 - 1e-9)
    if np.max(np.abs(unbalanced(found.x))) > 1e-8 or not reached:
        raise ModelError("the chain of links does not reach the load cell")
    return np.append(found.x[-1] / R**2 * np.cos(angles[link] - beta), angles)
