"""What a model says of arrays of conditions, all of them solved in one batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from model.measurements import Displayed, FloatArray, ModelError, Summary, dataframe
from model.sheet.prediction import Predictable, Prediction, predict
from model.sheet.solution import sampled_s, solved

if TYPE_CHECKING:
    import pandas as pd

    from model.sheet.beam_problem import ConditionProblem

ROWS = 8  # of a summary: the first ones


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class PredictionArray(Displayed):
    """Conditions of one configuration, arrays of one shape S; NaN where they are not reachable.

    The shape of the sheet is computed when `x_m`, `y_m` or `curvature_per_m` is first asked for.
    `predictions[index]` is one condition as a `Prediction`, with what is remarkable about it.
    """

    model: Predictable
    configuration: str
    position_m: FloatArray  # S, along the arc
    voltage_V: FloatArray  # S
    reachable: npt.NDArray[np.bool_]  # S
    F_N: FloatArray  # S, along the arc's tangent
    N_N: FloatArray  # S, along the sheet's normal
    s_hat_m: FloatArray  # S, the contact, along the sheet
    phi_hat_rad: FloatArray  # S, direction of the sheet at the contact
    s_m: FloatArray  # (P,) points of the shapes, from the clamp to the visible end
    as_seen: bool
    problems: tuple[ConditionProblem, ...]  # of the conditions in their order, effects included

    @property
    def shape(self) -> tuple[int, ...]:
        """S."""
        return self.position_m.shape

    @property
    def x_m(self) -> FloatArray:
        """S + (P,), along the clamp's tangent."""
        return self._shapes[0]

    @property
    def y_m(self) -> FloatArray:
        """S + (P,), normal to it."""
        return self._shapes[1]

    @property
    def curvature_per_m(self) -> FloatArray:
        """S + (P,), curvature k(s)."""
        return self._shapes[2]

    def __getitem__(self, index: int | tuple[int, ...]) -> Prediction:
        """Return one condition with its remarks."""
        position_m, voltage_V = self.position_m[index], self.voltage_V[index]
        if np.ndim(position_m):
            raise ModelError(f"predictions of shape {self.shape} need an index for each axis")
        return predict(
            self.model, self.configuration, float(position_m), float(voltage_V),
            as_seen=self.as_seen,
        )  # fmt: skip

    def summary(self) -> Summary:
        """Return the first conditions."""
        columns = tuple(self._columns())
        cells = zip(*(np.ravel(values)[:ROWS] for values in self._columns().values()), strict=True)
        rows = [tuple(f"{value:.5g}" for value in row) for row in cells]
        lost = int(np.sum(~self.reachable))
        notes = [f"... {self.reachable.size} conditions in all"] * (self.reachable.size > ROWS)
        notes += [f"{lost} of them are not reachable"] * bool(lost)
        title = f"PredictionArray of {self.configuration}, shape {self.shape}"
        return Summary(title, columns, rows, tuple(notes))

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each condition as a pandas data frame, in SI units."""
        return dataframe({name: np.ravel(values) for name, values in self._columns().items()})

    def _columns(self) -> dict[str, Any]:
        names = ("position_m", "voltage_V", "F_N", "N_N", "s_hat_m", "phi_hat_rad", "reachable")
        return {name: getattr(self, name) for name in names}

    @cached_property
    def _shapes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        found = _shapes(self.model, self.problems, self.position_m.ravel(), as_seen=self.as_seen)
        shape = (*self.shape, len(self.s_m))
        x, y, curvature = (values.reshape(shape) for values in found)
        lost = ~self.reachable
        x[lost] = y[lost] = curvature[lost] = np.nan
        return x, y, curvature


def predict_array(
    model: Predictable,
    configuration: str,
    position_m: npt.ArrayLike,
    voltage_V: npt.ArrayLike,
    *,
    as_seen: bool = True,
) -> PredictionArray:
    """Predict conditions given as arrays that are broadcast; see `predict` for one of them.

    Raises ModelError where a position or a voltage is no finite number or is not known.
    """
    p, V = (np.asarray(values, dtype=np.float64) for values in (position_m, voltage_V))
    try:
        p, V = np.broadcast_arrays(p, V)
    except ValueError:
        raise ModelError(
            f"positions of shape {np.shape(position_m)} and voltages of shape"
            f" {np.shape(voltage_V)} cannot be broadcast; give, for all combinations,"
            " position_m[:, None] and voltage_V[None, :]"
        ) from None
    if not p.size:
        raise ModelError("give at least one position and one voltage")
    flat_p, flat_V = p.ravel().copy(), V.ravel().copy()
    setups: list[ConditionProblem] = [None] * p.size  # type: ignore[list-item]  # all are filled
    added_N = np.zeros(p.size)
    for voltage in np.unique(flat_V):
        rows = np.flatnonzero(flat_V == voltage)
        for row, setup in zip(
            rows, _setups(model, configuration, flat_p[rows], voltage), strict=True
        ):
            setups[row] = setup[0]
            if as_seen:
                added_N[row] = _load_cell_N(model, setup, float(flat_p[row]))
    found = solved(setups)
    return PredictionArray(
        model=model, configuration=configuration, position_m=flat_p.reshape(p.shape),
        voltage_V=flat_V.reshape(p.shape),
        reachable=found.reachable.reshape(p.shape),
        F_N=(found.force_N + added_N).reshape(p.shape), N_N=found.normal_N.reshape(p.shape),
        s_hat_m=found.s_hat_m.reshape(p.shape), phi_hat_rad=found.phi_hat_rad.reshape(p.shape),
        s_m=sampled_s(setups[0]), as_seen=as_seen, problems=tuple(setups),
    )  # fmt: skip


def _setups(
    model: Predictable, configuration: str, positions_m: FloatArray, voltage_V: float
) -> list[list[ConditionProblem]]:
    """Return for each position its beam problem, and those of the voltages it alternates with."""
    volts = (
        model.alternating_voltages_V(configuration, float(voltage_V))
        if model.effects
        else (float(voltage_V),)
    )
    made = model.setups(configuration, [(float(p), v) for v in volts for p in positions_m])
    count = len(positions_m)
    return [made[row::count] for row in range(count)]


def _load_cell_N(
    model: Predictable, setups: Sequence[ConditionProblem], position_m: float
) -> float:
    """Return what the load cell adds to the force of the first of the setups of a position."""
    from model.sheet.instruments import deceives_load_cell, load_cell_N

    if not deceives_load_cell(model.effects, setups[0].sheet.configuration):
        return 0.0
    rows = {one.voltage_V: row for row, one in enumerate(setups)}
    positions = [position_m] * len(setups)
    found = solved(setups)
    if not found.reachable[0]:
        return np.nan
    return load_cell_N(model.effects, found, positions, rows, setups[0].voltage_V)


def _shapes(
    model: Predictable,
    setups: Sequence[ConditionProblem],
    positions_m: FloatArray,
    *,
    as_seen: bool,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and curvature, a row for each setup."""
    s_m = sampled_s(setups[0])
    if not (model.effects and as_seen):
        one = solved(setups).shapes(s_m)
        return one.x_m, one.y_m, one.curvature_per_m
    from model.sheet.instruments import as_imaged, camera_m

    then = [
        as_imaged(setup, model.effects, float(p))
        for setup, p in zip(setups, positions_m, strict=True)
    ]
    found = solved(then)
    one = found.shapes(s_m)
    moved = [camera_m(model.effects, found, one, row) for row in range(len(setups))]
    dx, dy = (np.stack([each[axis] for each in moved]) for axis in (0, 1))
    return one.x_m + dx, one.y_m + dy, one.curvature_per_m
