"""Of a waveform's dozens of voltages the search takes a few; what was set stays as it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model import Condition, Measurements, Reading, SheetGeometry
from model.discrepancy.data_checks.check import check_data
from model.discrepancy.data_checks.few_voltages import MOST_VOLTAGES, with_few_voltages

SHEET = SheetGeometry(
    configuration="long", free_length_m=0.05, width_m=0.011, thickness_m=0.21e-3,
    elongation_m=0.01, arc_radius_m=0.05, arc_origin_rad=0.0, initial_curvature=None,
)  # fmt: skip


def measured(volts, positions_m=(0.005, 0.01, 0.015)) -> Measurements:
    conditions = tuple(
        Condition(
            configuration="long", position_m=position_m, voltage_V=float(voltage_V),
            readings=(Reading(index=0, kind="kept", force_N=1e-3 * float(voltage_V)),),
        )
        for position_m in positions_m
        for voltage_V in volts
    )  # fmt: skip
    return Measurements(sheets={"long": SHEET}, conditions=conditions)


def voltages(data: Measurements) -> list[float]:
    return sorted({c.voltage_V for c in data.conditions})


def test_a_sweep_is_searched_at_a_few_of_its_voltages_its_largest_among_them():
    volts = [0.0, *np.linspace(-1.0, 1.0, 40)]
    few, told = with_few_voltages(measured(volts))
    kept = voltages(few)
    assert len(kept) == MOST_VOLTAGES + 1
    assert (kept[0], kept[-1]) == (-1.0, 1.0)
    assert 0.0 in kept
    assert np.max(np.diff(kept)) < 0.25
    assert [text.split(";")[0] for text in told] == ["'long' was measured at 40 voltages"]


def test_no_protocol_of_a_dozen_voltages_loses_one():
    data = measured([0.0, *np.linspace(-2.0, 2.0, MOST_VOLTAGES)])
    assert with_few_voltages(data) == (data, ())


def test_voltages_that_were_measured_and_not_set_are_all_needed():
    volts = 2.0 + 0.001 * np.arange(30)
    data = measured(volts[:1], positions_m=(0.001,))
    one_each = replace(
        data, conditions=tuple(replace(data.conditions[0], voltage_V=float(v)) for v in volts)
    )
    assert with_few_voltages(one_each) == (one_each, ())


def test_data_checks_tell_of_it():
    checked = check_data(measured([0.0, *np.linspace(-1.0, 1.0, 40)]))
    assert len(voltages(checked.measurements)) == MOST_VOLTAGES + 1
    assert any("the search takes 12 of them" in note for note in checked.notes)
