"""The page of results, and the chart of all pages: what is drawn is what is in the file."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from labrig.analysis.results import result_of
from labrig.session import load_measurements
from tests.labrig.panel.page import panel
from tests.labrig.report_data import measure, session
from tests.panel_browser import every_page
from tests.panel_browser.conftest import text_of
from tests.panel_browser.rig_world import RigWorld, enter

NAME = "a.h5"


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    folder = tmp_path_factory.mktemp("result")
    measured = measure("long")
    first = measured.conditions[1]  # +2 V at the first position has a reading with a curve
    moved = replace(first.curve, y_m=first.curve.y_m + 1e-3)
    readings = (replace(first.readings[0], curve=moved), *first.readings[1:])
    conditions = (measured.conditions[0], replace(first, readings=readings))
    measured = replace(measured, conditions=(*conditions, *measured.conditions[2:]))
    session(folder / NAME, measured)
    with panel(None, "--data", str(folder)) as server:
        status, _ = server.ask("GET", f"/api/result?session={NAME}")  # fits now, not in each test
        assert status == 200
        yield RigWorld(server, folder)


@pytest.fixture
def page(world, visit):
    page = enter(visit, world, f"result?session={NAME}")
    page.wait_for_function("labrig.page?.result?.complete")
    page.wait_for_function("labrig.page.charts.slice(0, 2).every((one) => one.chart.uplot)")
    return page


def thick(page):
    """The chosen measured curve."""
    return page.evaluate("labrig.page.charts[0].chart.series.find((one) => one.width === 4)")


def shown(page, chart=1):
    return page.evaluate(f"labrig.page.charts[{chart}].chart.shown()")


def test_sliders_move_the_thick_curve_and_the_model_to_what_the_file_has(page, world):
    measured = load_measurements(world.folder / NAME)
    for key, position, voltage in (("End", 0.03, 2.0), ("Home", 0.0, 2.0)):
        page.get_by_label(re.compile("^position")).press(key)
        curve = next(
            c.curve
            for c in measured.conditions
            if (c.position_m, c.voltage_V) == (position, voltage)
        )
        drawn = np.array(thick(page)["points"])
        assert drawn[-1] == pytest.approx([1e3 * curve.x_m[-1], 1e3 * curve.y_m[-1]], abs=1e-3)
        model = page.evaluate("labrig.page.charts[0].chart.series.at(-1)")
        assert model["dashed"]
        assert len(model["band"]) == len(model["points"])
        assert ink_at(page, drawn[len(drawn) // 2])
    page.get_by_label(re.compile("^voltage")).press("Home")
    assert "−2 V" in thick(page)["name"]
    assert f"{1e3 * position:g} mm, −2 V" in text_of(page, ".result-sheet .keys")


def ink_at(page, point):
    """Whether something is drawn there: the canvas is transparent elsewhere."""
    return page.evaluate(
        """([x, y]) => {
          const { uplot } = labrig.page.charts[0].chart;
          const at = [uplot.valToPos(x, 'x', true), uplot.valToPos(y, 'y', true)];
          const [, , , alpha] = uplot.ctx.getImageData(...at.map(Math.round), 1, 1).data;
          return alpha > 200;
        }""",
        list(point),
    )


@pytest.mark.thorough
def test_the_curve_of_one_reading_is_drawn_when_its_time_is_chosen(page):
    before = np.array(thick(page)["points"])
    page.get_by_label(re.compile("^time")).press("ArrowRight")
    page.wait_for_function(
        "(y) => Math.abs(labrig.page.charts[0].chart.series"
        ".find((one) => one.width === 4).points.at(-1)[1] - y - 1) < 1e-3",
        arg=before[-1, 1],
    )
    page.get_by_label(re.compile("^position")).press("ArrowRight")  # which has none
    assert not page.get_by_label(re.compile("^time")).is_visible()


@pytest.mark.thorough
def test_the_cursor_reads_the_means_of_the_file(page, world):
    measured = load_measurements(world.folder / NAME)
    means = [
        1e3 * np.mean([r.force_N for r in c.used()])
        for c in sorted(measured.conditions, key=lambda c: c.position_m)
        if c.voltage_V == 2.0
    ]
    chart = page.get_by_role("application", name="force over position")
    chart.focus()
    read = page.locator(".chart", has=chart).locator(".chart-read")
    for _ in range(3):  # past the lines of the model
        chart.press("ArrowDown")
    for turn, mean in enumerate(means):
        if turn:
            chart.press("ArrowRight")
        assert f"F {mean:.3f} ±".replace("-", "−") in read.inner_text()
        assert read.inner_text().startswith("measured, +2 V")


@pytest.mark.thorough
def test_the_cursor_of_the_mouse_reads_the_nearest_point(page):
    x, y = page.evaluate(
        """() => {
          const { uplot } = labrig.page.charts[1].chart;
          const { x_mm, F_mN } = { x_mm: 10, F_mN: labrig.page.result.configurations[0].conditions
            .find((one) => one.position_mm === 10 && one.voltage_V === 0).force.mean_mN };
          const box = uplot.over.getBoundingClientRect();
          return [box.x + uplot.valToPos(x_mm, 'x'), box.y + uplot.valToPos(F_mN, 'y')];
        }"""
    )
    page.mouse.move(x + 2, y + 2)
    read = page.locator(".result-right .chart-read").first
    assert "p 10.00 mm" in read.inner_text()
    page.mouse.move(5, 5)
    assert read.text_content().startswith("Click, then wheel")
    assert not read.is_visible()


def test_a_chart_is_zoomed_panned_and_shown_whole_again(page):
    chart = page.get_by_role("application", name="force over position")
    box = chart.locator(".u-over").bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    whole = shown(page)
    page.mouse.move(*middle)
    page.mouse.wheel(0, -100)
    assert shown(page) == whole  # a wheel that passes by scrolls the page
    page.mouse.wheel(0, 100)
    page.mouse.click(*middle)
    page.mouse.wheel(0, -100)
    page.wait_for_function("labrig.page.charts[1].chart.view.x !== null")
    assert width(shown(page)) == pytest.approx(width(whole) / 1.25)
    page.mouse.dblclick(*middle)
    assert shown(page) == whole
    drag(page, middle, (100, 40))
    found = shown(page)
    assert width(found) == pytest.approx(width(whole) * 100 / box["width"], rel=0.03)
    page.keyboard.down("Shift")
    drag(page, middle, (-60, 0))
    page.keyboard.up("Shift")
    assert width(shown(page)) == pytest.approx(width(found))
    assert shown(page)["x"][0] > found["x"][0]
    chart.press("0")
    assert shown(page) == whole
    chart.press("+")
    assert width(shown(page)) == pytest.approx(width(whole) / 1.25)
    left = shown(page)["x"][0]
    chart.press("Shift+ArrowLeft")
    assert shown(page)["x"][0] < left
    page.locator(".result-right").get_by_role("button", name="show all").first.click()
    assert shown(page) == whole


def width(ranges):
    return ranges["x"][1] - ranges["x"][0]


def drag(page, start, by):
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(start[0] + by[0] / 2, start[1] + by[1] / 2)
    page.mouse.move(start[0] + by[0], start[1] + by[1])
    page.mouse.up()


@pytest.mark.thorough
def test_a_millimetre_of_the_sheet_is_as_long_along_x_as_along_y_even_zoomed(page):
    for key in ("0", "+", "+"):
        page.get_by_role("application", name="the sheet, in millimetres").press(key)
        ranges = shown(page, 0)
        box = page.locator(".chart-sheet .u-over").bounding_box()
        per_px = [
            (ranges[axis][1] - ranges[axis][0]) / box[side]
            for axis, side in (("x", "width"), ("y", "height"))
        ]
        assert per_px[0] == pytest.approx(per_px[1], rel=0.01)


@pytest.mark.thorough
def test_intervals_of_b_and_eibm_narrow_as_positions_are_added(page):
    drawn = page.evaluate(
        "[...labrig.page.charts[2].charts].map(([name, one]) => [name, one.series[0].points])"
    )
    assert [name for name, _ in drawn] == ["B", "EIBM at +2 V", "EIBM at −2 V"]
    for _, points in drawn:
        assert [one[0] for one in points] == [1, 2, 3, 4]
        assert points[-1][2] < points[0][2]
    parameters = page.evaluate("labrig.page.result.configurations[0].parameters.constant")
    assert drawn[0][1][-1][1] == pytest.approx(parameters["B_uNm2"]["value"])
    assert "bending stiffness B" in text_of(page, ".result-words")


@pytest.mark.thorough
def test_what_is_not_there_yet_is_told_and_the_report_opens_once_it_is_written(page, world):
    assert "There is no a.report.html yet" in text_of(page, ".result-do")
    (world.folder / "a.report.html").write_text("<style>h1 {color: red}</style><h1>Report</h1>")
    page.reload()
    with page.expect_popup() as opened:
        page.get_by_role("link", name="Full report").click()
    assert opened.value.inner_text("h1") == "Report"
    red = "getComputedStyle(document.querySelector('h1')).color"
    assert opened.value.evaluate(red) == "rgb(255, 0, 0)"
    (world.folder / "a.report.html").unlink()


def test_the_page_is_reached_from_the_library_and_from_the_session(world, visit):
    page = enter(visit, world, "library")
    page.get_by_role("link", name="result", exact=True).click()
    page.wait_for_function("labrig.page?.result")
    page.get_by_role("link", name=NAME).click()
    page.get_by_role("link", name="Result", exact=True).click()
    page.wait_for_selector(".result-sheet canvas")


def test_the_result_grows_with_each_position_of_the_run(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.get_by_role("link", name="The result so far").click()
    page.locator(".result-said").filter(has_text="grows with each position").wait_for()
    measured = measure("long")
    for positions in (1, 2):
        so_far = replace(measured, conditions=measured.conditions[: 3 * positions])
        steps = [
            {"positions": n + 1, "position_mm": 10.0 * n, "conditions": 3 * n + 3,
             "B_uNm2": {"value": 1.3, "sigma": 0.1, "interval90": [1.1, 1.5]}, "EIBM_uNm": {},
             "why": ""}
            for n in range(positions)
        ]  # fmt: skip
        grown = result_of(so_far, session="made-up.h5", convergence={"long": steps})
        fake.tell({"type": "result", "session": "made-up.h5", **grown})
        page.wait_for_function(
            "(n) => labrig.page.charts[2].charts.get('B')?.series[0].points.length === n",
            arg=positions,
        )
        assert f"position {10 * positions - 10} mm" in text_of(page, ".result-choice")
        assert f"After {positions} position" in text_of(page, ".result-right")
        assert "B 1.30 µN·m², 90 %: 1.10 to 1.50." in text_of(page, ".result-right")
        assert not page.get_by_role("link", name="Full report").is_visible()
    missing = [{"kind": "analyze", "text": "It is the live fit."}, {"kind": "report", "text": ""}]
    late = {**grown, "missing": missing, "complete": True, "live": True}
    late["convergence"] = {"long": [*steps, {**steps[-1], "positions": 3, "conditions": 9}]}
    fake.answers["GET", "/api/result"] = late
    job = {"type": "job", "kind": "run", "id": "j", "session": "made-up.h5", "text": ""}
    ended = {
        "type": "ended",
        "time_s": 900.0,
        "outcome": "completed",
        "reason": "",
        "output": "safe",
    }
    fake.tell(
        ended, {**job, "state": "ended", "code": 0}, {"type": "result", "session": "made-up.h5"}
    )
    page.get_by_text("After 3 positions: B").wait_for()  # of a run that was faster than the fit
    assert "It is the live fit." in text_of(page, ".result-do")


@pytest.mark.thorough
def test_the_result_shows_the_newest_position_unless_another_one_was_chosen(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.get_by_role("link", name="The result so far").click()
    page.locator(".result-said").filter(has_text="grows with each position").wait_for()
    measured = {name: measure(name) for name in ("long", "short")}
    both = replace(
        measured["long"],
        sheets={name: one.sheets[name] for name, one in measured.items()},
        conditions=(*measured["long"].conditions[:6], *measured["short"].conditions[:6]),
    )

    def tell(conditions, **positions):
        steps = {
            name: [{"positions": n, "position_mm": 10.0 * (n - 1), "conditions": conditions,
                    "B_uNm2": None, "EIBM_uNm": {}, "why": ""}]
            for name, n in positions.items()
        }  # fmt: skip
        so_far = replace(both, conditions=both.conditions[:conditions])
        grown = result_of(so_far, session="made-up.h5", convergence=steps)
        fake.tell({"type": "result", "session": "made-up.h5", **grown})
        page.wait_for_function(
            "(n) => labrig.page.result?.configurations.flatMap((c) => c.conditions).length === n",
            arg=conditions,
        )
        return text_of(page, ".result-choice output")

    def sheet():
        return page.evaluate("labrig.page.choice.chosen.configuration")

    assert tell(6, long=2) == "10 mm"
    page.get_by_label(re.compile("^position")).press("Home")
    assert tell(9, long=2, short=1) == "0 mm"
    assert sheet() == "long"
    page.get_by_label(re.compile("^position")).press("End")
    page.evaluate("labrig.page.choice.choose({ configuration: 'short', setup: 0 })")
    assert tell(12, long=2, short=2) == "10 mm"
    assert sheet() == "short"


@pytest.mark.thorough
def test_of_a_session_that_is_not_analysed_no_curve_is_said_to_be_lacking(full, visit):
    long, short = (dict(one) for one in every_page.result()["configurations"])
    long["conditions"] = [{**one, "curve": None} for one in long["conditions"]]
    told = {**every_page.result(), "configurations": [long, short]}
    full.answers["GET", "/api/result"] = told
    page = visit(f"{full.url}#/result?session=a.h5")
    page.locator(".result-sheet").get_by_text("no curve was found here").wait_for()
    told["missing"] = [{"kind": "analyze", "text": "It is not analysed yet."}]
    page.reload()
    page.locator(".result-sheet").get_by_text("Analyse looks for the curves").wait_for()
    assert "no curve was found" not in text_of(page, ".result-sheet")
    # the long sheet was measured first, and both are fitted together
    later = "The parameters below take in what was measured after that, too."
    assert later in text_of(page, ".result-right")
    page.get_by_label("sheet", exact=True).select_option("short")
    assert later not in text_of(page, ".result-right")
    keys = [".result-sheet .line-key", ".result-right .line-key"]  # of +2 V, as they are drawn
    colours = [
        page.locator(one).first.evaluate("(key) => getComputedStyle(key).color") for one in keys
    ]
    assert colours[0] == colours[1]
    told["configurations"] = [short]  # without a choice of sheets there is room for the others
    page.reload()
    position = page.locator(".choose label", has_text="position")
    position.wait_for()
    assert position.evaluate("(label) => label.scrollWidth <= label.clientWidth")


@pytest.mark.thorough
def test_the_strip_charts_are_zoomed_together_and_read_with_a_cursor(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_function("labrig.page?.view.strips.points > 0")
    page.wait_for_function("labrig.page.view.strips.lines.every((line) => line.plot)")
    force = page.get_by_role("application", name="Force in mN")
    force.focus()
    force.press("ArrowLeft")  # the newest moment
    newest = page.evaluate("labrig.job.signals.newest('force_mN')")
    text = text_of(page, ".strips .chart-read")
    assert f"force {newest:.3f} mN".replace("-", "−") in text
    assert "drive" in text
    assert "current" in text
    whole = page.evaluate("labrig.page.view.strips.window()")
    force.press("+")
    inner = page.evaluate(
        "labrig.page.view.strips.lines.map(({plot}) => [plot.scales.x.min, plot.scales.x.max])"
    )
    assert inner[0] == inner[1] == inner[2]
    assert inner[0][1] - inner[0][0] == pytest.approx((whole[1] - whole[0]) / 1.25)
    page.locator(".strips").get_by_role("button", name="show all").click()
    assert page.evaluate("labrig.page.view.strips.window()") == whole
