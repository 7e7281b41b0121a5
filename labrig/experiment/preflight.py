"""Check whether the rig is ready, with nothing but 0 V at the output."""

from __future__ import annotations

import datetime as dt
import math
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from drivers.force_sensors.metered_input import INTERVAL_S, MeteredInput
from drivers.identity import identities_of
from drivers.interfaces import (
    Camera,
    DeviceError,
    DeviceIdentity,
    Frame,
    LimitedTravel,
    Positioner,
    in_words,
)
from drivers.load_cell import LoadState
from drivers.positioners.conformance import LARGEST_TRAVEL_M, two_numbers
from labrig.check import Check
from labrig.config.templates import template_path
from labrig.errors import BadInputError, NotReadyError
from labrig.experiment.next_measurement.dynamic_needs import not_determined
from labrig.experiment.plan import Plan, load_plan
from labrig.experiment.precautions import precautions
from labrig.experiment.rig.channels import inputs_of
from labrig.experiment.rig.identities import acquisition_of
from labrig.experiment.rig.rig import DRIVE, FORCE, Rig, opened, unexpected
from labrig.plausibility import SetUp, calibration_age, set_up_checks
from labrig.session.format.devices import NOT_KNOWN, acquisition_in_words
from protocols import Schedule, positions_m, time_under_voltage_s

_QUIET_N = 1e-3  # scatter of the load cell's 50 ms means: more is a draught, or a loose wire
_LISTEN_S = 0.5
_JITTER = 1.2  # of the time between two readings of a meter
_WATCH_S = 1.0
_ANSWER_S = 0.2  # of a camera that was triggered
_RATE_TOLERANCE = 0.1
_FREE_MARGIN = 1.5  # disk space wanted, as a multiple of the estimate


def check_rig(
    rig: Path,
    protocol: Path | None = None,
    sheet: Path | None = None,
    about: Path | None = None,
) -> list[Check]:
    """`labrig check`: the files beside rig.toml where none are named, else the shipped ones."""
    from labrig.experiment.operator import NoOperator
    from labrig.experiment.rig.wiring import wire

    plan = plan_of(rig, protocol, sheet, about)
    wired = wire(plan, NoOperator(lambda _text: None))
    return preflight(wired, plan, rig.parent)


def plan_of(
    rig: Path,
    protocol: Path | None = None,
    sheet: Path | None = None,
    about: Path | None = None,
) -> Plan:
    """Return a plan for what needs the rig but no particular experiment."""
    files = protocol or _beside(rig, "protocol"), sheet or _beside(rig, "sheet")
    return load_plan(rig, *files, about)


def _beside(rig: Path, name: str) -> Path:
    """NAME.toml beside the rig's file, or the one that `labrig init` writes."""
    beside = rig.parent / f"{name}.toml"
    return beside if beside.exists() else template_path(f"{name}.toml")


def preflight(rig: Rig, plan: Plan, folder: Path) -> list[Check]:
    """Open the rig, check everything, close it. `folder` is where the session would go."""
    checks = [*calibrations(plan), *doubts(plan), _names(plan), *_schedule(plan)]
    checks += [disk_space([plan], folder), *precautions(plan)]
    try:
        with opened(rig):
            checks += open_rig_checks(rig, plan)
    except NotReadyError as fault:
        checks.append(
            Check(name="devices", ok=False, found=str(fault), wanted="every device there")
        )
    return checks


def open_rig_checks(rig: Rig, plan: Plan) -> list[Check]:
    """Return the checks that need the open devices."""
    by_device = {
        "boards": _boards(rig),
        "inputs": _inputs(rig, plan),
        "stage": stage_checks(rig.stage, plan.schedule),
    }
    if rig.camera is not None:
        by_device["camera"] = camera_checks(rig, rig.camera, plan)
    return [check for name, each in by_device.items() for check in _until_it_fails(name, each)]


def _until_it_fails(name: str, checks: Iterator[Check]) -> Iterator[Check]:
    """Yield the checks of a device; one that dies amid them has failed, and others are checked."""
    try:
        yield from checks
    except DeviceError as fault:
        found = in_words(fault)
    except (Exception, SystemExit) as fault:  # noqa: BLE001 - named with its place
        found = unexpected(f"checking the {name}", fault)
    else:
        return
    yield Check(name=name, ok=False, found=found, wanted="an answer")


def calibrations(plan: Plan) -> Iterator[Check]:
    """How old they are. Needs no device."""
    cell, camera, optics = plan.rig.load_cell, plan.rig.camera, plan.optics
    today = dt.datetime.now(dt.UTC).date()
    yield calibration_age(
        "load cell calibration", plan.calibration.date, cell.warn_after_days, today
    )
    if camera is not None and optics is not None and optics.date:
        try:
            date = dt.date.fromisoformat(optics.date[:10])
        except ValueError:
            found, wanted = f"dated {optics.date!r}", "a date such as 2026-11-02"
            yield Check(name="camera calibration", ok=False, found=found, wanted=wanted)
        else:
            yield calibration_age("camera calibration", date, camera.warn_after_days, today)


def doubts(plan: Plan) -> list[Check]:
    """Return the numbers of the files that can hardly be meant. Needs no device."""
    optics, by_board = plan.optics, plan.rig.raw_force_unit == "V"
    range_V = next(each.range_V for each in inputs_of(plan.rig) if each.name == FORCE)
    return list(
        set_up_checks(
            SetUp(
                schedule=plan.schedule,
                sheets=plan.sheets,
                calibration=plan.calibration if by_board else None,
                force_range_V=range_V,
                sheet_voltage_limit_V=plan.rig.limits.sheet_voltage_V,
                px_per_mm=None if optics is None or optics.homography else optics.px_per_mm,
                image_size=None if optics is None else optics.image_size,
            )
        )
    )


def refuse_implausible(plan: Plan) -> None:
    """Raise BadInputError with a line for each number that nobody can mean."""
    faults = [check.in_words for check in doubts(plan) if not check.ok]
    if faults:
        raise BadInputError("\n".join(f"{text}." for text in faults))


def estimated_size(plan: Plan, frame_bytes: int) -> int:
    """Bytes of the session: raw samples of all channels, and the frames that are kept."""
    seconds = sum(run.duration_s for run in plan.schedule.runs)
    samples = len(inputs_of(plan.rig)) * 8 * seconds * plan.rig.boards.sample_rate_hz
    readings = sum(len(run.readings) for run in plan.schedule.runs)
    every = plan.protocol.camera.keep_all_frames
    filmed_s = sum(run.duration_s for run in plan.schedule.runs if every or run.keep_all_frames)
    frames = readings + filmed_s * plan.schedule.frame_rate_hz
    return math.ceil(samples + frames * frame_bytes) + 1_000_000


def _names(plan: Plan) -> Check:
    """Return what the session will state of operator and sample; nothing is required."""
    operators, sample = ", ".join(plan.about.operators), plan.about.sample
    return Check(
        name="operator and sample",
        ok=True,
        found=f"operator {operators or 'not stated'}, "
        f"sample {sample.identity if sample else 'not stated'}",
        wanted="any (about.toml)",
    )


def _schedule(plan: Plan) -> Iterator[Check]:
    """Yield how long the sheet is under voltage, and what a dynamic fit would not know."""
    under_s = [time_under_voltage_s(run) for run in plan.schedule.runs]
    yield Check(
        name="time under voltage",
        ok=True,
        found=f"{sum(under_s):.1f} s in all, up to {max(under_s):.1f} s in one run",
        wanted=f"at most {plan.rig.limits.time_under_voltage_s:g} s in one run",
    )
    for text in not_determined(plan.protocol, plan.schedule, plan.rig):
        yield Check(
            name="dynamic fit",
            ok=True,
            found=text,
            wanted="a protocol that determines what is asked",
            warning=True,
        )


def disk_space(plans: Sequence[Plan], folder: Path) -> Check:
    """Check whether all these sessions find room in a folder, which need not exist yet."""
    wanted = _FREE_MARGIN * sum(_session_bytes(plan) for plan in plans)
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    free = shutil.disk_usage(there).free
    return Check(
        name="disk space",
        ok=free >= wanted,
        found=f"{free / 1e9:.1f} GB free",
        wanted=f"at least {wanted / 1e9:.2f} GB for "
        + ("this session" if len(plans) == 1 else f"these {len(plans)} sessions"),
    )


def _session_bytes(plan: Plan) -> int:
    columns, rows = (plan.optics.image_size if plan.optics else None) or (640, 480)
    return estimated_size(plan, columns * rows if plan.rig.camera else 0)


def _boards(rig: Rig) -> Iterator[Check]:
    for each in rig.boards.findings():
        yield Check(name=each.name, ok=each.ok, found=each.found, wanted=each.wanted)


def _inputs(rig: Rig, plan: Plan) -> Iterator[Check]:
    volts = rig.signals.measure(_LISTEN_S)
    names = list(rig.signals.channels)
    drive_V = float(np.mean(volts[names.index(DRIVE)]))
    limit_V = plan.rig.limits.safe_below_V
    yield Check(
        name="output at 0 V",
        ok=abs(drive_V) < limit_V,
        found=f"{1e3 * drive_V:+.1f} mV read back",
        wanted=f"within {1e3 * limit_V:g} mV of 0 V",
    )
    force_V = volts[names.index("force")]
    state = rig.load_cell.check(force_V)
    yield Check(
        name="load cell in its range",
        ok=state.state in {LoadState.FINE, LoadState.ABOVE_CAPACITY},
        found=state.text or f"{1e3 * float(np.mean(rig.load_cell.newtons(force_V))):+.2f} mN",
        wanted=f"within {1e3 * plan.calibration.capacity_N:.1f} mN",
        warning=state.state is LoadState.ABOVE_CAPACITY,
    )
    scatter_N = float(np.std(_means(rig.load_cell.newtons(force_V), 10)))
    yield Check(
        name="load cell quiet",
        ok=scatter_N < _QUIET_N,
        found=f"{1e3 * scatter_N:.3f} mN from one 50 ms to the next",
        wanted=f"below {1e3 * _QUIET_N:g} mN",
    )
    if isinstance(rig.signals, MeteredInput):
        yield meter_check(rig.signals.interval_s(), plan.schedule)


def meter_check(interval_s: float, schedule: Schedule) -> Check:
    """Whether a meter gives the force within each reading's window, not beside it alone."""
    halves_s = [each.half_window_s for run in schedule.runs for each in run.readings]
    shortest_s = max(2 * min(halves_s, default=0.0), INTERVAL_S)  # no meter is asked more often
    return Check(
        name="readings of the force",
        ok=True,
        found=f"one in {interval_s:.2f} s",
        wanted=f"one in each window of {shortest_s:g} s (protocol.toml)",
        warning=interval_s > _JITTER * shortest_s,
    )


def _means(values: np.ndarray, parts: int) -> list[float]:
    return [float(np.mean(part)) for part in np.array_split(values, parts)]


def stage_checks(stage: Positioner, schedule: Schedule) -> Iterator[Check]:
    """Yield whether the travel of a stage that knows it holds all positions of a schedule.

    Where it does not hold those of repeated runs only, which nobody may want, that is a warning.
    """
    wanted_m, repeats_m = positions_m(schedule.runs), positions_m(schedule.repeats)
    if not wanted_m or not isinstance(stage, LimitedTravel):
        return
    ends_m = _travel_m(stage)
    if isinstance(ends_m, str):
        yield Check(
            name="travel of the stage",
            ok=False,
            found=ends_m,
            wanted="its lower and its upper end, in m",
        )
        return
    low_m, high_m = ends_m
    missed, to_repeat = (
        ", ".join(f"{at_m * 1e3:g}" for at_m in some if not low_m <= at_m <= high_m)
        for some in (wanted_m, repeats_m)
    )
    without = f", without {missed} mm" if missed else ""
    if to_repeat and not missed:
        without = f", without {to_repeat} mm, from where repeated runs approach"
    yield Check(
        name="travel of the stage",
        ok=not missed,
        found=f"{low_m * 1e3:.2f} to {high_m * 1e3:.2f} mm{without}",
        wanted=f"{wanted_m[0] * 1e3:g} to {wanted_m[-1] * 1e3:g} mm (protocol.toml)",
        warning=bool(without) and not missed,
    )


def _travel_m(stage: LimitedTravel) -> tuple[float, float] | str:
    """Return both ends, or why they cannot be: the code may be another distribution's."""
    stated: object = stage.travel_m()
    ends_m = two_numbers(stated)
    if ends_m is None:
        return f"its travel_m returned {stated!r:.60}"
    low_m, high_m = ends_m
    if abs(high_m - low_m) > LARGEST_TRAVEL_M:
        return f"{low_m:g} to {high_m:g} m: is it in mm?"
    return ends_m


def camera_checks(rig: Rig, camera: Camera, plan: Plan) -> Iterator[Check]:
    """Yield what a camera's images show: their size, their rate, and that they are not blank."""
    yield Check(name="camera", ok=True, found=_who(camera), wanted="any")
    settings = acquisition_in_words(acquisition_of(camera))
    if settings:
        yield Check(name="camera settings", ok=True, found=settings, wanted="as read back")
    rows, columns = camera.frame_shape
    wanted_size = plan.optics.image_size if plan.optics else None
    yield Check(
        name="camera image size",
        ok=wanted_size is None or tuple(wanted_size) == (columns, rows),
        found=f"{columns} x {rows}",
        wanted="any"
        if wanted_size is None
        else f"{wanted_size[0]} x {wanted_size[1]} (optics.json)",
    )
    target_hz = plan.schedule.frame_rate_hz
    frames, rate_hz, fault = _watched(rig, camera, target_hz)
    if not fault and not _in_time(rate_hz, target_hz):
        # what a busy computer could not take before comes all at once: so once more
        frames, rate_hz, fault = _watched(rig, camera, target_hz)
    yield Check(
        name="camera rate",
        ok=_in_time(rate_hz, target_hz),
        found=fault or f"{rate_hz:g} frames/s",
        wanted=f"{target_hz:g} frames/s (protocol.toml)",
    )
    counts = camera.counts
    if counts.incomplete or counts.missed:
        yield Check(
            name="camera loses nothing",
            ok=True,
            found=f"{counts.incomplete} frames came incomplete, {counts.missed} never came",
            wanted=f"all of {target_hz * _WATCH_S:g}: check cable, network and its load",
            warning=True,
        )
    if frames:
        image = frames[-1].image
        spread = float(np.ptp(image))
        yield Check(
            name="camera sees something",
            ok=spread > 0.05 * np.iinfo(image.dtype).max,
            found=f"grey levels {int(image.min())} to {int(image.max())}",
            wanted="neither black nor blank",
        )


def _watched(rig: Rig, camera: Camera, target_hz: float) -> tuple[Sequence[Frame], float, str]:
    """Frames of a while, how many come in a second, and what the camera complains of."""
    camera.start()
    began_s = rig.clock.now()
    camera.want(began_s, began_s + _WATCH_S + _ANSWER_S)
    frames: Sequence[Frame] = []
    fault = ""
    try:
        _let_expose(rig, began_s, target_hz)
        frames = camera.frames()
    except DeviceError as error:
        fault = str(error)
    camera.stop()
    return frames, camera.counts.grabbed / _WATCH_S, fault


def _let_expose(rig: Rig, began_s: float, target_hz: float) -> None:
    """Let a free camera run for a while; trigger another one in the protocol's rhythm."""
    if rig.trigger is not None:
        for number in range(round(_WATCH_S * target_hz)):
            rig.clock.sleep_until(began_s + number / target_hz)
            rig.trigger.fire()
    rig.clock.sleep_until(began_s + _WATCH_S + (0.0 if rig.trigger is None else _ANSWER_S))


def _who(camera: Camera) -> str:
    """Return what an open camera says that it is."""
    known = next(iter(identities_of(camera)), DeviceIdentity())
    said = " ".join(text for text in (known.maker, known.product, known.serial) if text)
    return said or known.name or NOT_KNOWN


def _in_time(rate_hz: float, target_hz: float) -> bool:
    return abs(rate_hz - target_hz) <= _RATE_TOLERANCE * target_hz + 1 / _WATCH_S
