"""`labrig.predict` and `labrig.simulate`: what a model says of the sheet at rest and in time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from labrig.api.arguments import Numbers, number, numbers, several, whole_number
from labrig.api.data import model_of, name_of, tell
from labrig.api.eibm import Eibm, model_with_eibm, voltages_of
from labrig.errors import BadArgumentError
from labrig.files import AnyPath, path_of
from labrig.one_blas_thread import one_blas_thread
from model import Prediction, PredictionArray, SheetModel
from model import predict as predict_one
from model.measurements import Displayed, Summary, dataframe, signed
from model.measurements.columns import of_rows
from model.measurements.known_arguments import known_arguments
from model.sheet.misfit import Misfit, misfit

if TYPE_CHECKING:
    import pandas as pd

    from labrig.motion.simulated import SimulatedRun


@dataclass(frozen=True, repr=False)
class SimulatedConditions(Displayed, Sequence[Prediction]):
    """The conditions that were asked for, in order, and the model that they are of."""

    conditions: tuple[Prediction, ...]
    model: SheetModel

    def __len__(self) -> int:
        """Return the number of conditions."""
        return len(self.conditions)

    @overload
    def __getitem__(self, index: int) -> Prediction: ...

    @overload
    def __getitem__(self, index: slice) -> SimulatedConditions: ...

    def __getitem__(self, index: int | slice) -> Prediction | SimulatedConditions:
        """Return a condition, or some of them."""
        if isinstance(index, slice):
            return SimulatedConditions(self.conditions[index], self.model)
        return self.conditions[index]

    def __iter__(self) -> Iterator[Prediction]:
        """Yield the conditions."""
        return iter(self.conditions)

    @property
    def errors(self) -> list[Misfit]:
        """How far the model is from the data that it was fitted to, by configuration."""
        names = dict.fromkeys(one.configuration for one in self.conditions)
        return [misfit(self.model, name) for name in names]

    def summary(self) -> Summary:
        """Return the table that `labrig simulate` prints."""
        columns = ("sheet", "p mm", "V", "F mN", "N mN", "contact at mm", "angle deg", "remark")
        forces_mN = [1e3 * force for one in self.conditions for force in (one.F_N, one.N_N)]
        rows = [_cells(one, forces_mN) for one in self.conditions]
        return Summary("SimulatedConditions", columns, rows)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each condition as a pandas data frame, in SI units."""
        names = (
            "configuration", "position_m", "voltage_V", "reachable", "why", "F_N", "N_N",
            "s_hat_m", "phi_hat_rad",
        )  # fmt: skip
        return dataframe(of_rows([{n: getattr(one, n) for n in names} for one in self.conditions]))

    def to_json(self) -> list[dict[str, Any]]:
        """Return the list that `labrig simulate --json` prints."""
        return [one.to_json() for one in self.conditions]


@overload
def predict(
    model: AnyPath | SheetModel, configuration: str, position_m: float, voltage_V: float
) -> Prediction: ...


@overload
def predict(
    model: AnyPath | SheetModel,
    configuration: str,
    position_m: npt.ArrayLike,
    voltage_V: npt.ArrayLike,
) -> PredictionArray: ...


@known_arguments
def predict(
    model: AnyPath | SheetModel,
    configuration: str,
    position_m: npt.ArrayLike,
    voltage_V: npt.ArrayLike,
) -> Prediction | PredictionArray:
    """Predict force and shape of a condition, or of arrays of conditions in one batch.

    Args:
        model: a model (or its file).
        configuration: name of one of its sheets.
        position_m: of the object along the arc, in m; a number or an array.
        voltage_V: in V, within the voltages of the model; a number or an array.

    Returns:
        Prediction for two numbers, else PredictionArray: the arrays are broadcast to one shape S.
        Forces `F_N`, `N_N`, contact `s_hat_m` and `phi_hat_rad` have shape S, the curves `x_m`,
        `y_m` and `curvature_per_m` have shape S + (points,). What is not reachable is NaN.

    Raises:
        ModelError: one sentence for an unknown configuration or voltage, and for what is no finite
            number, such as a masked one.
        BadInputError: one sentence for what is no model.

    Example:
        >>> import labrig, numpy as np
        >>> short = labrig.sheet(
        ...     free_length_mm=4.5, width_mm=11, thickness_mm=0.21, elongation_mm=40,
        ...     B_Nm2=0.85e-6, EIBM_Nm=60e-6,
        ... )
        >>> positions_m, voltages = np.linspace(0, 0.03, 4), np.array([-2.0, 0.0, 2.0])
        >>> found = labrig.predict(short, "sheet", positions_m[:, None], voltages)
        >>> found.F_N.shape, found.x_m.shape
        ((4, 3), (4, 3, 90))

    """
    return model_of(model).predict(configuration, position_m, voltage_V)


@known_arguments
@one_blas_thread
def simulate(
    model: AnyPath | SheetModel,
    *,
    position_mm: Numbers = (),
    voltage: Numbers = (),
    configuration: str | Sequence[str] = (),
    session: int = 0,
    eibm: Mapping[float, Eibm] | None = None,
) -> SimulatedConditions:
    """Predict force and shape for all combinations of what is given, as `labrig simulate` does.

    Args:
        model: a model (or its file).
        position_mm: along the arc, in mm; one or several.
        voltage: in V; one or several. Default with `eibm`: its voltages.
        configuration: one or several of the model's sheets; default: all.
        session: predict as in this one of the sessions diagnosed together; 0: as in their mean.
        eibm: EIBMs of one's own by voltage, in N m, in place of the model's: a number, a function
            of s in m, or a pair of rows (s in m, EIBM in N m).

    Returns:
        SimulatedConditions: a sequence of `Prediction`; an unreachable position is no error. For
        large arrays use `labrig.predict`, which solves them in one batch.

    Raises:
        LabrigError, ModelError: one sentence for a wrong argument.

    A model that misses its own data is named in a `LabrigWarning`.

    Example:
        >>> import labrig
        >>> long = labrig.sheet(
        ...     free_length_mm=50, width_mm=11, thickness_mm=0.21, B_Nm2=1.27e-6, EIBM_Nm=36e-6
        ... )
        >>> found = labrig.simulate(long, position_mm=[0, 10], voltage=2)
        >>> [round(1e3 * one.F_N, 2) for one in found]  # mN
        [1.34, 0.74]
        >>> mine = labrig.simulate(long, position_mm=0, eibm={2.0: lambda s: 80e-6 * (s < 0.01)})
        >>> mine[0].reachable
        True

    """
    positions = numbers("position_mm", position_mm)
    volts = numbers("voltage", voltage) or voltages_of(eibm)
    if not positions or not volts:
        raise BadArgumentError(
            "give at least one position_mm and one voltage.", "position_mm", "voltage"
        )
    session = whole_number("session", session, at_least=0)
    known = model_of(model)
    if session > known.sessions:
        many = f"more than {known.sessions} sessions" if known.sessions else "sessions"
        raise BadArgumentError(
            f"session {session}: {name_of(model)} has nothing that differs between {many}.",
            "session",
        )
    known = model_with_eibm(known.in_session(session), eibm)
    conditions = tuple(
        predict_one(known, name, 1e-3 * position, volts_V)
        for name in several(configuration) or known.sheets
        for position in positions
        for volts_V in volts
    )
    found = SimulatedConditions(conditions, known)
    tell_of_misses(found.errors)
    return found


def tell_of_misses(errors: Sequence[Misfit]) -> None:
    """Tell of each configuration whose model does not describe its own data."""
    for one in errors:
        if one.misses:
            better = f", {one.better_in_words}" if one.known_better else ""
            along = f"take fit --varying (EIBM along the sheet{better}) or diagnose -o."
            tell(
                f"warning: the model of '{one.configuration}' misses its own data by "
                f"{one.in_words} RMS; "
                + (along if one.constant else "labrig diagnose says what is missing.")
            )


@known_arguments
@one_blas_thread
def simulate_in_time(
    model: AnyPath,
    drive: AnyPath,
    *,
    configuration: str | None = None,
    position_mm: float | None = None,
    run: int | None = None,
    every_ms: float = 1.0,
    start_ms: float = 0.0,
) -> SimulatedRun:
    """Predict force, current and shape over time, as `labrig simulate --time` does.

    Args:
        model: a model file that holds the sheet in time (`labrig fit --dynamic` writes one).
        drive: protocol.toml, or a CSV table `time_s,voltage_V` that ends with the end of the run.
        configuration: one of the model's sheets; needed where several are known in time.
        position_mm: of the load cell along the arc, in mm; None: the sheet is free.
        run: that run of the protocol's schedule, counted from 1, at its own place.
        every_ms: between two rows, in ms.
        start_ms: the first row, in ms; the motion begins at 0.

    Returns:
        SimulatedRun: `motion` holds the arrays over time; `to_dataframe()` a row for each time.

    Raises:
        LabrigError: one sentence for a wrong argument, or a sheet that leaves the rolls.

    Example:
        >>> labrig.simulate_in_time("dynamic.toml", "protocol.toml")  # doctest: +SKIP

    """
    from labrig.motion.drive import load_drive
    from labrig.motion.simulated import OutputTimes, simulated_run

    times = OutputTimes(
        1e-3 * number("every_ms", every_ms, above=0.0),
        1e-3 * number("start_ms", start_ms, at_least=0.0),
    )
    at_m = None if position_mm is None else 1e-3 * number("position_mm", position_mm)
    if run is not None:
        run = whole_number("run", run, at_least=1)
    path: Path = path_of(model)
    found = simulated_run(path, load_drive(path_of(drive), run), times, configuration, at_m)
    if found.has_effects:
        tell(f"{path}: its effects act on the sheet at rest only, and are not in the motion.")
    return found


def _cells(found: Prediction, forces_mN: list[float]) -> tuple[str, ...]:
    from labrig.report.parts.table import decimals_for, fixed

    decimals = decimals_for(forces_mN, 3)

    return (
        found.configuration, f"{1e3 * found.position_m:g}", signed(found.voltage_V),
        fixed(1e3 * found.F_N, decimals), fixed(1e3 * found.N_N, decimals),
        fixed(1e3 * found.s_hat_m, 2),
        fixed(float(np.degrees(found.phi_hat_rad)), 2), found.why or "-",
    )  # fmt: skip
