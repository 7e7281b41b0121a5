"""`labrig.sheet`: the model of a sheet from plain numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from labrig.api.arguments import number, pair
from labrig.api.eibm import Eibm, Rows, stated, stated_by_voltage
from labrig.errors import BadInputError
from model.measurements import SheetGeometry
from model.measurements.known_arguments import known_arguments
from model.sheet.sheet_model import SheetModel
from model.sheet.stated import SOFTEST_PA, STIFFEST_PA, stated_model

USUAL_V = 2.0  # the paper's driving voltage, where one EIBM is stated without a voltage


@known_arguments
def sheet(
    *,
    free_length_mm: float,
    width_mm: float,
    thickness_mm: float,
    EIBM_Nm: Eibm | Mapping[float, Eibm],
    B_Nm2: float | None = None,
    E_Pa: float | None = None,
    elongation_mm: float = 0.0,
    initial_curvature_per_m: float | Rows = 0.0,
    arc_radius_mm: float = 40.0,
    arc_origin_deg: float = 0.0,
    name: str = "sheet",
) -> SheetModel:
    """Return the model of a sheet from plain numbers, taken as exact.

    Args:
        free_length_mm: l, length of the part that can bend, in mm.
        width_mm: w, in mm.
        thickness_mm: d, in mm.
        EIBM_Nm: electrically induced bending moment in N m. By voltage, as `{2.0: 36e-6,
            -2.0: -28e-6}`, each a number, a function of s in m, or a pair of rows (s in m, EIBM
            in N m). Without a voltage it is that at +2 V, and its opposite that at -2 V.
        B_Nm2: bending stiffness in N m².
        E_Pa: equivalent Young modulus in Pa, in place of B_Nm2: B = E w d³/12.
        elongation_mm: length of a rigid elongation beyond the free length, in mm; 0: none.
        initial_curvature_per_m: k0 in 1/m, a number or a pair of rows (s in mm as in sheet.toml,
            not in m as that of EIBM_Nm; k0 in 1/m).
        arc_radius_mm: radius of the object's trajectory about the clamp, in mm.
        arc_origin_deg: polar angle of position 0, in degrees from the clamp's tangent.
        name: of the configuration, for `predict`, `simulate` and `design`.

    Returns:
        SheetModel: as `labrig.load_model` returns it; `labrig.save_model` writes it.

    Raises:
        BadInputError, ModelError: one sentence for a number that no sheet has.

    Example:
        >>> import labrig
        >>> long = labrig.sheet(
        ...     free_length_mm=50, width_mm=11, thickness_mm=0.21, B_Nm2=1.27e-6,
        ...     EIBM_Nm={2.0: 36e-6, -2.0: -28e-6},
        ... )
        >>> round(1e3 * long.predict("sheet", 0.01, 2.0).F_N, 2)  # mN
        0.74

    """
    from labrig.config.base import validate
    from labrig.config.sheet import ArcConfig, Sheet

    arc = validate(
        ArcConfig, {"radius_mm": arc_radius_mm, "origin_deg": arc_origin_deg}, "labrig.sheet"
    )
    table = {
        "free_length_mm": free_length_mm, "width_mm": width_mm, "thickness_mm": thickness_mm,
        "elongation_mm": elongation_mm,
        "initial_curvature_per_m": _initial_curvature(initial_curvature_per_m),
    }  # fmt: skip
    geometry = validate(Sheet, table, "labrig.sheet").geometry(name, arc)
    _require_plausible(geometry)
    length_m = geometry.free_length_m
    if isinstance(EIBM_Nm, Mapping):
        moments = stated_by_voltage("EIBM_Nm", EIBM_Nm, length_m)
    else:
        up = stated(USUAL_V, EIBM_Nm, length_m)
        down = (up[0], -up[1]) if isinstance(up, tuple) else -up
        moments = {USUAL_V: up, -USUAL_V: down}
    return stated_model(geometry, _stiffness(geometry, B_Nm2, E_Pa), moments)


def _initial_curvature(given: object) -> float | dict[str, list[float]]:
    if not isinstance(given, Iterable):
        return number("initial_curvature_per_m", given)
    wanted = "a number, or a pair (s in mm, k0 in 1/m) of equally long rows is needed"
    s_mm, per_m = pair("initial_curvature_per_m", given, wanted)
    return {"s_mm": s_mm, "per_m": per_m}


def _require_plausible(geometry: SheetGeometry) -> None:
    """Raise BadInputError for lengths and curvatures in another unit."""
    from labrig.plausibility.set_up import initial_curvature_checks, length_checks

    checks = (*length_checks(geometry), *initial_curvature_checks(geometry))
    wrong = [check for check in checks if not check.ok]
    if wrong:
        key = wrong[0].name.partition("] ")[2]
        raise BadInputError(f"labrig.sheet: {key}: {wrong[0].found}, wanted {wrong[0].wanted}.")


def _stiffness(geometry: SheetGeometry, B_Nm2: float | None, E_Pa: float | None) -> float:
    if (B_Nm2 is None) is (E_Pa is None):
        raise BadInputError("labrig.sheet: give either B_Nm2 or E_Pa.")
    if E_Pa is None:
        return number("B_Nm2", B_Nm2)
    E_Pa = number("E_Pa", E_Pa, above=0.0)
    if not SOFTEST_PA <= E_Pa <= STIFFEST_PA:
        raise BadInputError(
            f"labrig.sheet: E_Pa = {E_Pa:g}: no solid has such an equivalent Young modulus; one "
            "of a sheet is some 1e8 Pa."
        )
    return E_Pa * geometry.width_m * geometry.thickness_m**3 / 12.0
