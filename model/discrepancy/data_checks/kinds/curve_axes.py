"""The axes of the curves: mirrored, exchanged, or from the wrong end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import curves_of, with_curves
from model.measurements import Curve, Measurements


def _turned(
    by: Callable[[Curve], tuple[object, object]],
) -> Callable[[Measurements, float], Measurements]:
    def turned(curve: Curve) -> Curve:
        x, y = by(curve)
        return Curve(s_m=curve.s_m, x_m=x, y_m=y)  # type: ignore[arg-type]

    return lambda m, _: with_curves(m, turned)


def _from_the_tip(measurements: Measurements, _: float) -> Measurements:
    def other(curve: Curve) -> Curve:
        s_m = curve.s_m[-1] - curve.s_m[::-1]
        return Curve(s_m=s_m, x_m=curve.x_m[::-1].copy(), y_m=curve.y_m[::-1].copy())

    return with_curves(measurements, other)


WAYS = {
    "with y_mm of the other sign (the picture is mirrored)": _turned(lambda c: (c.x_m, -c.y_m)),
    "with x_mm of the other sign (the picture is mirrored)": _turned(lambda c: (-c.x_m, c.y_m)),
    "with both x_mm and y_mm of the other sign": _turned(lambda c: (-c.x_m, -c.y_m)),
    "with x_mm and y_mm exchanged": _turned(lambda c: (c.y_m, c.x_m)),
    "with x_mm and y_mm exchanged, y_mm of the other sign": _turned(lambda c: (-c.y_m, c.x_m)),
    "with x_mm and y_mm exchanged, x_mm of the other sign": _turned(lambda c: (c.y_m, -c.x_m)),
    "from the other end: their points go from the tip to the clamp": _from_the_tip,
}


@dataclass(frozen=True)
class CurveAxes(DataCheck):
    """Other axes than the clamp's."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        if not curves_of(measurements):
            return
        for way, apply in WAYS.items():
            yield _change(way, apply)


def _change(way: str, apply: Callable[[Measurements, float], Measurements]) -> Change:
    return Change(
        where="curves.csv",
        apply=apply,
        sentence=lambda names, _value, _sigma: f"the curves of {names} fit {way}",
        values=(1.0,),
    )


CHECK = CurveAxes(name="curve_axes", meaning="the axes of the curves against the clamp's", order=70)
