"""`labrig.plot`: matplotlib axes for scripts and notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import labrig
from labrig.errors import BadInputError
from model.dynamics import SheetMotion
from tests.labrig.report_data import VOLTAGES, measure, truth

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@pytest.fixture(autouse=True)
def no_window(monkeypatch):
    """pyplot draws into memory, and its figures are closed."""
    from matplotlib import pyplot as plt

    plt.switch_backend("agg")
    yield
    plt.close("all")


@pytest.fixture
def axes() -> Axes:
    from matplotlib.figure import Figure  # slow to import

    return Figure().subplots()


def lines_of(axes: Axes) -> dict[str, np.ndarray]:
    return {str(line.get_label()): line.get_xydata() for line in axes.get_lines()}


@pytest.mark.slow
def test_forces_are_drawn_in_mN_with_the_models_lines(axes):
    measured = measure("long", "short")
    drawn = labrig.plot.forces(measured, truth("long", "short"), configuration="long", ax=axes)
    assert drawn is axes
    assert axes.get_ylabel() == "force F (mN)"
    dashed = [line for line in axes.get_lines() if len(line.get_xdata()) > 20]
    assert len(dashed) == len(VOLTAGES)
    at_10_mm = np.interp(10.0, *dashed[0].get_xydata().T)
    force_mN = 1e3 * truth("long").predict("long", 0.01, max(VOLTAGES)).F_N
    assert at_10_mm == pytest.approx(force_mN, rel=1e-3)


def test_a_model_with_a_constant_eibm_is_dashed_as_that_of_a_fit_is(axes):
    numbers = {"free_length_mm": 50, "width_mm": 11, "thickness_mm": 0.21, "B_Nm2": 1.27e-6}
    falling = ([0.0, 0.05], [60e-6, 10e-6])
    for eibm, style in ((36e-6, "--"), (falling, "-")):
        model = labrig.sheet(**numbers, EIBM_Nm=eibm, name="long")
        axes.clear()
        labrig.plot.forces(measure("long"), model, ax=axes)
        simulated = [line for line in axes.get_lines() if len(line.get_xdata()) > 20]
        assert {line.get_linestyle() for line in simulated} == {style}


def test_the_eibm_of_a_model_is_drawn_along_the_whole_sheet(axes):
    constant = labrig.sheet(
        free_length_mm=50, width_mm=11, thickness_mm=0.21, B_Nm2=1.27e-6, EIBM_Nm=36e-6
    )
    labrig.plot.eibm(constant, ax=axes)
    assert lines_of(axes)["+2 V"].tolist() == [[0.0, 36.0], [50.0, 36.0]]


@pytest.mark.slow
def test_curves_and_shapes_have_equal_aspect(axes):
    labrig.plot.curves(measure("long"), ax=axes)
    assert axes.get_aspect() == 1.0
    model = truth("long")
    found = labrig.simulate(model, position_mm=[0, 20, 100], voltage=[2, -2])
    other = labrig.plot.shapes(found, model)
    assert other.get_aspect() == 1.0
    assert {"+2 V", "−2 V"} <= set(lines_of(other))


def test_a_new_figure_leaves_the_settings_of_matplotlib_as_they_are():
    import matplotlib as mpl
    from matplotlib.axes import Axes

    before = mpl.rcParams["axes.grid"]
    made = labrig.plot.eibm(truth("long"))
    assert isinstance(made, Axes)
    assert mpl.rcParams["axes.grid"] == before


def test_a_motion_is_drawn_over_time(axes):
    time_s = np.linspace(0.0, 1.0, 5)
    zero, shape = np.zeros(5), np.zeros((5, 3))
    moved = SheetMotion(
        time_s=time_s, drive_V=zero, sheet_V=zero, current_A=zero, force_N=1e-3 * time_s,
        reading_N=zero, normal_N=zero, s_hat_m=zero, phi_hat_rad=zero, s_m=np.zeros(3), x_m=shape,
        y_m=shape + 0.002, phi_rad=shape, curvature_per_m=shape,
    )  # fmt: skip
    labrig.plot.motion(moved, ax=axes)
    assert axes.get_lines()[0].get_ydata().tolist() == pytest.approx(time_s.tolist())
    tip = labrig.plot.motion(moved, "tip_y_m")
    assert tip.get_lines()[0].get_ydata().tolist() == pytest.approx([2.0] * 5)
    assert moved.to_dataframe().tip_y_m.tolist() == pytest.approx([0.002] * 5)
    assert len(repr(moved).splitlines()) < 24
    with pytest.raises(BadInputError, match="a motion has no 'colour'"):
        labrig.plot.motion(moved, "colour")


def test_a_configuration_is_asked_for_where_there_are_several(axes):
    both = measure("long", "short")
    with pytest.raises(BadInputError, match="give configuration=one of long, short"):
        labrig.plot.forces(both, ax=axes)
    with pytest.raises(BadInputError, match="there is no 'wide'; one of long, short"):
        labrig.plot.curves(both, configuration="wide", ax=axes)


def test_shapes_are_of_one_configuration_and_of_one_at_least(axes):
    model = truth("long", "short")
    with pytest.raises(BadInputError, match=r"^there is no prediction to draw\.$"):
        labrig.plot.shapes([], model, ax=axes)
    found = labrig.simulate(model, position_mm=0, voltage=2)
    said = r"^the predictions are of long, short; draw those of one configuration\.$"
    with pytest.raises(BadInputError, match=said):
        labrig.plot.shapes(found, model, ax=axes)
