"""From a session's frames to neutral curves: of each condition's mean image, and frame by frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from multiprocessing import current_process, get_context
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from drivers.interfaces import FloatArray, GreyImage
from labrig.errors import BadInputError
from labrig.extractors.choice import BUILT_IN, chosen_extractor
from labrig.parent_process import end_with_parent, interrupts_blocked
from labrig.progress import Progress
from labrig.session import RecordedSession, RunRecord, open_session
from labrig.session.format.layout import NO_FRAME, Array
from model.measurements import Contact, Curve, SheetGeometry, in_volts
from protocols.planning.schedule import Purpose

if TYPE_CHECKING:
    from labrig.vision import NeutralCurve, Optics, StripGeometry

MEAN_OF = ("zero", "kept", "no_contact")  # kinds of readings whose frames make the mean image
MEAN_FULL_SCALE = 65535.0  # of the mean image
WORTH_PROCESSES_S = 5.0  # of work that is left: about what two processes take to load
HOPELESS = 2  # frames without a curve, after a mean image without one


@dataclass(frozen=True, kw_only=True)
class CurveJob:
    """The frames of one condition."""

    run: int
    voltage_V: float
    rows: dict[int, int]  # reading -> row of the run's images
    in_mean: tuple[int, ...]  # readings that make the mean image
    strip: StripGeometry
    optics: Optics
    arc: tuple[float, float] | None  # radius (m) and origin (rad); None: nothing touches the sheet
    extractor: str  # by name: each process imports it by itself


@dataclass(frozen=True, kw_only=True)
class ConditionCurves:
    """What was found in them; a curve that was not found is a warning."""

    run: int
    voltage_V: float
    mean: Curve | None
    by_reading: dict[int, Curve] = field(default_factory=dict)
    contact: Contact | None = None  # as the mean image shows it
    systematic_px: float | None = None  # uncertainty of the mean image's curve; None: no curve
    warnings: tuple[str, ...] = ()


def measure_curves(
    session: RecordedSession,
    optics: Optics,
    sheets: Mapping[str, SheetGeometry],
    *,
    progress: Progress | None = None,
    workers: int = 1,
    extractor: str = BUILT_IN,
) -> list[ConditionCurves]:
    """Return the curves of every run and voltage with frames; `workers` processes share the work.

    With more than one, a script that calls this must be importable (`if __name__ == "__main__"`).
    """
    chosen_extractor(extractor)  # an unknown name fails before any work
    jobs = list(curve_jobs(session, optics, sheets, extractor))
    found: list[ConditionCurves] = []
    for done, curves in enumerate(shared_out(session, jobs, workers), start=1):
        found.append(curves)
        if progress is not None:
            run = session.run(curves.run).planned
            progress(done / len(jobs), f"{run.configuration}, {place_of(run.position_m)}")
    return found


WITH_CURVES = (Purpose.MEASUREMENT, Purpose.FREE_SHAPE)  # of what runs curves are found


def place_of(position_m: float | None) -> str:
    """Return a position for people."""
    return "free" if position_m is None else f"{position_m * 1000:g} mm"


def curve_jobs(
    session: RecordedSession,
    optics: Optics,
    sheets: Mapping[str, SheetGeometry],
    extractor: str = BUILT_IN,
    runs: Sequence[RunRecord] | None = None,
) -> Iterator[CurveJob]:
    """Return one job for each run (by default all) and voltage with frames, in their order."""
    for run in session.runs if runs is None else runs:
        if run.planned.purpose not in WITH_CURVES:
            continue
        sheet = sheets[run.planned.configuration]
        readings = run.readings[run.readings["frame"] != NO_FRAME]
        for voltage_V in dict.fromkeys(readings["voltage_V"].tolist()):
            rows = readings[readings["voltage_V"] == voltage_V]
            if len(rows):
                yield _job(run, float(voltage_V), rows, sheet, optics, extractor)


def _job(
    run: RunRecord,
    voltage_V: float,
    rows: Array,
    sheet: SheetGeometry,
    optics: Optics,
    extractor: str,
) -> CurveJob:
    from labrig.vision import StripGeometry

    touched = run.planned.purpose is Purpose.MEASUREMENT
    counts = rows["valid"] & np.isin(rows["kind"], MEAN_OF)
    return CurveJob(
        run=run.planned.index,
        voltage_V=voltage_V,
        rows={int(row["index"]): int(row["frame"]) for row in rows},
        in_mean=tuple(int(row["index"]) for row in rows[counts]),
        strip=StripGeometry(
            free_length_m=sheet.free_length_m,
            elongation_m=sheet.elongation_m,
            thickness_m=sheet.thickness_m,
        ),
        optics=optics,
        arc=(sheet.arc_radius_m, sheet.arc_origin_rad) if touched else None,
        extractor=extractor,
    )


# --------------------------------------------------------------------------------------- the work


def mean_image(images: Iterable[GreyImage], full_scale: float) -> GreyImage:
    """Return the mean of images as 16 bit, full scale at `MEAN_FULL_SCALE`.

    Raises ValueError without any.
    """
    total: FloatArray | None = None
    count = 0
    for image in images:
        total = image.astype(np.float64) if total is None else total + image
        count += 1
    if total is None:
        raise ValueError("the mean of no images")
    scaled: GreyImage = np.rint(total * (MEAN_FULL_SCALE / full_scale / count)).astype(np.uint16)
    return scaled


def curves_of(job: CurveJob, session: RecordedSession) -> ConditionCurves:
    """Find the curves of one condition."""
    from labrig.vision import compare_with_frames, contact_from_image
    from labrig.vision.uncertainty.parts import systematic_sigma_px

    run = session.run(job.run)
    volts = in_volts(job.voltage_V)
    label = f"{run.planned.configuration}, {place_of(run.planned.position_m)}, {volts}"
    warnings: list[str] = []
    mean = contact = None
    if job.in_mean:
        image = mean_image(
            (run.image(job.rows[reading]) for reading in job.in_mean), _full_scale(job, session)
        )
        optics = job.optics.model_copy(update={"bits": 16})
        mean = chosen_extractor(job.extractor).curve(image, optics, job.strip)
        if job.arc is not None:
            contact = contact_from_image(
                image, mean, optics, *job.arc, expected_m=run.planned.position_m
            )
        warnings += [f"{label}, mean image: {text}" for text in mean.warnings]
        if not mean.ok:
            warnings.append(f"{label}: no curve in the mean image: {mean.why}")
    near = _in_levels(mean, _full_scale(job, session)) if mean is not None and mean.ok else None
    by_reading, failed = _frame_by_frame(job, run, near)
    if failed:
        reading, why = next(iter(failed.items()))
        frames = f"{len(failed)} frame{'' if len(failed) == 1 else 's'}"
        warnings.append(
            f"{label}: no curve in {frames}, as in that of reading {reading + 1}: {why}"
        )
    single = [by_reading[reading] for reading in job.in_mean if reading in by_reading]
    if len(single) > 1:
        both = compare_with_frames(mean, single, job.optics.px_per_mm)
        warnings += [f"{label}: {text}" for text in both.warnings]
    return ConditionCurves(
        run=job.run,
        voltage_V=job.voltage_V,
        mean=mean.as_curve() if mean is not None and mean.ok else None,
        systematic_px=systematic_sigma_px(mean) if mean is not None and mean.ok else None,
        by_reading=by_reading,
        contact=contact,
        warnings=tuple(warnings),
    )


def _in_levels(mean: NeutralCurve, full_scale: float) -> NeutralCurve:
    """Return the curve of a mean image with its contrast in the grey levels of one frame."""
    return replace(mean, contrast=mean.contrast * full_scale / MEAN_FULL_SCALE)


def _frame_by_frame(
    job: CurveJob, run: RunRecord, near: NeutralCurve | None
) -> tuple[dict[int, Curve], dict[int, str]]:
    """Return each reading's own curve, and for those without one the reason.

    Each frame is searched near a curve; where there is none, or it is no longer there, everywhere.
    Where neither the mean image nor the first frames show a sheet, the rest are left out.
    """
    extractor = chosen_extractor(job.extractor)
    found: dict[int, Curve] = {}
    failed: dict[int, str] = {}
    for reading, row in job.rows.items():
        if near is None and not found and len(failed) >= HOPELESS:
            break
        curve = extractor.curve(run.image(row), job.optics, job.strip, start=near)
        if curve.ok:
            found[reading] = curve.as_curve()
        else:
            failed[reading] = curve.why
    return found, failed


def _full_scale(job: CurveJob, session: RecordedSession) -> float:
    if session.frame_dtype == "uint8":
        return 255.0
    return float(2 ** (job.optics.bits if job.optics.bits > 8 else 16) - 1)


# -------------------------------------------------------------------------------------- processes

_worker_session: RecordedSession | None = None


def shared_out(
    session: RecordedSession, jobs: list[CurveJob], workers: int
) -> Iterator[ConditionCurves]:
    """Yield the curves of all jobs in their order; `workers` processes share them.

    Processes of their own load for seconds, so those that are quickly done are done here.
    Raises BadInputError where these processes end.
    """
    first, others, last_s = jobs[:2], jobs[2:], 0.0
    for job in first:  # two, because the first loads or compiles as well
        began_s = process_time()
        yield curves_of(job, session)
        last_s = process_time() - began_s
    if workers > 1 and last_s * len(others) > WORTH_PROCESSES_S:
        yield from by_processes(session.path, others, workers)
    else:
        yield from (curves_of(job, session) for job in others)


def by_processes(path: Path, jobs: list[CurveJob], workers: int) -> Iterator[ConditionCurves]:
    """Yield the curves of all jobs in their order; `workers` new processes share them.

    Raises BadInputError where these processes end.
    """
    if getattr(current_process(), "_inheriting", False):
        # A script that is not importable begins anew in each of its own workers: end quietly, the
        # process that started them says why.
        raise SystemExit(1)
    try:
        with _pool(path, workers) as pool:
            with interrupts_blocked():  # all processes are started here
                found = pool.map(_in_worker, jobs, chunksize=1)
            yield from found
    except BrokenProcessPool:
        raise BadInputError(
            f"{path}: the processes that look for curves ended; a script that calls"
            ' labrig.analyze with workers must do so under `if __name__ == "__main__":`, and one'
            " that does may have run out of memory: take fewer workers."
        ) from None


@contextmanager
def _pool(path: Path, workers: int) -> Iterator[ProcessPoolExecutor]:
    # Spawned everywhere, as Windows does it: a forked HDF5 library would share its open files.
    context = get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, initializer=_open_in_worker, initargs=(path,))
    try:
        yield pool
    except BaseException:  # Ctrl-C, say: what they are at is not waited for
        for process in (pool._processes or {}).values():
            process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _open_in_worker(path: Path) -> None:
    global _worker_session
    end_with_parent()
    _worker_session = open_session(path)


def _in_worker(job: Any) -> ConditionCurves:
    assert _worker_session is not None  # noqa: S101 - opened by the initializer
    return curves_of(job, _worker_session)
