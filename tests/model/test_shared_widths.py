"""How large terms along the sheet are is told by all of them; what is not there takes no noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import FitOptions, fit
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.noise.row_covariance import Data
from model.identification.priors.shared_widths import SharedWidth, estimated_widths

TERMS, NOISE = 20, 1.0
ANY = SharedWidth(places=tuple(range(1, TERMS + 1)), largest=60.0, width=60.0)


def data_of(terms, random) -> Data:
    """A level of 25, and terms each of which 30 numbers see, with noise of 1."""
    X = random.standard_normal((30, TERMS, 1 + len(terms)))
    values = np.concatenate([[25.0], terms])
    y = X @ values + NOISE * random.standard_normal((30, TERMS))
    return Data(
        y=y, X=X, groups=[], masks=[np.ones((30, TERMS))], fixed=np.full((30, TERMS), 1e-9),
        precision=np.concatenate([[0.0], np.full(len(terms), 60.0**-2)]),
        away=np.zeros(1 + len(terms)),
    )  # fmt: skip


def width_found(data: Data) -> float:
    solution = weigh(data, np.log([NOISE]))
    return estimated_widths([ANY], data, solution)[0].width


@pytest.mark.parametrize("size", [0.3, 5.0])
def test_the_width_is_the_size_of_terms_that_are_there(size):
    random = np.random.default_rng(1)
    found = [width_found(data_of(size * random.standard_normal(TERMS), random)) for _ in range(8)]
    assert np.mean(np.log(found)) == pytest.approx(np.log(size), abs=0.15)


def test_terms_that_are_not_there_have_a_width_within_their_noise():
    random = np.random.default_rng(2)
    data = data_of(np.zeros(TERMS), random)
    each = float(np.sqrt(weigh(data, np.log([NOISE])).covariance[1, 1]))
    assert width_found(data) < 0.5 * each


def test_the_width_does_not_depend_on_where_the_model_is_linearised():
    random = np.random.default_rng(3)
    terms = random.standard_normal(TERMS)
    data = data_of(terms, random)
    step = 0.7 * random.standard_normal(TERMS)  # the parameters are there already
    moved = replace(data, y=data.y - data.X[:, :, 1:] @ step, away=data.away + np.append(0.0, step))
    assert width_found(moved) == pytest.approx(width_found(data), rel=1e-6)


@pytest.mark.slow
def test_a_constant_eibm_is_found_as_well_as_if_it_were_known_to_be_constant(measure):
    """With the widest prior each term follows the noise, and the mean goes with them."""
    sizes = []
    for seed in (21, 22):
        free, known = (
            # with k0 as stated: what differs from it is counted as EIBM
            fit(
                measure(seed=seed, names=("long",)),
                FitOptions(eibm_form=form, initial_curvature_sigma_per_m=0.0),
            )
            for form in ("along", "constant")
        )
        for volts in (2.0, -2.0):
            along, sigma = free.configurations["long"].eibm_along_Nm[volts]
            mean = known.configurations["long"].eibm[volts]
            assert abs(free.configurations["long"].eibm[volts].value - mean.value) < mean.sigma
            sizes.append([np.std(along), np.mean(sigma) / mean.sigma, mean.value])
    spread, unsure, mean = np.abs(sizes).T
    assert np.max(spread / mean) < 0.005
    assert np.mean(unsure) < 1.5
