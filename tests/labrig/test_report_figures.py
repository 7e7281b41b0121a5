"""Figures as files: PDF with embedded fonts, SVG with real text, where and as they are wanted."""

from __future__ import annotations

import re
import zlib
from dataclasses import replace

import pytest

from labrig.cli.main import run
from labrig.report.figures.shapes import curves_figure
from labrig.report.parts.style import (
    MOST_VOLTAGES,
    colour_of,
    figure,
    label_of,
    legend_below,
    letter,
    save_all,
)
from tests.labrig.report_data import measure, session

pytestmark = pytest.mark.usefixtures("data_unchecked")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return session(tmp_path_factory.mktemp("figures") / "made.h5", measure("long"))


def names(folder):
    return {path.name for path in folder.iterdir()}


@pytest.mark.thorough
@pytest.mark.slow
def test_figures_are_written_as_pdf_and_svg_into_a_folder(recorded, tmp_path, request):
    figures = tmp_path / "for the thesis"
    out = ["-o", str(tmp_path / "out"), "--figures", str(figures)]
    assert run(["report", str(recorded), *out, "--format", "pdf", "--format", "svg"]) == 0
    assert {"figure-9.pdf", "figure-9.svg"} <= names(figures)
    assert not any(name.endswith((".png", ".part")) for name in names(figures))
    svg = (figures / "figure-9.svg").read_text(encoding="utf-8")
    assert re.search(r"<text[^>]*>position p \(mm\)</text>", svg)
    pdf = (figures / "figure-9.pdf").read_bytes()
    assert b"/FontFile2" in pdf  # TrueType, embedded
    assert b"/Type3" not in pdf
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "as PDF and SVG" in page
    request.getfixturevalue("words_only")  # what is drawn a second time is not looked at
    # another choice leaves no older files of the same figures behind
    assert run(["report", str(recorded), *out]) == 0
    assert "figure-9.svg" in names(figures)
    assert "figure-9.pdf" not in names(figures)


@pytest.mark.thorough
def test_the_text_of_a_pdf_is_text(recorded, tmp_path):
    assert run(["fit", str(recorded), "--figures", str(tmp_path), "--format", "pdf"]) == 0
    assert names(tmp_path) == {"figure-8.pdf", "figure-9.pdf"}
    data = (tmp_path / "figure-9.pdf").read_bytes()
    streams = re.findall(rb"stream\r?\n(.*?)endstream", data, re.DOTALL)
    texts = b""
    for one in streams:
        try:
            texts += zlib.decompress(one)
        except zlib.error:
            continue
    assert b"] TJ" in texts  # shown by the operators of text
    assert b"/ToUnicode" in data  # and found by a search


@pytest.mark.slow
def test_an_unknown_format_is_refused_before_anything_is_drawn(recorded, tmp_path, capsys):
    assert run(["report", str(recorded), "-o", str(tmp_path / "out"), "--format", "jpg"]) == 2
    assert "--format jpg: give png, svg or pdf." in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_figure_7_is_no_higher_than_its_curves_need():
    measured = measure("long")
    low = replace(measured, conditions=tuple(c for c in measured.conditions if not c.position_m))
    fig = curves_figure(low, ["long"])
    fig.draw_without_rendering()
    (panel,) = fig.axes
    assert panel.get_window_extent().height / fig.bbox.height > 0.3
    assert panel.get_tightbbox().y1 <= fig.bbox.y1 + 1


def test_no_text_of_a_panel_with_equal_scales_is_cut(tmp_path):
    with figure(5.4, 4.6) as fig:
        axes = fig.subplots()
        lines = [axes.plot([0, 62], [0, k], label=f"+{k} V")[0] for k in range(40, 45)]
        axes.set_aspect("equal")
        letter(axes, "a", "long sheet")
        axes.set_xlabel("x (mm)")
        legend_below(fig, lines)
        save_all(fig, tmp_path, "one", ("png",))
    fig.draw_without_rendering()
    assert axes.get_tightbbox().y1 <= fig.bbox.y1


def test_a_legend_of_two_rows_is_read_row_by_row():
    with figure(2.8, 2.0) as fig:
        axes = fig.subplots()
        legend_below(fig, [axes.plot([0, 1], label=name)[0] for name in "abc"])
        fig.draw_without_rendering()
    places = {text.get_text(): text.get_window_extent() for text in fig.legends[0].get_texts()}
    assert places["a"].y0 == pytest.approx(places["b"].y0, abs=2)
    assert places["a"].x0 < places["b"].x0
    assert places["c"].y0 < places["a"].y0 - 5


def test_a_figure_is_laid_out_once_for_all_its_files(tmp_path):
    with figure(1.4, 1.0) as fig:
        axes = fig.subplots()
        axes.set_ylabel("force (mN)\nof the sheet")  # begins outside, where nothing is laid out
    assert axes.yaxis.label.get_window_extent().x0 < 0
    save_all(fig, tmp_path, "one", ("svg", "png"))
    fig.draw_without_rendering()
    assert axes.yaxis.label.get_window_extent().x0 > 0
    assert fig.get_layout_engine() is None  # matplotlib would do so again for each file


def test_a_legend_of_a_hundred_voltages_names_a_few_and_leaves_room_for_its_figure():
    volts = [round(1.0 - 0.02 * k, 2) for k in range(101)]
    with figure(5.4, 3.9) as fig:
        axes = fig.subplots()
        handles = [axes.plot([0, 1], [0, v], label=label_of(v))[0] for v in volts]
        legend_below(fig, [*handles, axes.plot([0, 1], ls="--", label="constant EIBM")[0]])
        fig.draw_without_rendering()  # it warns where no room is left
    names = [text.get_text() for text in fig.legends[0].get_texts()]
    assert {label_of(1.0), label_of(-1.0), "constant EIBM"} <= set(names)
    assert len(names) == MOST_VOLTAGES + 1
    assert axes.get_window_extent().height > 0.4 * fig.bbox.height


def test_a_legend_with_long_names_stays_within_its_figure():
    from matplotlib.lines import Line2D

    names = [f"measured, {volts} V" for volts in ("+2", "0", "-2")] + ["before", "after"]
    with figure(5.4, 3.9) as fig:
        legend_below(fig, [Line2D([], [], marker="o", label=name) for name in names])
        fig.canvas.draw()
        place = fig.legends[0].get_window_extent()
    assert place.x0 >= 0
    assert place.x1 <= fig.bbox.x1


def test_two_voltages_of_one_sign_have_two_colours():
    among = (2.0, 1.0, 0.0, -1.0, -2.0)
    assert len({colour_of(volts, among) for volts in among}) == len(among)
    assert colour_of(2.0, among) == colour_of(2.0)
    assert colour_of(1.0, (1.0, -1.0)) == colour_of(1.0)
