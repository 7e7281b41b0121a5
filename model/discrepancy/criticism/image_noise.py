"""Noise of curves beyond what images have: something unknown hides in it.

The noise of a curve's shape ("modes") is estimated from what the model leaves, so a gap that no
candidate describes is taken up by it. Two things say how large it usually is: images that are taken
one after the other, and the other configurations, which the same camera sees. What is beyond both
competes as a nonparametric term of the camera: in each image of a configuration its curve is
shifted and turned by amounts of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.search.evidence import Candidate, Projected, scored
from model.discrepancy.search.nonparametric_terms import unknowns
from model.discrepancy.search.ranking import RankedCandidate, best_of_each
from model.discrepancy.thresholds import (
    EVIDENCE_THRESHOLD_LN,
    FEWEST_IMAGES,
    FEWEST_UNUSUAL_IMAGES,
    IMAGE_NOISE_LN,
    REPEATS_NOISE_RATIO,
)
from model.identification.data.data_vector import Index
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray, length_scale

PART = "each picture"
LOCATION = "camera"
MODES = 2  # a curve that is moved aside, and turned
UNIT_M = 1e-4
SIZES = (0.03, 0.1, 0.3, 1.0, 3.0)  # of that


@dataclass(frozen=True)
class ImageNoise:
    """Standard deviations of the first modes of a configuration's curves."""

    estimated_m: FloatArray
    usual_m: FloatArray

    @property
    def evidence(self) -> float:
        """Ln of how improbable so much noise is, usual noise being known within a factor."""
        above = np.maximum(np.log(self.estimated_m / self.usual_m), 0.0)
        return 0.5 * float(np.sum((above / IMAGE_NOISE_LN) ** 2))

    @property
    def times(self) -> float:
        """How many times as large as usual, in the mode where it is so most."""
        return float(np.max(self.estimated_m / self.usual_m))


def image_noise(fitted: MixedModelFit) -> dict[str, ImageNoise]:
    """Return the noise of configurations for which something says how large it usually is."""
    forward = fitted.problem.forward
    pairs = zip(fitted.problem.noise_names(), np.exp(fitted.solution.log_sigma), strict=True)
    noise = dict(pairs)
    estimated = {
        name: np.array([noise[f"{name} mode {m}"] for m in range(MODES)])
        for name, configuration_model in zip(
            forward.names, forward.configuration_models, strict=True
        )
        if np.count_nonzero(configuration_model.has_curve) >= FEWEST_IMAGES
        and configuration_model.modes >= MODES
    }
    result = {}
    for name, own in estimated.items():
        others = [size for other, size in estimated.items() if other != name]
        if not others:  # the images of one sheet may have more in common than they show
            continue
        usual = np.max(others, axis=0)
        repeats = _of_repeats(fitted, forward.names.index(name))
        if repeats is not None:
            usual = np.maximum(usual, REPEATS_NOISE_RATIO * repeats)
        result[name] = ImageNoise(own, usual)
    return result


def _of_repeats(fitted: MixedModelFit, c: int) -> FloatArray | None:
    """Return the noise (MODES,) that a condition's mean has by that of its images; None: no images.

    By differences of successive images, in which what changes slowly is small.
    """
    forward, state = fitted.problem.forward, fitted.linear.states[c]
    configuration_model, total, count = forward.configuration_models[c], np.zeros(MODES), 0
    for k in np.flatnonzero(configuration_model.has_curve).tolist():
        seen = forward.data_vectors[c].seen[k]
        images = min(int(np.count_nonzero(seen.counts)), len(seen.own_curves))
        if images < 2:
            continue
        points = seen.own_points_m[:, -images:, : configuration_model.curve_s.shape[1]]
        change, n = np.diff(points, axis=1), points.shape[2]
        off = change[0] * state.solved.nx[k, :n] + change[1] * state.solved.ny[k, :n]
        modes = off @ configuration_model.project[k, :MODES, :n].T
        total += np.sum(modes**2, axis=0) / (2.0 * images)
        count += images - 1
    return np.sqrt(total / count) if count else None


def unusual_images(fitted: MixedModelFit) -> list[RankedCandidate]:
    """Return the term of the configuration whose curves are noisier than usual; empty: none are.

    With it are nonparametric terms of all locations at the usual noise, the best of them all first:
    what goes with a coordinate explains more with fewer numbers than pictures each by themselves.
    """
    found = {
        name: one for name, one in image_noise(fitted).items()
        if one.evidence > EVIDENCE_THRESHOLD_LN and _many(fitted, name) > FEWEST_UNUSUAL_IMAGES
    }  # fmt: skip
    if not found:
        return []
    name = max(found, key=lambda n: found[n].evidence)
    forward, solution = fitted.problem.forward, weigh(fitted.linear.data, _usual(fitted, found))
    pool = [_candidate(fitted, name), *unknowns(fitted)]
    scores = scored(forward, Projected.of(forward, fitted.linear, solution), pool)
    return best_of_each(scores, solution)


def _many(fitted: MixedModelFit, name: str) -> float:
    """Return how many images the noise is of: one that is far off is an outlier, no noise."""
    forward, linear, solution = fitted.problem.forward, fitted.linear, fitted.solution
    sizes = image_noise(fitted)[name].estimated_m
    # what the noise, not the scatter of set-ups, has of the residual
    own = sizes**2 * Projected.of(forward, linear, solution).pulled[_rows(fitted, name)]
    squares = np.sum(own**2, axis=1)
    return float(np.sum(squares) ** 2 / np.sum(squares**2))


def _usual(fitted: MixedModelFit, found: Mapping[str, ImageNoise]) -> FloatArray:
    """Return ln of all standard deviations, those of these curves as they usually are."""
    result, names = fitted.solution.log_sigma.copy(), fitted.problem.noise_names()
    for name, one in found.items():
        for m in range(MODES):
            at = names.index(f"{name} mode {m}")
            result[at] = min(result[at], float(np.log(one.usual_m[m])))
    return result


def _candidate(fitted: MixedModelFit, name: str) -> Candidate:
    forward = fitted.problem.forward
    rows = _rows(fitted, name)
    columns = np.zeros((forward.row_index.size, rows.size))
    columns[rows.ravel(), np.arange(rows.size)] = UNIT_M * forward.scale.length
    return Candidate(
        name=f"unknown:{LOCATION}", values={}, columns=columns, sizes=SIZES, location=LOCATION,
        part=f"{PART}, {name}",
    )  # fmt: skip


def _rows(fitted: MixedModelFit, name: str) -> Index:
    """Return the rows of the first modes, (images, MODES)."""
    forward = fitted.problem.forward
    c = forward.names.index(name)
    return forward.row_block(c).mode_rows[forward.configuration_models[c].has_curve, :MODES]


def of_images(candidate: RankedCandidate) -> str:
    """Return the configuration of a term of each image; empty: it is another one."""
    part = candidate.score.candidate.part
    return part.removeprefix(f"{PART}, ") if part.startswith(f"{PART}, ") else ""


@dataclass(frozen=True)
class Aside:
    """How far a curve is off, where a term of each image moves it most; arrays (points,)."""

    name: str  # of the condition
    s_m: FloatArray
    off_m: FloatArray
    sigma_m: FloatArray


def aside(configuration_model: ConfigurationModel, beta: FloatArray, C: FloatArray) -> Aside:
    """Return the curve that a term's sizes (images x MODES) move most; C is their covariance."""
    unit_m = UNIT_M * length_scale(configuration_model.sheet)
    images, size = np.flatnonzero(configuration_model.has_curve), unit_m * beta.reshape(-1, MODES)
    first = int(np.argmax(np.sum(size**2, axis=1)))
    k, own = int(images[first]), slice(MODES * first, MODES * (first + 1))
    s, keep = np.unique(configuration_model.curve_s[k], return_index=True)
    by = np.stack([_shape(configuration_model, k, m) for m in range(MODES)], axis=1)[keep]
    band = unit_m * np.sqrt(np.maximum(np.einsum("sm,mn,sn->s", by, C[own, own], by), 0.0))
    return Aside(_name(configuration_model, k), s, by @ size[first], band)


def _name(configuration_model: ConfigurationModel, k: int) -> str:
    """Return a condition's name, with its session where there are several."""
    one, several = (
        configuration_model.data_vector.seen[k],
        len({other.session for other in configuration_model.data_vector.seen}) > 1,
    )
    return f"{one.name}, session {one.session}" if several else one.name


def _shape(configuration_model: ConfigurationModel, k: int, m: int) -> FloatArray:
    return configuration_model.along(k, np.eye(configuration_model.modes)[m])


def with_usual_noise(fitted: MixedModelFit, candidate: RankedCandidate) -> MixedModelFit:
    """Return a fit that is weighed with the noise of the term."""
    return fitted if candidate.solution is None else replace(fitted, solution=candidate.solution)
