"""`labrig.next_in_time`: which further run would determine what of the sheet in time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from labrig.analysis.motion.noise import noise_at_first, noise_of_residuals
from labrig.analysis.motion.proposals import Proposal, proposals
from labrig.api.data import model_of
from labrig.api.motion_data import MotionRequest, fits_of, records_of, request_of
from labrig.files import AnyPath, path_of
from labrig.one_blas_thread import one_blas_thread
from labrig.progress import Progress
from model import SheetModel
from model.dynamics import DynamicBeam
from model.dynamics.identification import RecordedRun, RecordingNoise
from model.measurements import Displayed, SheetGeometry, Summary, dataframe
from model.measurements.columns import of_rows
from model.measurements.known_arguments import known_arguments

if TYPE_CHECKING:
    import pandas as pd

_USUAL_FRAME_RATE_HZ = 25.0
Known = tuple[SheetGeometry, DynamicBeam, Sequence[RecordedRun], RecordingNoise]


@dataclass(frozen=True, kw_only=True, repr=False)
class NextRuns(Displayed):
    """For each sheet what is known now, and with each further run."""

    configurations: Mapping[str, Sequence[Proposal]]  # the first: what is known now

    def summary(self) -> Summary:
        """Return half the 90 % intervals in %, now and with each run."""
        from labrig.report.tables.in_time.proposals import next_table, next_text

        tables = [next_table(name, offered) for name, offered in self.configurations.items()]
        first = tables[0]
        rows = [row for table in tables for row in table.rows]
        sentences = [
            text for offered in self.configurations.values() for text in next_text(offered)
        ]
        return Summary(f"NextRuns: {first.title}", first.columns, rows, tuple(sentences))

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each run and parameter as a pandas data frame, in SI units."""
        return dataframe(of_rows([
            {"configuration": name, "run": each.name or "now", "protocol": each.key,
             "seconds": each.seconds, "parameter": one.name, "value": one.parameter.value,
             "sigma": one.parameter.sigma, "determined": one.determined}
            for name, offered in self.configurations.items()
            for each in offered for one in each.parameters
        ]))  # fmt: skip

    def to_json(self) -> dict[str, Any]:
        """Return the object that `labrig next --dynamic --json` prints."""
        from labrig.report.tables.in_time.proposals import proposals_json

        return {
            "configurations": {
                name: proposals_json(offered) for name, offered in self.configurations.items()
            }
        }


@known_arguments
@one_blas_thread
def next_in_time(
    sessions: AnyPath | Sequence[AnyPath],
    *,
    model: AnyPath | SheetModel | None = None,
    fluid: str = "air",
    elongation_g_per_m: float | None = None,
    progress: Progress | None = None,
) -> NextRuns:
    """Say which further run would determine what, as `labrig next --dynamic` does.

    Args:
        sessions: a session file, or several of the same sheet.
        model: a model (or its file) that knows the sheet in time; default: the sessions are fitted.
        fluid: what the sheet moves in: "air", "water" or "vacuum".
        elongation_g_per_m: mass of the rigid elongation per length, in g/m.
        progress: called with the share done (0 to 1) and a text.

    Returns:
        NextRuns: by configuration what is known now, and with a release, a chirp, a step of the
        load cell or another position: the 90 % interval expected of each parameter.

    Raises:
        LabrigError, ModelError: one sentence that names the missing data or the wrong argument.

    Example:
        >>> labrig.next_in_time("session.h5", model="dynamic.toml")  # doctest: +SKIP

    """
    from labrig.session import open_session

    request = request_of(sessions, (), (), fluid, elongation_g_per_m)
    with open_session(request.sessions[0]) as session:
        frame_rate_hz = session.schedule.frame_rate_hz or _USUAL_FRAME_RATE_HZ
    known = _fitted(request, progress) if model is None else _stated(request, model, progress)
    return NextRuns(
        configurations={name: proposals(*of, frame_rate_hz) for name, of in known.items()}
    )


def _fitted(request: MotionRequest, progress: Progress | None) -> dict[str, Known]:
    return {
        fit.sheet.configuration: (fit.sheet, fit.found.beam, fit.runs, fit.noise)
        for fit in fits_of(request, progress)
    }


def _stated(
    request: MotionRequest, model: AnyPath | SheetModel, progress: Progress | None
) -> dict[str, Known]:
    from labrig.model_file import moving_configuration

    known = model_of(model)
    shown = "the model" if isinstance(model, SheetModel) else path_of(model)
    name = moving_configuration(known, shown, None)
    runs = [run for record in records_of(request, name, progress) for run in record.runs]
    beam, _ = known.moving(name, None)
    noise = noise_of_residuals(beam, runs, noise_at_first(runs))  # as a fit has it at its end
    return {name: (known.sheet(name).sheet, beam, runs, noise)}
