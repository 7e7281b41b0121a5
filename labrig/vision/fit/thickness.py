"""Measure the visible thickness of a sheet where it is not stated."""

from __future__ import annotations

import numpy as np

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import StripGeometry
from labrig.vision.curve.shape import coefficients_for, make_basis
from labrig.vision.fit.context import FitContext, roll_mask
from labrig.vision.fit.curve_fit import fit_points, ridge_points, spectral_of
from labrig.vision.image.image import GreyImage
from labrig.vision.search.ridge_tracing import ridge_maps, shape_through, trace_from_clamp
from labrig.vision.thresholds import THICKNESS_CHANGE_MIN_PX

LINE_SPREAD_WIDTH_PX = 2.7  # full width at half height of the thinnest sheet, by lens and smoothing
THINNEST_PX = 1.0  # a thinner line looks the same
WIDTH_REACH_PX = 30


def visible_thickness_m(image: GreyImage, optics: Optics, strip: StripGeometry) -> float:
    """Return the thickness that the likeliest path from the clamp shows.

    The guess, where none is seen.
    """
    guess_px = strip.thickness_m * optics.px_per_m
    free_px, total_px = strip.free_length_m * optics.px_per_m, strip.length_m * optics.px_per_m
    ridges = ridge_maps(image, guess_px, wide=True)
    signs = {"bright": [1.0], "dark": [-1.0], "auto": [1.0, -1.0]}[optics.polarity]
    traces = [(sign, trace_from_clamp(ridges, optics, strip, sign)) for sign in signs]
    found = [(trace.score, sign, trace) for sign, trace in traces if trace is not None]
    if not found:
        return strip.thickness_m
    _, sign, trace = max(found, key=lambda each: each[0])
    basis = make_basis(free_px, total_px, coefficients_for(free_px))
    context = FitContext(
        image=image,
        optics=optics,
        sign=sign,
        prior=np.array([optics.clamp_sigma_px, optics.clamp_angle_sigma_rad]),
        spectral=spectral_of(optics, strip),
        mask=roll_mask(optics, image.grey.shape),
    )
    shape = shape_through(trace, optics, basis, context.spectral)
    shape = fit_points(shape, context, half_width=guess_px / 2)
    _, height, width = ridge_points(shape, context, np.full(len(basis.s), WIDTH_REACH_PX))
    seen = np.isfinite(width) & (basis.s <= basis.free_px) & (height > 2 * image.noise)
    if not seen.any():
        return strip.thickness_m
    full_px = float(np.median(width[seen]))
    thickness_px = float(np.sqrt(max(full_px**2 - LINE_SPREAD_WIDTH_PX**2, THINNEST_PX**2)))
    if abs(thickness_px - guess_px) < THICKNESS_CHANGE_MIN_PX:
        return strip.thickness_m
    return min(thickness_px / optics.px_per_m, 0.3 * strip.free_length_m)
