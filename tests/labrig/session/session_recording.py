"""A small made-up session as a stream of events, and a program that records one (to be killed)."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from drivers.interfaces import Frame, Prompt, SampleClock, SignalBlock, VoltageWrite
from labrig.session import SessionWriter
from labrig.session.format.channels import as_recorded
from labrig.session.format.setup import SessionSetup
from protocols import Place, Schedule, make_schedule
from protocols.execution import events as ev
from protocols.execution.channels import current_channel, drive_channel, force_channel
from protocols.kinds.pulse_train import PulseTrain

CHANNELS = (
    force_channel(range_V=0.05, conversion=lambda volts: (volts - OFFSET_V) / SENSITIVITY_V_PER_N),
    current_channel(range_V=0.5, shunt_ohm=2.0),
    drive_channel(range_V=5.0),
)
NAMES = tuple(channel.name for channel in CHANNELS)
RATE_HZ = 1000.0
FRAME_SHAPE = (24, 32)
SENSITIVITY_V_PER_N = 0.15
OFFSET_V = 1e-4
LATE_S = 1.4e-3  # every edge, between two samples

SHEET = """\
[long]
free_length_mm = 50.0
width_mm = 11.0
thickness_mm = 0.21
[short]
free_length_mm = 4.5
width_mm = 11.0
thickness_mm = 0.21
elongation_mm = 40.0
initial_curvature_per_m = 28.0
"""
TEXTS = {"sheet.toml": SHEET, "protocol.toml": "# Übung\nname = 'pulses'\n", "rig.toml": ""}


def small_schedule(readings: int = 2, positions_m: tuple[float, ...] = (0.0, 0.005)) -> Schedule:
    train = PulseTrain(zero_readings=2, readings_per_voltage=readings)
    return make_schedule(train, [Place("long", positions_m), Place("short", positions_m[:1])])


def settings(schedule: Schedule) -> dict[str, object]:
    return {
        "schedule": schedule,
        "texts": TEXTS,
        "resolved": {"current_sense": {"shunt_ohm": 2.0}},
        "channels": CHANNELS,
        "rate_hz": RATE_HZ,
        "frame_shape": FRAME_SHAPE,
        "simulated": True,
    }


def setup_of(plan: dict[str, object]) -> SessionSetup:
    """What a writer with these settings creates its file from."""
    rest = {key: value for key, value in plan.items() if key != "channels"}
    return SessionSetup(signals=tuple(map(as_recorded, plan["channels"])), **rest)


def session_events(schedule: Schedule, block: int = 50, seed: int = 1) -> Iterator[ev.Event]:
    """All events of a session that goes well; `block` samples arrive at a time."""
    now = 100.0
    yield ev.SessionStarted(now, wall="2026-11-21T09:00:00+00:00")
    for run in schedule.runs:
        prompt = Prompt(kind="move", text=f"Move the load cell to {run.position_m}.")
        yield ev.OperatorAsked(now, prompt)
        yield ev.OperatorAnswered(now + 2, prompt, done=True)
        yield from _run_events(run, now + 3.0, block, seed)
        now += 5.0 + run.duration_s
    yield ev.SessionStopped(
        now,
        outcome=ev.Outcome.COMPLETED,
        reason="All runs were done.",
        output=ev.OutputState.SAFE,
        wall="2026-11-21T09:05Z",
    )


def drive_V(run, time_s):
    """The voltage at the sheet."""
    steps = np.array([step.time_s for step in run.steps]) + LATE_S
    volts = np.array([0.0, *(step.voltage_V for step in run.steps)])
    return volts[np.searchsorted(steps, time_s, side="right")]


def force_N(run, time_s):
    """Grows along with the voltage, and drifts."""
    return 1e-3 + 1e-3 * drive_V(run, time_s) + 1e-5 * time_s + 0.1 * (run.position_m or 0.0)


def _run_events(run, start_s: float, block: int, seed: int) -> Iterator[ev.Event]:
    rng = np.random.default_rng((seed, run.index))
    clock = SampleClock(start_s - 0.2, 1e-4, RATE_HZ)
    count = int((run.duration_s + 0.4) * RATE_HZ)
    time_s = clock.start_s + np.arange(count) / RATE_HZ - start_s
    drive = drive_V(run, time_s)
    force = force_N(run, time_s) * SENSITIVITY_V_PER_N + OFFSET_V
    volts = np.stack([force + rng.normal(0, 1e-6, count), drive * 0.02, drive])
    happenings: list[tuple[float, int, ev.Event]] = []

    def at(when_s: float, event: ev.Event) -> None:
        happenings.append((when_s, len(happenings), event))

    for first in range(0, count, block):
        part = volts[:, first : first + block]
        read_s = clock.time_of(first + part.shape[1])
        at(read_s, ev.SignalsArrived(read_s, run.index, SignalBlock(first, part, read_s)))
    for number, step in enumerate(run.steps):
        due = start_s + step.time_s
        write = VoltageWrite(
            step.voltage_V, step.voltage_V / 10, due + LATE_S - 1e-4, due + LATE_S + 1e-4
        )
        at(
            write.after_s,
            ev.VoltageSet(write.after_s, run=run.index, step=number, due_s=due, write=write),
        )
    for reading in run.readings:
        sample_s = start_s + run.time_of(reading) + LATE_S
        image = rng.integers(0, 255, FRAME_SHAPE, dtype=np.uint8)
        frame = Frame(
            number=reading.index * 15, time_s=sample_s + 4e-3, device_time_s=None, image=image
        )
        index = clock.index_at(sample_s)
        taken = ev.ReadingTaken(
            time_s=sample_s + 0.1,
            run=run.index,
            planned=reading,
            sample_index=index,
            sample_time_s=sample_s,
            values={
                "force_N": float(force_N(run, sample_s - start_s)),
                "drive_V": reading.voltage_V,
                "current_A": 0.01 * reading.voltage_V,
            },
            frame=frame,
            frame_offset_s=4e-3,
            valid=True,
            why="",
        )
        at(sample_s + 0.1, taken)
    yield ev.RunStarted(
        time_s=start_s,
        run=run,
        sample_clock=clock,
        channels=NAMES,
        frame_shape=FRAME_SHAPE,
        stage_position_m=None,
        since_wetting_s=12.5,
    )
    yield ev.OutputChanged(start_s, ev.OutputState.ENERGISED, "the first step")
    # Among events of one moment the blocks of samples may fall anywhere; the rest keep their order.
    yield from (event for _, _, event in sorted(happenings, key=lambda each: each[:2]))
    yield ev.OutputChanged(start_s + run.duration_s, ev.OutputState.SAFE, "0 V read back")
    yield ev.RunStopped(
        time_s=start_s + run.duration_s + 0.3,
        run=run.index,
        completed=True,
        lost_samples=0,
        frames_grabbed=500,
        frames_dropped=0,
    )


def record(path: Path, schedule: Schedule, block: int = 50, **changes: object) -> None:
    """Record a whole session."""
    with SessionWriter(path, **settings(schedule) | changes) as writer:
        for event in session_events(schedule, block):
            writer.handle(event)


def main(path: str) -> None:
    """Record seven times as fast as it would be; print each reading once it is handed over."""
    pause = threading.Event()
    schedule = small_schedule(readings=4)
    with SessionWriter(Path(path), **settings(schedule)) as writer:
        print("open", flush=True)
        for event in session_events(schedule):
            writer.handle(event)
            if isinstance(event, ev.SignalsArrived):
                pause.wait(0.0075)
            if isinstance(event, ev.ReadingTaken):
                print(event.run, event.planned.index, flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
