"""Recorded sessions with a known truth, for the analysis."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from labrig.config import parse_load_cell
from labrig.session import SessionWriter
from protocols import Schedule
from protocols.execution import events as ev
from sim_hardware.optics import OpticsSettings, Renderer
from tests.labrig.session.session_recording import (
    OFFSET_V,
    SENSITIVITY_V_PER_N,
    TEXTS,
    session_events,
    settings,
)

LOAD_CELL = f"""
date = 2026-11-01
capacity_mN = 98.07
sensitivity_V_per_N = {SENSITIVITY_V_PER_N}
sensitivity_sigma_V_per_N = 0.0003
offset_V = {OFFSET_V}
"""
CALIBRATION = parse_load_cell(LOAD_CELL, "load_cell.toml")
PX_PER_MM = 6.0
OPTICS = '{"px_per_mm": 6.0, "clamp_px": [40.0, 180.0], "image_size": [360, 260], "bits": 8}'
EDGE = 201.4  # sample index of an edge planned at the run's time 0


def change(kind: type, how: Callable[[ev.Event], ev.Event]) -> Callable[[ev.Event], ev.Event]:
    """Apply `how` to events of one kind."""
    return lambda event: how(event) if isinstance(event, kind) else event


def record_with(
    path: Path,
    schedule: Schedule,
    *changes: Callable[[ev.Event], ev.Event],
    more: Callable[[ev.Event], Iterator[ev.Event]] = lambda _event: iter(()),
    **settings_: object,
) -> Path:
    """Record a made-up session whose events went through some changes, and `more` after each."""
    texts = TEXTS | {"load_cell.toml": LOAD_CELL, "optics.json": OPTICS}
    resolved = {"rig": {"current_sense": {"shunt_ohm": 2.0}}}
    wanted = settings(schedule) | {"texts": texts, "resolved": resolved} | settings_
    with SessionWriter(path, **wanted) as writer:
        for event in session_events(schedule):
            for each in changes:
                event = each(event)
            writer.handle(event)
            for extra in more(event):
                writer.handle(extra)
    return path


def bent(curvature_per_m: float, points: int = 8001, length_m: float = 0.05) -> np.ndarray:
    """A sheet of constant curvature, points (n, 2)."""
    s = np.linspace(0, length_m, points)
    angle = curvature_per_m * s
    if abs(curvature_per_m) < 1e-9:
        return np.stack([s, 0 * s], axis=1)
    return np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1) / curvature_per_m


def with_pictures(curvature: Callable[[float, int], float]) -> Callable[[ev.Event], ev.Event]:
    """Frames that show a sheet of curvature(voltage, reading)."""
    look = OpticsSettings(image_size=(360, 260), px_per_mm=PX_PER_MM, origin_px=(40.0, 180.0))
    renderer = Renderer(look, seed=4)

    def draw(event: ev.ReadingTaken) -> ev.ReadingTaken:
        planned = event.planned
        shape = bent(curvature(planned.voltage_V, planned.index), points=401)
        image = renderer.render([shape], None, event.frame.number)
        return replace(event, frame=replace(event.frame, image=image))

    return change(ev.ReadingTaken, draw)
