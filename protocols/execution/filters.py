"""The symmetric filter around a sampling point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Filtered:
    """A filtered sample, one value for each row that was filtered."""

    value: FloatArray  # shape of the samples without their last axis
    noise_factor: float  # sigma of the value over sigma of one sample, for white noise


def symmetric_mean(
    samples: npt.ArrayLike, centre_index: float, half_window_samples: float
) -> Filtered:
    """Return the signal at a fractional index, from the samples within the half window of it.

    `samples` has shape (..., n); sample i of the last axis has index i. The value is that of a
    straight line at the centre, fitted with Hann weights that fall to 0 at the window's ends. So
    a linear trend leaves it unbiased wherever between two samples the centre lies; weights alone
    would be off by the trend times their own asymmetry. A window of less than one sample to
    either side interpolates between the two nearest. Raises ValueError when the window reaches
    beyond the samples.
    """
    data = np.asarray(samples, dtype=np.float64)
    first, last = window(centre_index, half_window_samples)
    if first < 0 or last >= data.shape[-1]:
        raise ValueError(
            f"the filter needs samples {first} to {last}; there are 0 to {data.shape[-1] - 1}"
        )
    offsets = np.arange(first, last + 1, dtype=np.float64) - np.float64(centre_index)
    weights = symmetric_weights(offsets, half_window_samples)
    value = np.asarray(data[..., first : last + 1] @ weights)
    return Filtered(value, float(np.sqrt(weights @ weights)))


def window(centre_index: float, half_window_samples: float) -> tuple[int, int]:
    """First and last index whose weight is not 0."""
    reach = max(half_window_samples, 1.0)
    first, last = math.ceil(centre_index - reach), math.floor(centre_index + reach)
    first += centre_index - first >= reach
    last -= last - centre_index >= reach
    return first, last


def symmetric_weights(offsets: FloatArray, half_window_samples: float) -> FloatArray:
    """Weights of samples at `offsets` from the centre; they sum to 1 and have no first moment."""
    reach = max(half_window_samples, 1.0)
    hann = np.cos(0.5 * np.pi * offsets / reach) ** 2
    s0, s1, s2 = (float(hann @ offsets**power) for power in (0, 1, 2))
    determinant = s0 * s2 - s1 * s1
    if determinant <= 1e-12 * s0 * s0:  # a single sample, and it lies at the centre
        return hann / s0
    weights: FloatArray = hann * (s2 - s1 * offsets) / determinant
    return weights
