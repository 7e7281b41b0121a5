"""Calibrate a load cell with dead weights: a straight line, and how far to believe it."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drivers.interfaces import FloatArray
from drivers.load_cell import CalibrationError, LoadCellCalibration

_ONE_SIGMA = 0.8413447460685429  # share of a normal distribution below +1 sigma


@dataclass(frozen=True, kw_only=True)
class CalibrationFit:
    """volts = offset + sensitivity * load by least squares. Sigmas are standard uncertainties."""

    sensitivity_V_per_N: float
    offset_V: float
    sensitivity_sigma_V_per_N: float
    offset_sigma_V: float
    correlation: float  # of the two estimates
    residuals_N: FloatArray  # measured minus fitted, one for each load
    residual_sigma_N: float  # scatter about the line

    def calibration(
        self,
        date: dt.date,
        capacity_N: float,
        input_range_V: float,
        excitation_V: float = 10.0,
        gain: float = 1.0,
        serial: str = "",
    ) -> LoadCellCalibration:
        """Return the calibration to be kept."""
        return LoadCellCalibration(
            date=date,
            capacity_N=capacity_N,
            sensitivity_V_per_N=self.sensitivity_V_per_N,
            offset_V=self.offset_V,
            sensitivity_sigma_V_per_N=self.sensitivity_sigma_V_per_N,
            offset_sigma_V=self.offset_sigma_V,
            input_range_V=input_range_V,
            excitation_V=excitation_V,
            gain=gain,
            serial=serial,
        )


def fit_calibration(
    loads_N: Sequence[float] | FloatArray,
    volts: Sequence[float] | FloatArray,
    volts_sigma_V: float = 0.0,
) -> CalibrationFit:
    """Fit a line through dead weights `loads_N` (0 included) and the mean volts of each.

    `volts_sigma_V`: known standard uncertainty of one mean; the larger of it and the scatter about
    the line counts, since few weights can lie on a line by chance.
    """
    loads, measured = np.asarray(loads_N, dtype=float), np.asarray(volts, dtype=float)
    _check(loads, measured)
    design = np.column_stack([np.ones_like(loads), loads])
    (offset, slope), *_ = np.linalg.lstsq(design, measured, rcond=None)
    residuals_V = measured - design @ np.array([offset, slope])
    freedom = loads.size - 2
    scatter_V = float(np.sqrt(residuals_V @ residuals_V / freedom))
    sigma_V = max(scatter_V * _small_sample_factor(freedom), volts_sigma_V)
    if slope == 0.0 or abs(slope) < 3.0 * sigma_V / np.sqrt(_spread(loads)):
        raise CalibrationError(
            "load cell calibration: the voltage does not follow the weights; check wiring, "
            "excitation and range"
        )
    covariance = sigma_V**2 * np.linalg.inv(design.T @ design)
    sigmas = np.sqrt(np.diag(covariance))
    return CalibrationFit(
        sensitivity_V_per_N=float(slope),
        offset_V=float(offset),
        sensitivity_sigma_V_per_N=float(sigmas[1]),
        offset_sigma_V=float(sigmas[0]),
        correlation=_correlation(loads),
        residuals_N=residuals_V / slope,
        residual_sigma_N=scatter_V / abs(float(slope)),
    )


def _check(loads: FloatArray, measured: FloatArray) -> None:
    if loads.shape != measured.shape or loads.ndim != 1:
        raise CalibrationError(
            f"load cell calibration: {loads.size} weights but {measured.size} voltages"
        )
    if not (np.all(np.isfinite(loads)) and np.all(np.isfinite(measured))):
        raise CalibrationError("load cell calibration: a weight or a voltage is not a number")
    if loads.size < 3 or np.unique(loads).size < 2:
        raise CalibrationError(
            "load cell calibration: at least three readings with two different weights are needed "
            "(0 counts as one)"
        )


def _spread(loads: FloatArray) -> float:
    return float(np.sum((loads - loads.mean()) ** 2))


def _correlation(loads: FloatArray) -> float:
    """Correlation of offset and slope; it depends on where the weights lie only."""
    return float(-loads.sum() / np.sqrt(loads.size * np.sum(loads**2)))


def _small_sample_factor(freedom: int) -> float:
    """Return the factor by which ± sigma covers 68.3 % for few points (Student's t)."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, _ONE_SIGMA))
