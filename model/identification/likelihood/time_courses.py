"""What effects that go with time do to means, to parts of pulses, and to images.

Images may be late; free shapes have no readings, and count as they were when they were taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.model_state import ModelState
from model.identification.likelihood.row_index import RowBlock
from model.measurements import FloatArray
from model.sheet.effect_hooks import Acting, course, image_change, mean_course

Courses = tuple[FloatArray, FloatArray]  # relative change of EIBM and of stiffness


def in_means(configuration_model: ConfigurationModel, acting: Sequence[Acting]) -> Courses:
    """Return the change in the mean of each condition's readings, or in its free shape: (K,)."""
    clock, of, share = configuration_model.mean_times
    return mean_course(acting, clock, of, share, configuration_model.K)


def in_parts(block: RowBlock, one: Acting) -> tuple[Courses, Courses]:
    """Return the mean change over the pulses, in each part and at its sampling point: (b,).

    Where the form differs within the pulse it is the difference of the two that does.
    """
    form = one.form
    steady = one if form is None else replace(one, form=form.without("pulse"))
    result = []
    for clock in (block.bin_clock, block.bin_sample):
        found = course(steady, clock) or (np.zeros(clock.run_s.shape),) * 2
        result.append((block.bin_mean(found[0]), block.bin_mean(found[1])))
    within, sample = result
    if form is not None:
        factor = block.bin_mean(form.in_pulse(block.bin_clock))
        eibm, stiffness = (s + (w - s) * factor for w, s in zip(within, sample, strict=True))
        within = eibm, stiffness
    return within, sample


def of_free_shapes(configuration_model: ConfigurationModel, acting: Sequence[Acting]) -> FloatArray:
    """Return the relative change of Me/B that courses in time make to the free shapes: (K,)."""
    found = [course(one, configuration_model.unread_clock) for one in acting]
    changes = [eibm - stiffness for eibm, stiffness in (both for both in found if both is not None)]
    return _of_unread(
        configuration_model, np.sum([np.zeros(len(configuration_model.unread)), *changes], axis=0)
    )


def in_images(
    configuration_model: ConfigurationModel, acting: Sequence[Acting]
) -> tuple[FloatArray, FloatArray] | None:
    """Return the relative change of the EIBM in images: of readings (n,), of free shapes (K,)."""
    readings, shapes = (
        image_change(acting, configuration_model.clock),
        image_change(acting, configuration_model.unread_clock),
    )
    if readings is None or shapes is None:
        return None
    return readings, _of_unread(configuration_model, shapes)


def _of_unread(configuration_model: ConfigurationModel, values: FloatArray) -> FloatArray:
    """Values of the shapes without readings among all conditions; 0 elsewhere and at 0 V: (K,)."""
    result = np.zeros(configuration_model.K)
    result[configuration_model.unread] = np.where(
        configuration_model.voltage_V[configuration_model.unread] != 0.0, values, 0.0
    )
    return result


def bent(
    configuration_model: ConfigurationModel, state: ModelState, change: FloatArray
) -> FloatArray:
    """Return the step of the beam by a relative change of each condition's EIBM (K,): (K, Q)."""
    step = np.zeros((configuration_model.K, configuration_model.columns))
    step[:, : configuration_model.count] = change[:, None] * state.beam.eibm * state.beam.soft
    return step


def modes_in_images(
    configuration_model: ConfigurationModel, block: RowBlock, state: ModelState,
    seen: tuple[FloatArray, FloatArray],
) -> FloatArray:  # fmt: skip
    """Return the modes of the distances of the curves in late images, exactly: (K, M).

    `seen` is what `in_images` says of them.
    """
    change, beam = block.mean(seen[0]) + seen[1], state.beam
    late = replace(beam, eibm=beam.eibm * (1.0 + change[:, None]))
    return configuration_model.modes_of(late, state.solved.s_m)
