"""What the names of columns mean: the quantity, and how its unit differs from ours."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from typing import Final

from labrig.session.tables import columns
from labrig.session.tables.decimals import PI

# Each unit: what it measures, and the power of ten to the SI unit.
_UNITS: Final = {
    "N": ("force", 0), "mN": ("force", -3), "uN": ("force", -6), "kN": ("force", 3),
    "gf": ("force", -3), "mgf": ("force", -6), "kgf": ("force", 0),
    "m": ("length", 0), "cm": ("length", -2), "mm": ("length", -3), "um": ("length", -6),
    "V": ("voltage", 0), "mV": ("voltage", -3), "uV": ("voltage", -6), "kV": ("voltage", 3),
    "s": ("time", 0), "ms": ("time", -3), "us": ("time", -6),
    "A": ("current", 0), "mA": ("current", -3), "uA": ("current", -6),
    "1/m": ("curvature", 0), "per_m": ("curvature", 0), "m-1": ("curvature", 0),
    "1/mm": ("curvature", 3), "deg": ("angle", 0), "degrees": ("angle", 0),
    "\N{DEGREE SIGN}": ("angle", 0), "rad": ("angle", 0), "radians": ("angle", 0),
}  # fmt: skip
_WEIGHTS: Final = ("gf", "mgf", "kgf")  # times standard gravity
_GRAVITY: Final = Decimal("9.80665")
_RADIANS: Final = ("rad", "radians")  # all other angles are degrees
POSITION: Final = "position_mm"  # on the arc: an angle times its radius
_MICRO = str.maketrans({"\N{MICRO SIGN}": "u", "\N{GREEK SMALL LETTER MU}": "u"})
_BRACKETS = re.compile(r"(?P<name>.*?)[\s_]*[(\[<{]\s*(?P<unit>[^()\[\]<>{}]*?)\s*[)\]>}]\s*")
_SLASH = re.compile(r"(?P<name>.*?)\s*/\s*(?P<unit>\S+)")
_WORD = re.compile(r"(?P<name>.+?)(?:\s+in\s+|[\s_]+)(?P<unit>\S+)")

# Names that others give to a column, lower case. They are offered, not taken.
_OTHERS: Final = {
    "configuration": "config sheet sample strip specimen konfiguration probe",
    "position_mm": "p pos arc place angle ort bogen winkel \u4f4d\u7f6e \uc704\uce58",
    "voltage_V": "u v volt volts spannung tension u_sheet \u96fb\u5727 \u7535\u538b \uc804\uc555",
    "reading": "no nr number trial repeat repetition measurement",
    "force_mN": "f load kraft mean mean_force force_mean mittelwert \u529b \u8377\u91cd \ud798",
    "sd_mN": "std stdev stddev sigma s f_sd f_std force_sd force_std deviation",
    "mean_of": "n count counts readings repeats",
    "point": "i k index nr no",
    "x_mm": "xs x_value x_data",
    "y_mm": "ys y_value y_data",
    "s_mm": "arc_length arclength",
    "time_s": "t x_value zeit temps",
    "drive_V": "u v voltage volt spannung",
    "current_mA": "i strom",
    "mounting": "mount set_up",
    "tilt_deg": "tilt",
}


@dataclass(frozen=True)
class Unit:
    """A unit as written: what it measures, its power of ten, and a factor beside it."""

    written: str
    measures: str
    exponent: int
    times: Decimal = Decimal(1)

    @property
    def in_rad(self) -> Decimal:
        """How many radians a unit of an angle is."""
        return Decimal(1) if self.written in _RADIANS else PI / 180


@dataclass(frozen=True)
class SplitName:
    """A column's name without its unit, and the unit where it has one that is known."""

    base: str  # as written
    unit: Unit | None
    unknown: str = ""  # a unit in brackets that is not known

    @property
    def word(self) -> str:
        """The name in lower case, its words joined."""
        return re.sub(r"[\s_\-.]+", "_", self.base.strip().lower()).strip("_")


def unit_of(text: str) -> Unit | None:
    """Return the unit that a text is; None where it is none that is known."""
    plain = text.strip().translate(_MICRO).strip("[]() ")
    found = _UNITS.get(plain)
    if found is None:
        return None
    return Unit(text.strip(), *found, times=_GRAVITY if plain in _WEIGHTS else Decimal(1))


def units_of(column: str) -> list[str]:
    """Return the units that are known of what one of our columns measures."""
    own = own_unit(column)
    measures = own.measures if own else None
    return [text for text, (what, _) in _UNITS.items() if what == measures]


def fits(unit: Unit, column: str) -> bool:
    """Whether values in a unit can be made those of our column; a place on the arc is an angle."""
    own = own_unit(column)
    if own is None:
        return False
    return unit.measures == own.measures or (column == POSITION and unit.measures == "angle")


def weight_factor(unit: Unit | None, column: str) -> Decimal | None:
    """Return the number that makes our column of a weight, such as gram-force; else None."""
    if unit is None or unit.times == 1:
        return None
    return unit.times.scaleb(shift(unit, column))


def angle_factor(unit: Unit | None, column: str, radius_m: float | None) -> Decimal | None:
    """Return the number that makes our column of an angle; None where it is none, or ours."""
    own = own_unit(column)
    if unit is None or own is None or unit.measures != "angle":
        return None
    if own.measures == "angle":
        return unit.in_rad / own.in_rad if unit.in_rad != own.in_rad else None
    return None if radius_m is None else unit.in_rad * Decimal(repr(radius_m)).scaleb(3)


def split_name(name: str) -> SplitName:
    """Return a name and its unit: force [N], F/mN, x in mm, position_mm."""
    bracketed = _BRACKETS.fullmatch(name)
    if bracketed:
        unit = unit_of(bracketed["unit"])
        return SplitName(bracketed["name"], unit, "" if unit else bracketed["unit"])
    for pattern in (_SLASH, _WORD):
        found = pattern.fullmatch(name)
        unit = unit_of(found["unit"]) if found else None
        if found and unit is not None:
            return SplitName(found["name"], unit)
    if name.lower().endswith("_per_m"):
        return SplitName(name[:-6], Unit("per_m", "curvature", 0))
    return SplitName(name, None)


def own_unit(column: str) -> Unit | None:
    """Return the unit of one of our columns."""
    return split_name(column).unit


def is_meant(name: SplitName, column: str) -> bool:
    """Whether a name is that of our column, written otherwise: Force [N] for force_mN."""
    own = split_name(column)
    if name.word != own.word or name.unknown:
        return False
    if own.unit is None:
        return name.unit is None
    return name.unit is not None and fits(name.unit, column)


def may_mean(name: SplitName, column: str) -> bool:
    """Whether a name is one that others give to our column, and its unit fits."""
    if name.unknown or (name.unit and not fits(name.unit, column)):
        return False
    return name.word in words_for(column)


def words_for(column: str) -> tuple[str, ...]:
    """Return the names that our column has here and with others, without their units."""
    return (split_name(column).word, *_OTHERS.get(column, "").split())


def shift(unit: Unit | None, column: str) -> int:
    """Return the power of ten from a unit to that of our column; None is the same unit."""
    own = own_unit(column)
    return 0 if unit is None or own is None else unit.exponent - own.exponent


KNOWN: Final = tuple(
    dict.fromkeys(
        (*columns.FORCES, *columns.FORCES_OPTIONAL, *columns.CURVES, *columns.CURVES_OPTIONAL,
         *columns.SIGNALS, *columns.SIGNALS_OPTIONAL)
    )
)  # fmt: skip
