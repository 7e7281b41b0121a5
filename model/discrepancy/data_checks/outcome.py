"""Report the data checks, as a part of a diagnosis or in its place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.discrepancy.data_checks.catalogue import origins
from model.discrepancy.data_checks.check import CheckedData
from model.discrepancy.verdict.result import BeforeAfter, Diagnosis, Gap, Signatures
from model.sheet.sheet_model import SheetModel


def contradiction(checked: CheckedData) -> str:
    """Return why nothing can be searched for, a sentence without its full stop."""
    reasons = "; ".join(one.sentence for one in checked.stops)
    return (
        "These data contradict what is stated of them, so nothing is searched for and there is no"
        f" model: {reasons}"
    )


def stopped(checked: CheckedData) -> Diagnosis:
    """Return the diagnosis of data that contradict what is stated of them: nothing is named.

    Its model has no configuration, since nothing was fitted.
    """
    nothing = Gap(force_rmse_mN=np.nan, curve_rmse_mm=np.nan, chi2_per_dof=np.nan)
    gap, empty = BeforeAfter(nothing, nothing), np.zeros((0, 0))
    measurements = checked.measurements
    return Diagnosis(
        verdict="cannot_tell",
        sentence=f"{contradiction(checked)}.",
        effects=(), invisible={}, unknown=None, where=(), fitted=gap, held_out=gap, closed=np.nan,
        next_measurement=None, ranking=(), threshold=np.inf,
        threshold_from="nothing was searched for",
        signatures=Signatures(names=(), detectability=np.zeros(0), distance=empty, cosine=empty),
        classes=(), rows=(), scatter={}, outliers=(), notes=checked.notes,
        model=SheetModel(sheets={}, source=measurements.source, checksum=measurements.checksum),
        data_checks=checked.suspicions,
    )  # fmt: skip


def with_checks(found: Diagnosis, checked: CheckedData) -> Diagnosis:
    """Return a diagnosis with what was suspicious about its data."""
    plugins = {**found.plugins, **origins()}
    notes = (*found.notes, *checked.notes)
    return replace(found, plugins=plugins, notes=notes, data_checks=checked.suspicions)
