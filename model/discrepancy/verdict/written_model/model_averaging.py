"""Uncertainties of parameters, as probable as it is that the catalogue's forms are exact.

A form may differ from the catalogue's, and what it may differ by makes a parameter uncertain by a
few per cent, however good the data are. Data that ask for no deviation make it improbable that
there is one: then the parameter is known as well as the data tell it (Bayesian model averaging,
Hoeting et al. 1999, doi:10.1214/ss/1009212519).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from model.discrepancy.thresholds import EVIDENCE_TEMPERATURE
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.model_state import Found


def averaged_over_forms(exact: MixedModelFit, tolerant: MixedModelFit) -> tuple[Found, ...]:
    """Return the effects of a fit with exact forms, as uncertain as the mean over both kinds.

    `tolerant` has the same effects, with forms that may differ, and uncertainties that hold their
    other shapes, too; both are as probable beforehand.
    """
    ahead = 0.5 * (tolerant.deviance - exact.deviance) / EVIDENCE_TEMPERATURE
    share = float(1.0 / (1.0 + np.exp(-np.clip(ahead, -50.0, 50.0))))
    return tuple(
        replace(one, sigma=_averaged(share, one, other, _of_shapes(other, tolerant, index)))
        for index, (one, other) in enumerate(zip(exact.found, tolerant.found, strict=True))
    )


def _averaged(
    share: float, exact: Found, tolerant: Found, shapes: Mapping[str, Mapping[str, float]]
) -> dict[str, dict[str, float]]:
    """Return the uncertainties of a mixture of both, by configuration and parameter."""
    result = dict[str, dict[str, float]]()
    for name, own in tolerant.sigma.items():
        result[name] = {}
        for key, sigma in own.items():
            apart = tolerant.values[name][key] - exact.values[name][key]
            known = exact.sigma.get(name, {}).get(key, sigma) ** 2 + shapes[name][key]
            variance = share * known + (1.0 - share) * (sigma**2 + apart**2)
            result[name][key] = float(np.sqrt(variance))
    return result


def _of_shapes(one: Found, fitted: MixedModelFit, index: int) -> dict[str, dict[str, float]]:
    """Return the variance that other shapes of an effect make, by configuration and parameter."""
    sigma = np.sqrt(np.maximum(np.diag(fitted.solution.covariance), 0.0))
    result = {name: dict.fromkeys(own, 0.0) for name, own in one.sigma.items()}
    for place, (parameter, names) in enumerate(one.parameters(), fitted.spans[index].start):
        for name in names:
            key = parameter.name
            if key in result.get(name, {}):
                scale = one.values[name][key] if parameter.log else 1.0
                without = (sigma[place] * scale) ** 2
                result[name][key] = max(one.sigma[name][key] ** 2 - float(without), 0.0)
    return result
