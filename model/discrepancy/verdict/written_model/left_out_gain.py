"""Choose the inferred forms and parts of an unknown that improve left-out positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model.discrepancy.search.cross_validation import (
    left_out_rows,
    position_groups,
    when_left_out,
)
from model.discrepancy.search.form_share import in_time
from model.discrepancy.thresholds import (
    FEWEST_POSITIONS,
    FORM_GAIN_CHI2,
    LOSS_CHI2,
    SLOW_FORM_SHARE,
)
from model.discrepancy.verdict.prediction_error import cells, variance
from model.identification.data.data_vector import Index
from model.identification.likelihood.linearisation import with_only
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray


def forms_asked_for(known: MixedModelFit, final: MixedModelFit) -> bool:
    """Return whether mean forces and curves at left-out positions ask for the inferred forms.

    Between the positions a form is interpolated, and stays unless it clearly fails. One in time
    leads away from what was measured, since a prediction is one amid the session: it must gain a
    good part of what the catalogue's form leaves.
    """
    rows, noise = _left_out_means(final), variance(final)
    if len(position_groups(final)) < FEWEST_POSITIONS or not len(rows):
        return True
    pairs = zip(known.found, known.spans, strict=True)
    forms = [np.arange(span.start + len(one.parameters()), span.stop) for one, span in pairs]
    none = np.zeros(0, dtype=np.int64)
    own = np.concatenate([none, *forms])
    if not len(own):
        return True
    plain, formed = (_chi2(final, without, rows, noise) for without in (own, none))
    if any(in_time(one.effect) for one in known.found):
        return bool(plain - formed > max(FORM_GAIN_CHI2, SLOW_FORM_SHARE * plain))
    return bool(plain - formed > -FORM_GAIN_CHI2)


def predicts_better(base: MixedModelFit, reported: MixedModelFit) -> bool:
    """Return whether left-out positions are predicted no worse with what was found than without."""
    return _gain_in_means(base, reported) > -LOSS_CHI2


def means_ask_for(base: MixedModelFit, reported: MixedModelFit) -> bool:
    """Return whether left-out positions ask for what was found as clearly as a name is asked for.

    If not, as with a lag that looks like less EIBM, they do not know what it does to them.
    """
    return _gain_in_means(base, reported) >= FORM_GAIN_CHI2


def _gain_in_means(base: MixedModelFit, reported: MixedModelFit) -> float:
    """Return the fall of chi^2 of left-out mean forces and curves: a model file predicts these.

    Infinite where there are too few to tell.
    """
    noise = variance(reported)
    if len(position_groups(reported)) < FEWEST_POSITIONS or not len(_left_out_means(reported)):
        return np.inf
    return left_out_chi2(base, noise) - left_out_chi2(reported, noise)


def columns_asked_for(final: MixedModelFit, part_of: Sequence[str]) -> Index:
    """Return which columns of the free form, by number, belong to parts that gain something.

    `part_of` has the part of each one. All parts share one scale, so a part that explains much
    gives the others room to follow the noise, and a course in time takes up what goes with the
    place. Parts are left out in turn, as long as left-out positions are predicted as well.
    """
    kept, first = list(dict.fromkeys(part_of)), final.spans[-1].start
    every, noise = np.array(part_of), variance(final)
    if len(kept) < 2 or len(position_groups(final)) < FEWEST_POSITIONS:
        return np.arange(len(part_of))
    rows = left_out_rows(final)

    def chi2(parts: Sequence[str]) -> float:
        return _chi2(final, first + np.flatnonzero(~np.isin(every, parts)), rows, noise)

    least = chi2(kept)
    while len(kept) > 1:
        fewer = [[other for other in kept if other != part] for part in kept]
        found, some = min(((chi2(parts), parts) for parts in fewer), key=lambda one: one[0])
        if found > least + FORM_GAIN_CHI2:
            break
        kept, least = some, min(least, found)
    return np.flatnonzero(np.isin(every, kept))


def left_out_chi2(fitted: MixedModelFit, noise: FloatArray) -> float:
    """Return the squares of left-out mean forces and curves, in units of the noise (N,)."""
    return _chi2(fitted, np.zeros(0, dtype=np.int64), _left_out_means(fitted), noise)


def _left_out_means(fitted: MixedModelFit) -> Index:
    """Return the rows of mean forces and curves at positions, which are left out in turn."""
    where = cells(fitted)
    rows = np.concatenate([*where.force, *where.curve, np.zeros(0, dtype=np.int64)])
    return np.intersect1d(rows, left_out_rows(fitted))


def _chi2(fitted: MixedModelFit, without: Index, rows: Index, noise: FloatArray) -> float:
    """Return the squares of left-out rows, in units of the noise, without some columns."""
    keep = np.setdiff1d(np.arange(fitted.linear.columns.shape[1]), without)
    some = replace(fitted, linear=with_only(fitted.linear, keep))
    return float(np.sum(when_left_out(some)[rows] ** 2 / noise[rows]))
