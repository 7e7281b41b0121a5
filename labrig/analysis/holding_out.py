"""`--hold-out position=25` and the like: which positions are left out of a fit."""

from __future__ import annotations

from collections.abc import Sequence

from labrig.errors import BadArgumentError
from model.measurements import Measurements, is_at

_EXAMPLE = "position=25 or configuration=long,position=25"


def held_out(texts: Sequence[str], measurements: Measurements) -> tuple[tuple[str, float], ...]:
    """Return pairs of configuration (empty: all) and position in m, each of which was measured."""
    return tuple(_checked(text, *_parsed(text), measurements) for text in texts)


def _parsed(text: str) -> tuple[str, float]:
    given: dict[str, str] = {}
    for part in text.split(","):
        key, equals, value = (p.strip() for p in part.partition("="))
        if not equals or key not in ("configuration", "position") or key in given:
            raise _wrong(text, f"write {_EXAMPLE}.")
        given[key] = value
    try:
        return given.get("configuration", ""), float(given["position"]) / 1000
    except (KeyError, ValueError):
        raise _wrong(text, f"a position in mm is needed, as in {_EXAMPLE}.") from None


def _checked(
    text: str, configuration: str, position_m: float, measurements: Measurements
) -> tuple[str, float]:
    known = sorted({c.configuration for c in measurements.conditions})
    if configuration and configuration not in known:
        raise _wrong(
            text,
            f"there is no configuration {configuration!r} in the data, which have"
            f" {', '.join(known)}.",
        )
    if not any(is_at(c, configuration, position_m) for c in measurements.conditions):
        places = {
            c.position_m
            for c in measurements.conditions
            if c.position_m is not None and configuration in ("", c.configuration)
        }
        have = ", ".join(f"{1e3 * place:g}" for place in sorted(places)) or "none"
        raise _wrong(
            text,
            f"nothing was measured at {1e3 * position_m:g} mm; measured were {have} mm.",
        )
    return configuration, position_m


def _wrong(text: str, why: str) -> BadArgumentError:
    return BadArgumentError(f"hold_out {text!r}: {why}", "hold_out")
