"""A measurement that would tell two effects apart, as a protocol.toml ready to run.

It is a session of its own, linked to the one before by its identifier: the analysis takes both
together, and each session is a mounting of its own.
"""

from __future__ import annotations

import textwrap
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import tomlkit

from labrig.config import parse_protocol
from labrig.config.base import parse_toml
from labrig.errors import BadInputError
from model.discrepancy import Diagnosis, Next
from model.discrepancy.next_measurement.candidate_measurements import LONGER
from model.measurements import Measurements
from protocols import PulseTrain

_NO_EXTRAS = {
    "random_order": False, "no_touch_zero": False, "free_shapes": False, "reversed_approach": False,
}  # fmt: skip


def with_protocol(
    found: Diagnosis, measurements: Measurements, session: Path | None = None
) -> Diagnosis:
    """The same diagnosis, its next measurement with the whole protocol.toml as tables."""
    if found.next_measurement is None:
        return found
    text = protocol_text(found.next_measurement, measurements, session)
    tables = parse_toml(text, "protocol.toml")
    return replace(found, next_measurement=replace(found.next_measurement, protocol=tables))


def protocol_text(found: Next, measurements: Measurements, session: Path | None = None) -> str:
    """The text of protocol.toml; it has passed the loader's own checks.

    Pulses are those of `session`, where one is given and holds its protocol.
    """
    tables = _pulses(session, measurements)
    places = _places(measurements)
    extras: dict[str, Any] = {"mode": "default", **_NO_EXTRAS}
    _MAKERS.get(found.extra, _everything)(tables, places, extras)
    document = tomlkit.document()
    for line in textwrap.wrap(f"To tell effects apart: {found.why}", 96):
        document.add(tomlkit.comment(line))
    for key, value in tables.items():
        document.add(key, value)
    array = tomlkit.aot()
    for name, positions_mm in places.items():
        array.append(tomlkit.item({"configuration": name, "positions_mm": positions_mm}))
    document.add("places", array)
    document.add("extras", extras)
    text = tomlkit.dumps(document)
    parse_protocol(text, "protocol.toml").schedule("protocol.toml")
    return text


def _pulses(session: Path | None, measurements: Measurements) -> dict[str, Any]:
    """The tables of the pulse train that was run, or of the paper's at the voltages measured."""
    if session is not None:
        from labrig.session import open_session

        with open_session(session) as opened:
            text = opened.texts.get("protocol.toml")
        if text is not None:
            known = parse_protocol(text, f"{session}: protocol.toml")
            if known.pulse_train is not None:
                plain = known.model_dump(mode="json")
                return {key: plain[key] for key in ("moisten", "pulse_train", "camera", "rules")}
    driven = sorted({c.voltage_V for c in measurements.conditions} - {0.0}, reverse=True)
    if not driven:
        raise BadInputError(
            "nothing was measured under voltage, so there is nothing to go on from."
        )
    return {"moisten": True, "pulse_train": {"voltages_V": driven}}


def _places(measurements: Measurements) -> dict[str, list[float]]:
    """The positions measured, in mm, by configuration."""
    result: dict[str, list[float]] = {}
    for condition in measurements.conditions:
        own = result.setdefault(condition.configuration, [])
        if condition.position_m is not None:
            own.append(round(1e3 * condition.position_m, 6))
    return {name: sorted(set(own)) for name, own in result.items()}


# -- entries of the menu: each changes tables, places and extras

Tables = dict[str, Any]
Places = dict[str, list[float]]


def _everything(_tables: Tables, _places: Places, _extras: Tables) -> None:
    """The same once more."""


def _free_shapes(_tables: Tables, places: Places, extras: Tables) -> None:
    extras["free_shapes"] = True
    for name in places:
        places[name] = []


def _remount(_tables: Tables, places: Places, _extras: Tables) -> None:
    for name, own in places.items():
        places[name] = [own[i] for i in sorted({0, len(own) // 2, len(own) - 1})] if own else own


def _long_runs(tables: Tables, places: Places, extras: Tables) -> None:
    _remount(tables, places, extras)
    train = tables["pulse_train"]
    usual = train.get("readings_per_voltage", PulseTrain.readings_per_voltage)
    train["readings_per_voltage"] = LONGER * usual


def _reversed(_tables: Tables, places: Places, extras: Tables) -> None:
    extras["approach"] = "down"
    for own in places.values():
        own.reverse()  # on the way down, as it is approached


def _between(_tables: Tables, places: Places, _extras: Tables) -> None:
    for name, own in places.items():
        places[name] = [round(0.5 * (a + b), 6) for a, b in pairwise(own)] or own


def _half_voltage(tables: Tables, _places: Places, _extras: Tables) -> None:
    train = tables["pulse_train"]
    train["voltages_V"] = [0.5 * v for v in train["voltages_V"]]


def _random_order(_tables: Tables, _places: Places, extras: Tables) -> None:
    extras["random_order"] = True


def _no_touch_zero(_tables: Tables, _places: Places, extras: Tables) -> None:
    extras["no_touch_zero"] = True


def _turned_over(_tables: Tables, _places: Places, extras: Tables) -> None:
    extras["tilt_deg"] = 180.0


_MAKERS = {
    "free_shapes": _free_shapes, "remount": _remount, "reversed_approach": _reversed,
    "between": _between, "half_voltage": _half_voltage, "random_order": _random_order,
    "long_runs": _long_runs, "turned_over": _turned_over, "no_touch_zero": _no_touch_zero,
    "more_repeats": _everything,
}  # fmt: skip
