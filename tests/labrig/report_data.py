"""Measurements and sessions with known sheets in them, made without a camera in a moment."""

from __future__ import annotations

import io
import re
import tempfile
import uuid
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import h5py
import numpy as np

from labrig.config import parse_sheet
from labrig.config.templates import template_text
from labrig.session import SessionWriter, store_measurements
from labrig.session.format.checksums import digest, version_of
from model import (
    Along,
    Condition,
    ConfiguredSheet,
    Curve,
    Measurements,
    Parameter,
    Reading,
    SheetModel,
    TimeSeries,
    predict,
)
from protocols import Place, Schedule, make_schedule
from protocols.execution import events as ev
from protocols.kinds.pulse_train import PulseTrain
from tests.labrig.session.session_recording import record, session_events, settings

POSITIONS_M = (0.0, 0.01, 0.02, 0.03)
VOLTAGES = (0.0, 2.0, -2.0)
STIFFNESS = {"long": 1.27e-6, "short": 0.85e-6}
ROOT_EIBM = {2.0: 100.0, -2.0: -80.0}  # Me/B at the clamp, 1/m
DECAY_M = 0.012
NOISE_N = 2e-5
TEXTS = {name: template_text(name) for name in ("sheet.toml", "load_cell.toml", "protocol.toml")}


def truth(*names: str) -> SheetModel:
    """Sheets whose EIBM falls along them."""
    geometry = parse_sheet(TEXTS["sheet.toml"], "sheet.toml")
    sheets = {}
    for name in names or ("long", "short"):
        sheet = geometry[name]
        s_m = np.linspace(0.0, sheet.free_length_m, 41)
        B, zero = STIFFNESS[name], np.zeros(41)
        eibm = {
            v: Along(s_m, B * root * np.exp(-s_m / DECAY_M), zero, "N m")
            for v, root in ROOT_EIBM.items()
        }
        nodes, k0 = sheet.initial_curvature
        rest = Along(nodes, k0, np.zeros(len(nodes)), "1/m")
        sheets[name] = ConfiguredSheet(
            sheet, Parameter(value=B, sigma=0.0, unit="N m^2"), rest, eibm
        )
    return SheetModel(sheets=sheets)


@lru_cache(maxsize=16)
def measure(
    *names: str,
    curves: bool = True,
    seed: int = 1,
    positions_m: tuple[float, ...] = POSITIONS_M,
) -> Measurements:
    """What a quiet rig would measure of them; to be left as it is, as it is made once."""
    rng = np.random.default_rng(seed)
    model = truth(*names)
    conditions = tuple(
        _condition(model, name, position, volts, rng, curves)
        for name in model.sheets
        for position in positions_m
        for volts in VOLTAGES
    )
    sheets = {name: one.sheet for name, one in model.sheets.items()}
    series = tuple(_series(name) for name in sheets)
    return Measurements(
        sheets=sheets, conditions=conditions, series=series, source="made.h5", checksum="ab" * 32
    )


def _condition(model, name, position_m, volts, rng, curves) -> Condition:
    found = predict(model, name, position_m, volts)
    force = found.F_N + rng.normal(0.0, NOISE_N, 10)
    kind = "zero" if volts == 0 else "kept"
    first, step = {0.0: (0, 1), 2.0: (12, 2), -2.0: (13, 2)}[volts]
    readings = tuple(
        Reading(
            index=first + step * i,
            kind=kind,
            force_N=float(F),
            time_s=0.6 * (first + step * i) + 0.5,
        )
        for i, F in enumerate(force)
    )
    curve = None
    if curves:
        away = rng.normal(0.0, 1e-6, len(found.s_m))
        sigma = np.full(len(found.s_m), 2e-6)
        curve = Curve(
            s_m=found.s_m,
            x_m=found.x_m,
            y_m=found.y_m + away,
            curvature_per_m=found.curvature_per_m,
            sigma_m=sigma,
        )
    return Condition(
        configuration=name, position_m=position_m, voltage_V=volts, readings=readings, curve=curve
    )


def _series(name: str) -> TimeSeries:
    time = np.arange(0, 19.2, 0.005)
    pulse = np.floor(time / 0.6).astype(int)
    drive = np.where(pulse < 10, 0.0, np.where(pulse % 2 == 0, 2.0, -2.0))
    return TimeSeries(
        configuration=name,
        position_m=POSITIONS_M[0],
        time_s=time,
        drive_V=drive,
        force_N=None,
        current_A=0.005 * drive,
    )


def invalid(measurements: Measurements, name: str, why: str) -> Measurements:
    """The same, with no valid reading left of one configuration."""
    conditions = tuple(
        replace(c, readings=tuple(replace(r, valid=False, why=why) for r in c.readings))
        if c.configuration == name
        else c
        for c in measurements.conditions
    )
    return replace(measurements, conditions=conditions)


def schedule(*names: str) -> Schedule:
    """Two short runs of each configuration."""
    train = PulseTrain(zero_readings=2, readings_per_voltage=2)
    return make_schedule(train, [Place(name, POSITIONS_M[:2]) for name in names or ("long",)])


@lru_cache(maxsize=8)
def recorded(names: tuple[str, ...]) -> bytes:
    """The file of a session, recorded once for all that are copies of it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made.h5"
        record(path, schedule(*names), texts=TEXTS)
        return path.read_bytes()


def recorded_anew(names: tuple[str, ...]) -> bytes:
    """The same as another recording: with an identifier of its own, and that one's checksum."""
    old = recorded(names)
    (identifier,) = set(re.findall(rb"[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}", old))
    new = old.replace(identifier, str(uuid.uuid4()).encode())
    return new.replace(_sum_of_identifier(old), _sum_of_identifier(new))


def _sum_of_identifier(data: bytes) -> bytes:
    with h5py.File(io.BytesIO(data)) as file:
        return digest(file["session/identifier"], version_of(file)).encode()


def session(path: Path, measurements: Measurements | None, **changes: object) -> Path:
    """A recorded session that holds `measurements`."""
    names = tuple(measurements.sheets) if measurements else ("long",)
    if changes:
        record(path, schedule(*names), **({"texts": TEXTS} | changes))
    else:
        with path.open("wb") as file:  # tests may let `Path.write_bytes` fail
            file.write(recorded_anew(names))
    if measurements is not None:
        store_measurements(path, measurements)
    return path


def stopped_session(path: Path, after_runs: int) -> Path:
    """A session that was stopped by its operator after so many runs."""
    plan = schedule("long", "short")
    with SessionWriter(path, **(settings(plan) | {"texts": TEXTS})) as writer:
        done = 0
        for event in session_events(plan):
            if done == after_runs and isinstance(event, ev.OperatorAsked):
                break
            writer.handle(event)
            done += isinstance(event, ev.RunStopped)
        last = ev.SessionStopped(
            event.time_s,
            outcome=ev.Outcome.ABORTED,
            reason="stopped by Ctrl-C",
            output=ev.OutputState.SAFE,
            wall="2026",
        )
        writer.handle(last)
    return path
