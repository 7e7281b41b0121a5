"""The errors of a model file as it is, compared with the models that are fitted."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from labrig.errors import BadInputError
from model import Measurements, SheetModel
from model.identification.baselines import BaselineRow
from model.identification.observations import observe
from model.identification.residuals import against
from model.measurements import SheetGeometry, geometry_difference, rms


def model_rows(
    measurements: Measurements, model: SheetModel, label: str, names: list[str]
) -> Iterator[BaselineRow]:
    """Yield a row for each configuration that the model has; BadInputError for another sheet."""
    for name in names:
        if name not in model.sheets:
            continue
        sheet = model.sheets[name]
        _check_same(measurements.sheets[name], sheet.sheet, label)
        observed = observe(measurements, name)
        answers = against(observed, model)
        off = np.array(
            [o.force_N - a.force_N for o, a in zip(observed.observations, answers, strict=True)]
        )
        B = sheet.B.value
        bends = {v: sheet.mean_eibm(v) / B for v in sheet.eibm}
        curves = np.array([a.curve_m for a in answers])
        yield BaselineRow(
            configuration=name,
            model=label,
            B_Nm2=B,
            bend_per_m=bends,
            force_rmse_N=rms(off),
            curve_rmse_m=rms(curves),
        )


def _check_same(measured: SheetGeometry, known: SheetGeometry, label: str) -> None:
    unlike = geometry_difference(measured, known)
    if unlike is not None:
        raise BadInputError(
            f"{label}: was fitted to a '{known.configuration}' with a {unlike.measure} of "
            f"{unlike.second}, these data are of one with {unlike.first}."
        )
