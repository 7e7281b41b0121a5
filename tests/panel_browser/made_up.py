"""A made-up session in the panel's messages: for what the page must show and no rig would do."""

from __future__ import annotations

import json
import math
import struct
from typing import Any

import cv2
import numpy as np

Message = dict[str, Any]
POSITIONS_MM = (0, 5, 10, 15, 20, 25, 30)
PULSE_S = 0.6
CHANNELS = [
    {
        "key": key,
        "name": name,
        "quantity": quantity,
        "unit": unit,
        "column": column,
        "factor": factor,
    }
    for key, name, quantity, unit, column, factor in (
        ("drive_V", "drive", "voltage", "V", "drive_V", 1.0),
        ("force_mN", "force", "force", "mN", "force_N", 1e3),
        ("current_mA", "current", "electric current", "mA", "current_A", 1e3),
    )
]
ROWS = ["run_s"] + [
    f"{name}_{end}" for name in ("drive_V", "force_mN", "current_mA") for end in ("least", "most")
]


def binary(header: Message, payload: bytes) -> bytes:
    """A binary frame as docs/reference/panel_messages.md lays it out."""
    text = json.dumps(header).encode()
    text += b" " * (-(4 + len(text)) % 8)
    return struct.pack("<I", len(text)) + text + payload


def steps() -> list[list[float]]:
    """10 readings at 0 V, then alternating pulses, as in the paper."""
    pulses = [[6.0 + PULSE_S * i, 2.0 if i % 2 == 0 else -2.0] for i in range(22)]
    return [[0.0, 0.0], *pulses, [6.0 + PULSE_S * 22, 0.0]]


def readings() -> list[list[Any]]:
    """Of one run: [index, run_s, V, kind]."""
    found: list[list[Any]] = [[i, 0.5 + 0.6 * i, 0.0, "zero"] for i in range(10)]
    for i in range(22):
        kind = "discarded" if i < 2 else "kept"
        found.append([10 + i, 6.5 + PULSE_S * i, 2.0 if i % 2 == 0 else -2.0, kind])
    return found


def plan() -> Message:
    """14 runs of 19.2 s with a minute of handling before each."""
    runs = []
    for configuration in ("long", "short"):
        for position in POSITIONS_MM:
            index = len(runs)
            runs.append({
                "run": index, "purpose": "measurement", "configuration": configuration,
                "position_mm": position, "mounting": 0, "approach": "up", "moisten": True,
                "load_mN": None, "starts_s": 45.0 + 64.2 * index, "duration_s": 19.2,
                "under_voltage_s": 13.2, "steps": steps(), "readings": readings(),
                "prompts": [f"move the load cell to {position} mm", "moisten the sheet"],
            })  # fmt: skip
    return {
        "type": "plan", "protocol": "pulse_train", "clock": "real", "session": "made-up.h5",
        "simulated": True, "estimate_s": 64.2 * 14, "running_s": 19.2 * 14, "frame_rate_hz": 25.0,
        "limits": {"sheet_voltage_V": 2.5, "time_under_voltage_s": 30.0, "capacity_mN": 98.1},
        "channels": CHANNELS,
        "picture": {"width": 640, "height": 480, "clamp_px": [60, 400], "px_per_mm": 9.0},
        "done": [], "runs": runs,
    }  # fmt: skip


def voltage_at(run_s: float) -> float:
    """Of the plan."""
    found = 0.0
    for when, volts in steps():
        if when <= run_s:
            found = volts
    return found


def force_at(run: int, volts: float, noise: float = 0.0) -> float:
    """Something that looks like a force, in mN."""
    return 0.9 * volts * math.exp(-run / 9) - 0.15 * run % 1.1 + noise


def curve_px(volts: float, points: int = 60) -> list[list[float]]:
    """A bent line from the clamp."""
    s = np.linspace(0, 450, points)
    angle = -0.35 - (0.0021 + 0.0006 * volts) * s
    step = s[1] - s[0]
    u, v = 60 + np.cumsum(np.cos(angle)) * step, 400 + np.cumsum(np.sin(angle)) * step
    return [[round(float(a), 2), round(float(b), 2)] for a, b in zip(u, v, strict=True)]


def picture(volts: float, number: int) -> bytes:
    """A grey JPEG of it."""
    image = np.full((480, 640), 38, np.uint8)
    line = np.round(np.array(curve_px(volts))).astype(np.int32)
    cv2.polylines(image, [line], False, 205, 7, cv2.LINE_AA)
    cv2.rectangle(image, (18, 380), (62, 430), 90, -1)
    cv2.putText(image, str(number), (10, 20), cv2.FONT_HERSHEY_PLAIN, 1, 120)
    return bytes(cv2.imencode(".jpg", image)[1])


def reading(run: int, planned: list[Any], noise: float, valid: bool = True) -> Message:
    """One that was taken."""
    index, run_s, volts, kind = planned
    force_mN, current_mA = force_at(run, volts, noise), 8 * volts
    values = {"drive_V": volts, "force_N": 1e-3 * force_mN, "current_A": 1e-3 * current_mA}
    return {
        "type": "reading", "time_s": plan()["runs"][run]["starts_s"] + run_s, "run": run,
        "run_s": run_s, "index": index, "step": max(0, index - 9), "kind": kind, "voltage_V": volts,
        "force_mN": force_mN, "drive_V": volts, "current_mA": current_mA, "values": values,
        "frame": index, "frame_offset_ms": 3.0, "valid": valid,
        "why": "" if valid else "the edge came 7 ms late",
    }  # fmt: skip


def signals(run: int, from_s: float, to_s: float, fresh: bool) -> bytes:
    """A binary frame of least and most."""
    run_s = np.arange(round(from_s * 100), round(to_s * 100)) / 100 + 0.005
    rng = np.random.default_rng(abs(int(from_s * 100)) + run)
    volts = np.array([voltage_at(t) for t in run_s])
    force = np.array([force_at(run, v) for v in volts]) + 0.01 * rng.standard_normal(run_s.size)
    rows = [run_s, volts - 0.01, volts + 0.01, force - 0.02, force + 0.02, 8 * volts - 0.3]
    rows.append(8 * volts + 0.3)
    header = {"type": "signals", "run": run, "rows": ROWS, "count": run_s.size, "fresh": fresh}
    return binary(header, np.asarray(rows, dtype="<f4").tobytes())


def predicted(run: int, from_s: float, to_s: float, fresh: bool) -> bytes:
    """A binary frame of what a model that is a little weak predicts of the force."""
    run_s = np.arange(round(from_s * 100), round(to_s * 100)) / 100 + 0.005
    force = np.array([0.85 * force_at(run, voltage_at(t)) for t in run_s])
    rows = ["run_s", "force_mN_least", "force_mN_most"]
    header = {"type": "predicted", "run": run, "rows": rows, "count": run_s.size, "fresh": fresh}
    return binary(header, np.asarray([run_s, force, force], dtype="<f4").tobytes())


def motion(frame: int, volts: float) -> Message:
    """The dynamic model beside the run, at a frame."""
    shape = {"frame": frame, "points_px": curve_px(volts * 0.85), "distance_mm": 0.2871}
    return {
        "type": "motion", "state": "following", "why": "", "run": 4, "run_s": 12.9, "over_s": 10.0,
        "force_rms_mN": 0.0853, "force_mean_mN": -0.0122, "noise_mN": 0.0431,
        "shape_rms_mm": 0.3021, "shape": shape,
    }  # fmt: skip


def estimates() -> Message:
    """Its slow parameters: a sheet that stiffens while it dries."""
    rows = [
        [60.0 * k, "long", 1.0 + 0.03 * k, 0.3 if k == 0 else 0.012, 1.0 - 0.005 * k, 0.006]
        for k in range(6)
    ]
    columns = ["time_s", "configuration", "B", "B_sigma", "moment", "moment_sigma"]
    values = {"long": {"B_Nm2": 1.27e-6, "moment_per_volt_Nm": 38.1e-6}}
    return {"type": "estimates", "model": values, "columns": columns, "rows": rows}


def story(until_run: int = 4) -> list[Message]:
    """A session that is in the middle of a run, a prompt standing or not being another matter."""
    rng = np.random.default_rng(1)
    wall = "2026-11-21T12:00:00Z"
    found: list[Message] = [
        {"type": "job", "id": "j1", "kind": "run", "state": "going", "by": "Ann", "wall": wall,
         "session": "made-up.h5", "code": None, "text": ""},
        plan(),
        {"type": "preflight", "ok": True, "checks": checks()},
        {"type": "started", "wall": wall, "time_s": 0.0, "log": "the session begins"},
        {"type": "output", "time_s": 0.1, "state": "safe", "why": "+10 mV read back",
         "log": "output SAFE: +10 mV read back"},
    ]  # fmt: skip
    for run in range(until_run + 1):
        found += _run(run, rng, whole=run < until_run)
    found.append({
        "type": "output", "time_s": 330.0, "state": "energised", "why": "pulse of +2 V",
        "log": "output ENERGISED: pulse of +2 V",
    })  # fmt: skip
    return found


def _run(run: int, rng: np.random.Generator, whole: bool) -> list[Message]:
    start = plan()["runs"][run]["starts_s"]
    found: list[Message] = [
        {"type": "prompt", "time_s": start - 20, "prompt": run, "kind": "move",
         "configuration": "long",
         "text": f"Move the load cell to {POSITIONS_MM[run]} mm and moisten the sheet.",
         "position_mm": POSITIONS_MM[run], "load_mN": None, "log": "move the load cell"},
        {"type": "answered", "time_s": start - 1, "prompt": run, "done": True,
         "log": "answered: done"},
        {"type": "run_started", "time_s": start, "run": run, "stage_position_mm": None,
         "since_wetting_s": 18.0, "log": f"run {run + 1} begins: long, {POSITIONS_MM[run]} mm"},
        {"type": "state", "state": "running", "run": run},
    ]  # fmt: skip
    taken = readings() if whole else readings()[:21]
    found += [reading(run, one, 0.012 * rng.standard_normal(), one[0] != 15) for one in taken]
    if whole:
        found.append({
            "type": "run_stopped", "time_s": start + 19.2, "run": run, "completed": True,
            "lost_samples": 0, "frames_grabbed": 480, "frames_dropped": 0,
            "log": f"run {run + 1} is complete",
        })  # fmt: skip
    return found


def checks() -> list[Message]:
    """A preflight's."""
    rows = [
        ("drive board", "PCI6703 is a PCI-6703", "PCI6703 with ao0", True, None),
        ("output at 0 V", "+10.0 mV read back", "within 50 mV of 0 V", True, None),
        ("load cell quiet", "0.017 mN from one 50 ms to the next", "below 1 mN", True, None),
        ("camera calibration", "190 days old", "at most 180 days", True, "calibrate it soon"),
    ]
    return [
        {"name": name, "found": found, "wanted": wanted, "ok": ok, "warning": warning}
        for name, found, wanted, ok, warning in rows
    ]
