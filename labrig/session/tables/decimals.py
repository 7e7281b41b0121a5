"""Numbers between SI and what people read, without loss: 0.005 m is 5 mm and back again."""

from __future__ import annotations

import math
from decimal import Context, Decimal, InvalidOperation

_SHORT = 28  # characters: so many digits Decimal keeps
# Enough digits that an angle survives the way to degrees and back.
_WIDE = Context(prec=30)
MINUS = "\N{MINUS SIGN}"  # what some programs write in front of numbers
PI = Decimal("3.14159265358979323846264338327950288")


def milli(value: float) -> str:
    """Return a number in thousandths: metres as mm, newtons as mN."""
    return _plain(Decimal(repr(float(value))).scaleb(3))


def from_milli(text: str) -> float:
    """Return the reverse of `milli`. Raises ValueError for what is no finite number."""
    if len(text) <= _SHORT:
        try:
            # The exponent is that of the text, so the number is rounded once, as Decimal does it;
            # "nan" and texts with an exponent of their own are no number then.
            return float(text + "e-3")
        except ValueError:
            pass
    return float(_decimal(text).scaleb(-3))


def plain(value: float) -> str:
    """Return a number as it is."""
    return _plain(Decimal(repr(float(value))))


def from_plain(text: str) -> float:
    """Return the reverse of `plain`. Raises ValueError for what is no finite number."""
    if len(text) <= _SHORT:
        try:
            return float(text + "e0")
        except ValueError:
            pass
    return float(_decimal(text))


def degrees(value_rad: float) -> str:
    """Return an angle in degrees, as short as it can be without loss."""
    short = plain(math.degrees(value_rad))
    if from_degrees(short) == value_rad:
        return short
    exact = _WIDE.multiply(Decimal(float(value_rad)), _WIDE.divide(Decimal(180), PI))
    return _plain(Context(prec=21).plus(exact))


def from_degrees(text: str) -> float:
    """Return the reverse of `degrees`, in rad. Raises ValueError for what is no finite number."""
    return float(_WIDE.multiply(_decimal(text), _WIDE.divide(PI, Decimal(180))))


def _decimal(text: str) -> Decimal:
    try:
        value = Decimal(text.strip().replace(MINUS, "-"))
    except InvalidOperation:
        raise ValueError(f"{text!r} is no number") from None
    if not value.is_finite() or not math.isfinite(float(value)):
        raise ValueError(f"{text!r} is not finite")
    return value


def _plain(value: Decimal) -> str:
    """Without an exponent where that is short, and without empty decimals."""
    text = f"{value:f}" if -12 < value.adjusted() < 12 else str(value)
    if "." in text and "E" not in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
