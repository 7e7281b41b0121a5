"""Write the measurement that separates two effects as a protocol.toml.

It is a session of its own, linked to the one before by its identifier: the analysis takes both
together, and each session is a mounting of its own.
"""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import tomlkit

from labrig.config import parse_protocol
from labrig.config.base import parse_toml
from labrig.config.templates import template_text
from labrig.errors import BadInputError
from model.discrepancy import Diagnosis, Next
from model.discrepancy.next_measurement.added_conditions import LONGER
from model.measurements import Measurements
from protocols import ProtocolKind, ScheduleError
from protocols.planning.schedule import SETTLED_S

Tables = dict[str, Any]
Places = dict[str, list[float]]

_KEPT = ("moisten", "camera", "rules")  # keys of the session's own protocol.toml

_NO_EXTRAS = {
    "random_order": False, "no_touch_zero": False, "free_shapes": False, "reversed_approach": False,
}  # fmt: skip


def with_protocol(
    found: Diagnosis, measurements: Measurements, session: Path | None = None
) -> Diagnosis:
    """Return the diagnosis with the whole protocol.toml of its next measurement, as tables."""
    if found.next_measurement is None:
        return found
    text = protocol_text(found.next_measurement, measurements, session)
    tables = parse_toml(text, "protocol.toml")
    return replace(found, next_measurement=replace(found.next_measurement, protocol=tables))


def protocol_text(found: Next, measurements: Measurements, session: Path | None = None) -> str:
    """Return the text of protocol.toml; it has passed the loader's own checks.

    Of tables whose voltages no rig of labrig applies it is a comment that says so.

    It is the protocol stored with the proposal. Where none is, it is a variation of the one of
    `session`, where one is given and holds its protocol.
    """
    document = tomlkit.document()
    for line in textwrap.wrap(f"To tell effects apart: {found.why}", 96):
        document.add(tomlkit.comment(line))
    stored = found.protocol if "places" in found.protocol else None
    try:
        tables = stored or _tables(found, measurements, session)
    except ScheduleError as error:  # another laboratory's voltages
        document.add(tomlkit.comment(f"labrig cannot run it: {error}."))
        return tomlkit.dumps(document)
    for key, value in tables.items():
        document.add(key, tomlkit.item(value))
    text = tomlkit.dumps(document)
    parse_protocol(text, "protocol.toml").schedule("protocol.toml")
    return text


def _tables(found: Next, measurements: Measurements, session: Path | None) -> Tables:
    """Return the tables of protocol.toml for an entry of the menu."""
    base, places = _base(session, measurements), _places(measurements)
    extras: Tables = {"mode": "default", **_NO_EXTRAS}
    tables = _MAKERS.get(found.extra, _same)(base, places, extras).as_tables()
    positions = [{"configuration": name, "positions_mm": mm} for name, mm in places.items()]
    return {**tables, "places": positions, "extras": extras}


@dataclass(frozen=True)
class _Base:
    """What the next measurement is a variation of."""

    protocol: ProtocolKind
    tables: Tables  # moisten, camera, rules

    def as_tables(self) -> Tables:
        """Return the tables of protocol.toml, the protocol's own among them."""
        values = dataclasses.asdict(self.protocol)
        plain = {key: list(v) if isinstance(v, tuple) else v for key, v in values.items()}
        return {**self.tables, self.protocol.name: plain}


def _base(session: Path | None, measurements: Measurements) -> _Base:
    """Return the protocol that was run, or the standard one at the voltages measured."""
    if session is not None:
        from labrig.session import open_session

        with open_session(session) as opened:
            text = opened.texts.get("protocol.toml")
        if text is not None:
            known = parse_protocol(text, f"{session}: protocol.toml")
            plain = known.model_dump(mode="json")
            return _Base(known.protocol(), {key: plain[key] for key in _KEPT})
    driven = sorted({c.voltage_V for c in measurements.conditions} - {0.0}, reverse=True)
    if not driven:
        raise BadInputError(
            "nothing was measured under voltage, so there is nothing to start from."
        )
    return _Base(_standard_protocol(driven), {"moisten": True})


def _standard_protocol(voltages_V: Sequence[float]) -> ProtocolKind:
    """Return the protocol that `labrig init` writes, at other voltages."""
    standard = parse_protocol(template_text("protocol.toml"), "protocol.toml").protocol()
    return standard.at_voltages(tuple(voltages_V))


def _places(measurements: Measurements) -> dict[str, list[float]]:
    """Return the positions measured, in mm, by configuration."""
    result: dict[str, list[float]] = {}
    for condition in measurements.conditions:
        own = result.setdefault(condition.configuration, [])
        if condition.position_m is not None:
            own.append(round(1e3 * condition.position_m, 6))
    return {name: sorted(set(own)) for name, own in result.items()}


# -- candidate measurements: each changes the base, the places and the extras


def _same(base: _Base, _places: Places, _extras: Tables) -> _Base:
    """Return the base unchanged: the same measurement again."""
    return base


def _free_shapes(base: _Base, places: Places, extras: Tables) -> _Base:
    # also under voltage, as the candidate was weighed; the model that weighed it is static
    extras["free_shapes"] = {"settled_s": SETTLED_S}
    for name in places:
        places[name] = []
    return base


def _remount(base: _Base, places: Places, _extras: Tables) -> _Base:
    for name, own in places.items():
        places[name] = [own[i] for i in sorted({0, len(own) // 2, len(own) - 1})] if own else own
    return base


def _long_runs(base: _Base, places: Places, extras: Tables) -> _Base:
    _remount(base, places, extras)
    try:
        longer = base.protocol.longer(LONGER)
    except ScheduleError:  # a kind that reads each voltage once
        longer = _standard_protocol(base.protocol.driven_V).longer(LONGER)
    return replace(base, protocol=longer)


def _reversed(base: _Base, places: Places, extras: Tables) -> _Base:
    extras["approach"] = "down"
    for own in places.values():
        own.reverse()  # on the way down, as it is approached
    return base


def _between(base: _Base, places: Places, _extras: Tables) -> _Base:
    for name, own in places.items():
        places[name] = [round(0.5 * (a + b), 6) for a, b in pairwise(own)] or own
    return base


def _half_voltage(base: _Base, _places: Places, _extras: Tables) -> _Base:
    return replace(base, protocol=base.protocol.scaled(0.5))


def _random_order(base: _Base, _places: Places, extras: Tables) -> _Base:
    extras["random_order"] = True
    return base


def _no_touch_zero(base: _Base, _places: Places, extras: Tables) -> _Base:
    extras["no_touch_zero"] = True
    return base


def _turned_over(base: _Base, _places: Places, extras: Tables) -> _Base:
    extras["tilt_deg"] = 180.0
    return base


_MAKERS = {
    "free_shapes": _free_shapes, "remount": _remount, "reversed_approach": _reversed,
    "between": _between, "half_voltage": _half_voltage, "random_order": _random_order,
    "long_runs": _long_runs, "turned_over": _turned_over, "no_touch_zero": _no_touch_zero,
    "more_repeats": _same,
}  # fmt: skip
