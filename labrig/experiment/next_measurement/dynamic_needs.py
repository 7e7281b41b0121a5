"""Whether a protocol can determine the parameters of the sheet in time.

A sheet that the load cell holds hardly moves: pulses in contact tell its stiffness, its electrodes
and its moment per volt, but neither mass nor loss. A free sheet tells stiffness and mass only as
their ratio.
"""

from __future__ import annotations

from collections.abc import Iterator

from labrig.config import EXTRAS, ProtocolConfig, RigConfig
from protocols import PlannedRun, Schedule

# The first mode of a free sheet is at 3 Hz, with an elongation at 7 Hz: three frames a period.
LEAST_FRAME_RATE_HZ = 20.0
# Charging takes tens of milliseconds, and the sheet's third mode is at 60 Hz.
LEAST_SAMPLE_RATE_HZ = 200.0


def is_asked(protocol: ProtocolConfig, schedule: Schedule) -> bool:
    """Whether a dynamic fit is asked for, by [analysis] or by an extra that is for nothing else."""
    extras = {run.extra for run in schedule.runs}
    names = {name for name, part in EXTRAS.parts().items() if part.part.dynamic}
    return protocol.analysis.dynamic or bool(extras & names)


def not_determined(
    protocol: ProtocolConfig, schedule: Schedule, rig: RigConfig | None = None
) -> list[str]:
    """Return what a dynamic fit would not know from this protocol, a sentence part each.

    With a rig also what this one does not record. Empty where no dynamic fit is asked for.
    """
    if not is_asked(protocol, schedule):
        return []
    every = protocol.camera.keep_all_frames
    names = dict.fromkeys(run.configuration for run in schedule.runs)
    found = [] if rig is None else list(_not_recorded(rig))
    for name in names:
        runs = [run for run in schedule.runs if run.configuration == name]
        found += _of_configuration(runs, name, every=every, camera=rig is None or bool(rig.camera))
    rate_hz = schedule.frame_rate_hz
    if rate_hz < LEAST_FRAME_RATE_HZ and (rig is None or rig.camera):
        found.append(
            f"{rate_hz:g} frames/s are too slow for a free sheet, which swings at 3 to 7 Hz: ask "
            f"for [camera] frame_rate_hz = {LEAST_FRAME_RATE_HZ:g} or more"
        )
    return found


def _not_recorded(rig: RigConfig) -> Iterator[str]:
    rate_hz = rig.boards.sample_rate_hz
    if rate_hz < LEAST_SAMPLE_RATE_HZ:
        yield (
            f"{rate_hz:g} samples/s of force and current are too few for the electrodes, which "
            f"charge in tens of milliseconds: ask for sample_rate_hz = {LEAST_SAMPLE_RATE_HZ:g} "
            "or more"
        )


def _of_configuration(
    runs: list[PlannedRun], name: str, *, every: bool, camera: bool
) -> Iterator[str]:
    if not camera:
        yield (
            f"mass and loss of the sheet '{name}' are not determined without a camera: only the "
            "shapes of a free sheet tell them"
        )
    elif not any(_is_filmed_moving(run, every=every) for run in runs):
        yield (
            f"mass and loss of the sheet '{name}' are not determined by pulses in contact: add "
            "[extras] release = true"
        )
    if not any(run.measures for run in runs):
        yield (
            f"stiffness, mass and moment per volt of the sheet '{name}' are determined only as "
            "ratios without a force: measure it at a position, too"
        )


def _is_filmed_moving(run: PlannedRun, *, every: bool) -> bool:
    driven = any(step.voltage_V for step in run.steps)
    return run.position_m is None and driven and (every or run.keep_all_frames)
