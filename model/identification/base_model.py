"""The base model: which parameters it has, and where they stand in the vector of all.

Of a configuration these are ln B; for each driving voltage Me/B, as coefficients of Legendre
polynomials along the sheet; and a change of the initial curvature k0, likewise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from model.identification.data.data_vector import DataVector
from model.identification.likelihood.common_errors.camera_calibration import CalibrationErrors
from model.identification.likelihood.common_errors.drive_rise import RISE
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import (
    WIDE_EIBM_PER_M,
    AtZero,
    BaseParameters,
    Bases,
)
from model.identification.priors.shared_widths import SharedWidth
from model.measurements import (
    CameraUncertainty,
    FloatArray,
    ModelError,
    SheetGeometry,
    in_digits,
    length_scale,
)
from model.mechanics.field import legendre_field

# of sheets of the paper's size; others are bent in proportion to 1/length
FREE_REST_PER_M = 60.0  # prior width of k0's terms where sheet.toml does not state k0
FORM_PER_M = 60.0  # and of a change of Me/B along the sheet
REST_PER_M = 1.0  # and of k0's terms where it does, unless another width is asked for
LEAST_BOW_PER_M = 1e-3  # of k0 between the nodes at which it is stated
# Prior width of how much more, relatively, a voltage that stays bends a sheet than its share of a
# pulse does: what charging, back-relaxation and the first pulses change.
MORE_AT_ZERO = 0.3
# Where no force was measured the shapes know Me/B alone, and B is what somebody states, or that of
# a usual material; it is not estimated.
USUAL_MODULUS_PA = 1e8
NOT_ESTIMATED_LN = 1e-6  # width of its prior
MOST_TERMS = 6  # of a quantity along a sheet as long as the arc's radius


@dataclass(frozen=True, kw_only=True)
class BaseOptions:
    """Choices of the base model."""

    symmetric: bool = False  # one |EIBM| for both polarities
    along: bool = False  # Me/B varies along the sheet, where there are curves
    # prior width of each term of a change of the stated k0, where there are curves; 0: it is exact;
    # None: exact but for what lies between its nodes
    rest_sigma_per_m: float | None = None
    stiffness_Nm2: float | None = None  # B of a configuration without forces; None: the usual one

    def __post_init__(self) -> None:
        B = self.stiffness_Nm2
        if B is not None and not (np.isfinite(B) and B > 0.0):
            raise ModelError(f"the stiffness B must be a positive number of N m^2, not {B:g}")


def bases_of(forward: ForwardModel, known: Sequence[bool], options: BaseOptions) -> Bases:
    """Return B, EIBM, what is not known of k0 by configuration; and what is common to them.

    That is what is not known of the camera's calibration, where that is stated, and of how pulses
    rise, where they are recorded.
    """
    parts, place = [], 0
    for configuration_model, stated in zip(forward.configuration_models, known, strict=True):
        part, place = _part(configuration_model, place, options, stated=stated)
        parts.append(part)
    result = Bases(parts=tuple(parts), size=place)
    camera = CalibrationErrors(first=place, stated=_stated(forward))
    if camera.sigma:
        result = replace(result, camera=camera, size=camera.places.stop)
    if any(data_vector.pulses for data_vector in forward.data_vectors):
        result = replace(result, rise=result.size, size=result.size + len(RISE))
    return result


def _stated(forward: ForwardModel) -> CameraUncertainty:
    """Return what a calibration states of its errors, where there are curves."""
    seen = [one.data_vector for one in forward.configuration_models if one.has_curve.any()]
    return reduce(CameraUncertainty.larger, (one.camera for one in seen), CameraUncertainty())


def with_shared_width(bases: Bases) -> Bases:
    """Return the base model with a width, as the data tell it, of how the EIBM changes along.

    The one that it has is the largest. That of k0 stays: how exactly somebody stated it is not to
    be seen in shapes that a tilt of the clamp bends as well.
    """
    places = tuple(dict.fromkeys(
        i for one in bases.parts for first, _ in one.eibm.values()
        for i in range(first + 1, first + len(one.forms))
    ))  # fmt: skip
    if not places:
        return bases
    largest = max(one.prior[i][1] for one in bases.parts for i in places if i in one.prior)
    shared = SharedWidth(places=places, largest=largest, width=largest)
    return replace(bases, shared=(shared,))


def _part(
    configuration_model: ConfigurationModel, place: int, options: BaseOptions, *, stated: bool
) -> tuple[BaseParameters, int]:
    """One configuration's parameters from `place` on, and the place after them."""
    curves, (stiffness, place) = bool(configuration_model.has_curve.any()), (place, place + 1)
    forms = along_sheet(
        configuration_model, terms(configuration_model.sheet) if options.along and curves else 1
    )
    eibm: dict[float, tuple[int, float]] = {}
    prior: dict[int, tuple[float, float]] = {}
    if not weighs(configuration_model.data_vector):
        B = options.stiffness_Nm2 or usual_stiffness(configuration_model.sheet)
        prior[stiffness] = (float(np.log(B)), NOT_ESTIMATED_LN)
    own: dict[float, int] = {}
    scale = length_scale(configuration_model.sheet)
    for voltage in configuration_model.data_vector.voltages_V:
        key = abs(voltage) if options.symmetric else voltage
        if key not in own:
            own[key], place = place, place + len(forms)
            prior |= dict.fromkeys(range(own[key] + 1, place), (0.0, FORM_PER_M / scale))
            prior[own[key]] = 0.0, WIDE_EIBM_PER_M / scale
        eibm[voltage] = (own[key], -1.0 if options.symmetric and voltage < 0.0 else 1.0)
    rows, belief = _rest_rows(
        configuration_model, options.rest_sigma_per_m, curves=curves, stated=stated
    )
    rest = dict(enumerate(rows, place))
    prior |= dict.fromkeys(rest, belief)
    place += len(rest)
    at_zero = _at_zero(configuration_model.data_vector.zero_V, eibm, place)
    if at_zero is not None:
        prior[place], place = (0.0, MORE_AT_ZERO), place + 1
    part = BaseParameters(
        stiffness=stiffness, eibm=eibm, forms=forms, rest=rest, prior=prior, at_zero=at_zero
    )
    return part, place


def _at_zero(zero_V: float, eibm: Mapping[float, tuple[int, float]], place: int) -> AtZero | None:
    """Return of which EIBM how much acts while 0 V is asked for: about its share of the voltage.

    It is that of the smallest voltage of the same sign; of one polarity alone, of the other one.
    """
    if not eibm or not zero_V:
        return None
    nearest_V = min(eibm, key=lambda voltage: (voltage * zero_V < 0.0, abs(voltage)))
    first, sign = eibm[nearest_V]
    return AtZero(eibm=first, share=sign * zero_V / nearest_V, more=place)


def _rest_rows(
    configuration_model: ConfigurationModel,
    sigma_per_m: float | None,
    *,
    curves: bool,
    stated: bool,
) -> tuple[FloatArray, tuple[float, float]]:
    """Return one change of k0 at the nodes per parameter, and the middle and width of its prior."""
    none = np.zeros((0, configuration_model.count))
    if not stated:
        return along_sheet(configuration_model, terms(configuration_model.sheet)), (
            0.0,
            FREE_REST_PER_M / length_scale(configuration_model.sheet),
        )
    if sigma_per_m is None:
        bow = between_nodes(configuration_model.sheet, configuration_model.s_m)
        return (none if bow is None else bow[None]), (0.5, 0.5)
    if sigma_per_m > 0.0 and curves:
        return along_sheet(configuration_model, terms(configuration_model.sheet)), (
            0.0,
            sigma_per_m,
        )
    return none, (0.0, 1.0)


def weighs(data_vector: DataVector) -> bool:
    """Return whether there is a force, without which B is not determined."""
    return any(len(one.kept_N) for one in data_vector.seen if not one.free)


def not_weighed(name: str, B_Nm2: float) -> str:
    """Return the sentence on what a configuration without forces leaves open."""
    return (
        f"'{name}' has no forces: B is not determined by these data, only EIBM/B is; forces and"
        f" EIBM are stated for B = {in_digits(1e6 * B_Nm2, 3)} µN·m²"
    )


def usual_stiffness(sheet: SheetGeometry) -> float:
    """Return B of a sheet of the usual material, N m^2."""
    return USUAL_MODULUS_PA * sheet.width_m * sheet.thickness_m**3 / 12.0


def terms(sheet: SheetGeometry) -> int:
    """Return how many terms a quantity along the sheet has."""
    share = min(1.0, sheet.free_length_m / sheet.arc_radius_m)
    return 1 + round((MOST_TERMS - 1) * share)


def along_sheet(configuration_model: ConfigurationModel, count: int) -> FloatArray:
    """Return Legendre polynomials at the nodes: (count, G)."""
    return np.stack(
        [
            legendre_field(i, configuration_model.length)(configuration_model.s_m)
            for i in range(count)
        ]
    )


def between_nodes(sheet: SheetGeometry, s_m: FloatArray) -> FloatArray | None:
    """Mean difference of a smooth curve and straight lines between the stated nodes of k0.

    Nobody says which of the two is meant, and it is more than shapes can see.
    """
    if sheet.initial_curvature is None or len(sheet.initial_curvature[0]) < 4:
        return None
    from scipy.interpolate import CubicSpline  # slow to import

    s, k = sheet.initial_curvature
    second = CubicSpline(s, k)(np.clip(s_m, s[0], s[-1]), 2)
    width = np.interp(s_m, 0.5 * (s[1:] + s[:-1]), np.diff(s))
    bow: FloatArray = -second * width**2 / 12.0
    return bow if np.max(np.abs(bow)) > LEAST_BOW_PER_M / length_scale(sheet) else None
