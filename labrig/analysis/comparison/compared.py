"""`compare_in_time`: the sheet in time as labrig has it, beside models from the literature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from labrig.analysis.comparison.result import ComparedModel, ComparedQuantity, DynamicComparison
from labrig.analysis.motion import motion_record
from labrig.analysis.motion.beginning import COARSE, StatedValues, beginning
from labrig.analysis.motion.dynamic_fit import DynamicFit
from labrig.analysis.motion.noise import noise_at_first
from labrig.analysis.motion.record import MotionRecord
from labrig.analysis.motion.rest_shape import rest_curvature
from labrig.errors import BadInputError
from labrig.extractors.choice import BUILT_IN
from labrig.progress import Progress, silent, within
from labrig.session import RecordedSession
from model.dynamics import DynamicBeam
from model.dynamics.comparison import (
    ComparisonRow,
    Contender,
    FullContender,
    HeldOut,
    MeasuredRun,
    PublishedContender,
    compare_models,
    hold_out,
)
from model.dynamics.identification import RecordedRun, RecordingNoise, best_sheet
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.models import models
from model.measurements import ModelError, SheetGeometry
from model.mechanics.field import Field

RATE_HZ = 250.0  # of the samples that are used: the sheet's modes lie below 100 Hz
MOST_POSITIONS = 4  # in contact: each adds seconds
FEWEST_FRAMES = 10  # of a free sheet that moves
REST_NODES = 41
NEAR, FOUND = 1.0, 0.1  # ends of a search, in standard deviations of the parameters
FRAMES_SHARE, FIT_SHARE = 0.3, 0.3  # of the time: finding curves, fitting the full model


def why_not_in_time(session: RecordedSession, configuration: str) -> str:
    """Return why models in time cannot be compared, a sentence; empty: they can.

    A comparison needs the force in contact, the current, and frames of a free sheet that moves.
    """
    try:
        record = motion_record(session, configuration, frames=False)
    except BadInputError as error:
        return str(error)
    plans = [run.plan for run in record.runs]
    if not any(plan.force for plan in plans):
        return "no force in contact was recorded under voltage: add a measurement at a position."
    if not any(plan.current for plan in plans):
        return (
            "no current was recorded: wire the current channel and state [current_sense] shunt_ohm"
            " in rig.toml."
        )
    free = [
        run for run in session.runs
        if run.planned.configuration == configuration and run.planned.position_m is None
        and any(step.voltage_V for step in run.planned.steps)
    ]  # fmt: skip
    if max((run.frame_count for run in free), default=0) < FEWEST_FRAMES:
        return (
            "no free sheet that moves was filmed, so mass and loss are unknown: add [extras]"
            " release = true to protocol.toml."
        )
    return ""


def compare_in_time(
    session: RecordedSession,
    configuration: str,
    stated: StatedValues | None = None,
    *,
    progress: Progress | None = None,
    extractor: str = BUILT_IN,
) -> DynamicComparison:
    """Fit all models to a session's runs but some, and let them predict those.

    All models have the same k0, that of the frames at rest. Raises BadInputError, one sentence.
    """
    tell = progress or silent
    if why := why_not_in_time(session, configuration):
        raise BadInputError(f"{session.path}: {configuration}: {why}")
    record = motion_record(
        session, configuration, positions_m=_positions(session, configuration),
        extractor=extractor, progress=within(tell, 0.0, FRAMES_SHARE),
    )  # fmt: skip
    begun = FRAMES_SHARE + FIT_SHARE
    tell(FRAMES_SHARE, "the moving sheet")
    try:
        beam, values, data = _full(record, stated or StatedValues())
        full = FullContender(beam, COARSE)
        others = [PublishedContender(one) for one in models().values()]
        contenders: list[Contender] = [full, *others]
        rows = compare_models(
            contenders, data, lambda one, _: values if one is full else None,
            within(tell, begun, 1.0),
        )  # fmt: skip
    except ModelError as error:
        raise BadInputError(f"{session.path}: {configuration}: {error}.") from None
    return DynamicComparison(
        configuration=configuration, models=tuple(_kept(row) for row in rows),
        held_out=data.in_words, values=_values(data), rate_hz=RATE_HZ, missing=record.missing,
    )  # fmt: skip


def compare_fitted(
    fit: DynamicFit, *, names: Sequence[str] | None = None, progress: Progress | None = None
) -> DynamicComparison:
    """Compare with a sheet in time that is fitted already, for less time: its k0 is the same.

    names: of the models from the literature, in any order; None: all. Raises BadInputError.
    """
    whole = [run for run in fit.runs if run.plan.setup is None or _rests(run)]
    data = _compared(fit.sheet, whole, fit.noise, fit.found.beam.rest)
    try:
        begun = replace(beginning(fit.sheet, whole, fit.stated), rest=fit.found.beam.rest)
        full = FullContender(begun, COARSE)
        # the fit has seen what is held out here, so a search goes on from it without that
        some = [run.run for run in data.fitted]
        values = _magnitudes(
            best_sheet(
                fit.found.beam, some, fit.noise, resolution=COARSE, tolerance=FOUND, near=True
            )
        )
        others = [PublishedContender(m) for n, m in models().items() if names is None or n in names]
        rows = compare_models(
            [full, *others],
            data,
            lambda one, _: values if one is full else None,
            progress or silent,
        )
    except ModelError as error:
        raise BadInputError(f"{fit.source}: {error}.") from None
    return DynamicComparison(
        configuration=fit.sheet.configuration, models=tuple(_kept(row) for row in rows),
        held_out=data.in_words, values=_values(data), rate_hz=RATE_HZ, missing=fit.missing,
    )  # fmt: skip


def _positions(session: RecordedSession, configuration: str) -> list[float]:
    """Return at most `MOST_POSITIONS` of the positions in contact, evenly chosen."""
    found = sorted({
        run.planned.position_m for run in session.runs
        if run.planned.configuration == configuration and run.planned.position_m is not None
    })  # fmt: skip
    count = min(len(found), MOST_POSITIONS)
    last = max(1, count - 1)
    return [found[round(i * (len(found) - 1) / last)] for i in range(count)]


def _full(
    record: MotionRecord, stated: StatedValues
) -> tuple[DynamicBeam, dict[str, float], HeldOut]:
    """Return the sheet to begin with, its parameters as they fit best, and the runs with its k0.

    The amplifier's offset bends the sheet at rest, so its k0 is known when its moment per volt is.
    """
    whole = [run for run in record.runs if run.plan.setup is None or _rests(run)]
    noise = noise_at_first(whole)
    begun = beginning(record.sheet, whole, stated)
    runs = [run.run for run in _compared(record.sheet, whole, noise, begun.rest).fitted]
    near = best_sheet(begun, runs, noise, resolution=COARSE, tolerance=NEAR)
    rest = rest_curvature(near, runs, noise.curve_m)
    if rest is not None:
        begun, near = replace(begun, rest=rest.rest), replace(near, rest=rest.rest)
    found = best_sheet(near, runs, noise, resolution=COARSE, tolerance=FOUND)
    return begun, _magnitudes(found), _compared(record.sheet, whole, noise, found.rest)


def _magnitudes(beam: DynamicBeam) -> dict[str, float]:
    """Return a sheet's parameters without signs, as `FullContender` takes them."""
    logarithms = LogParameters(beam)
    return {name: abs(v) for name, v in logarithms.values(logarithms.theta).items()}


def _rests(run: RecordedRun) -> bool:
    """Whether the load cell stays where it is."""
    return run.plan.setup is not None and not callable(run.plan.setup.position_m)


def _compared(
    sheet: SheetGeometry, runs: Sequence[RecordedRun], noise: RecordingNoise, rest: Field
) -> HeldOut:
    s_m = np.linspace(0.0, rest.length_m, REST_NODES)
    bent = replace(sheet, initial_curvature=(s_m, rest(s_m)))
    return hold_out([
        MeasuredRun(run=run, sheet=bent, noise=noise).thinned(RATE_HZ) for run in runs
    ])  # fmt: skip


def _values(data: HeldOut) -> dict[str, int]:
    found: dict[str, int] = {}
    for run in data.fitted:
        for quantity in run.measured:
            found[quantity] = found.get(quantity, 0) + run.count(quantity)
    return found


def _kept(row: ComparisonRow) -> ComparedModel:
    fitted = row.fitted
    if fitted is None:
        return ComparedModel(name=row.name, title=row.title, why_not=row.why)
    return ComparedModel(
        name=row.name, title=row.title, ln_evidence=row.ln_evidence,
        quantities={
            name: ComparedQuantity(
                rmse=score.rmse, share=score.share, ln_evidence=score.ln_evidence,
                misfit=fitted.misfit[name],
            )
            for name, score in row.scores.items()
        },
        parameters=fitted.values,
        undetermined=tuple(sorted({*fitted.values} - fitted.determined)),
    )  # fmt: skip
