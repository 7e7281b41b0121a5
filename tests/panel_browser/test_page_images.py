"""Images on the page: acknowledged when they are drawn, with their age, rate and prediction."""

from __future__ import annotations

import time
from itertools import pairwise

import pytest

from tests.panel_browser import fake_panel, made_up
from tests.panel_browser.conftest import text_of

COME = "(n) => labrig.page?.view?.picture.header?.frame === n"


def opened(fake, visit, where="run"):
    page = visit(f"{fake.url}#/{where}")
    page.wait_for_selector(f"main.page-{where}")
    return page


def drawn(fake, page, number, **more):
    """Show an image, and wait until it is on the canvas."""
    fake.tell(fake_panel.picture_frame(number, 2.0, **more))
    page.wait_for_function(COME, arg=number)
    page.wait_for_function("labrig.page.view.picture.drawn === labrig.page.view.picture.header")


def test_each_image_is_acknowledged_once_when_it_is_drawn(fake, visit):
    page = opened(fake, visit)
    page.wait_for_function("labrig.page?.view.picture.shown === 1")
    for number in range(301, 306):
        drawn(fake, page, number)
    page.wait_for_timeout(100)
    assert fake.seen == [300, 301, 302, 303, 304, 305]


@pytest.mark.thorough
def test_a_page_without_a_picture_acknowledges_none_until_it_shows_one(fake, visit):
    page = opened(fake, visit, "log")
    page.wait_for_function("labrig.job.picture?.frame === 300")
    page.wait_for_timeout(300)  # for an acknowledgement that must not come
    assert fake.seen == []
    page.goto(f"{fake.url}#/run")
    page.wait_for_function("labrig.page?.view?.picture.shown === 1")
    page.wait_for_timeout(100)
    assert fake.seen == [300]


def test_an_image_that_cannot_be_decoded_is_said_so_and_does_not_end_the_stream(fake, visit):
    page = opened(fake, visit)
    page.wait_for_function("labrig.page?.view.picture.shown === 1")
    header = {"type": "picture", "frame": 301, "image": 301, "mime": "image/jpeg"}
    fake.tell(made_up.binary(header, b"no image"))
    page.wait_for_function(
        "document.querySelector('.picture-said').innerText.includes('301 cannot be read')"
    )
    drawn(fake, page, 302)
    assert fake.seen == [300, 301, 302]


@pytest.mark.thorough
def test_an_image_that_a_story_makes_pointless_is_acknowledged_all_the_same(fake, visit):
    page = opened(fake, visit, "log")
    page.wait_for_function("labrig.job.picture?.frame === 300")
    fake.tell({"type": "story", "messages": made_up.story()})
    page.wait_for_function("labrig.job.picture === null")
    page.wait_for_timeout(100)
    assert fake.seen == [300]


@pytest.mark.parametrize(
    "ahead_s", [-250.0, *(pytest.param(s, marks=pytest.mark.thorough) for s in (0.0, 3600.0))]
)
def test_the_page_says_how_old_the_image_is_by_the_servers_clock(fake, visit, ahead_s):
    fake.ahead_s = ahead_s
    page = opened(fake, visit)
    page.wait_for_function("labrig.job.clock.now_s() !== null")
    exposed_s = time.time() - 0.3
    drawn(fake, page, 301, exposed_s=exposed_s + ahead_s)
    age_s = page.evaluate("labrig.job.ageOf(labrig.job.picture)")
    trip_s = page.evaluate("Math.min(...labrig.job.clock.pings.map((ping) => ping.trip_s))")
    assert 0.3 - trip_s <= age_s <= time.time() - exposed_s + trip_s
    drawn(fake, page, 302, exposed_s=time.time() + ahead_s - 60)
    said = "document.querySelector('.picture-age')"
    page.wait_for_function(f"/^6\\d s old$/.test({said}.innerText)")
    assert page.evaluate(f"{said}.dataset.stale") == "true"


def test_the_age_of_the_image_is_right_soon_after_the_servers_clock_was_set(fake, visit):
    page = opened(fake, visit)
    page.wait_for_function("labrig.job.clock.now_s() !== null")
    page.evaluate("labrig.job.clock.pings.forEach((ping) => { ping.trip_s = 0; })")  # the quickest
    fake.ahead_s = -3600.0
    drawn(fake, page, 301, exposed_s=time.time() - 3600.0)
    page.wait_for_function("labrig.job.ageOf(labrig.job.picture) < 60", timeout=10_000)


@pytest.mark.thorough
def test_the_page_says_at_what_rate_images_come(fake, visit):
    page = opened(fake, visit)
    page.wait_for_function("labrig.job.clock.now_s() !== null")
    for number in range(301, 331):
        drawn(fake, page, number, exposed_s=time.time())
    said = "document.querySelector('.picture-age').innerText"
    page.wait_for_function(f"/images\\/s, \\d\\.\\d+ s old/.test({said})")
    found = page.evaluate("labrig.page.view.picture.rate.hz(performance.now())")
    assert 1 < found < 61


@pytest.mark.thorough
def test_the_prediction_is_seen_over_the_sheet_and_its_error_is_a_number(fake, visit):
    page = opened(fake, visit)
    at_rest = {**made_up.motion(300, 2.0), "shape": None}  # no model of the sheet in time
    fake.tell(at_rest, fake_panel.picture_frame(301, 2.0), fake_panel.curve(301, 2.0))
    page.wait_for_function(
        "document.querySelector('.picture-error').innerText.includes('0.31 mm RMS distance')"
    )
    assert "force \u22120.14 mN at +2 V" in text_of(page, ".picture-error")
    page.wait_for_function("labrig.page.view.picture.drawn.frame === 301")
    shares = page.evaluate(
        """(points) => {
          const picture = labrig.page.view.picture;
          const kinds = { dash: 0, other: 0 };
          const between = (a, b, share) => a.map((from, j) => from + share * (b[j] - from));
          for (let i = 0; i + 1 < points.length; i += 1) for (let k = 0; k < 8; k += 1) {
            const at = between(points[i], points[i + 1], k / 8);
            const [x, y] = picture.toScreen(at).map(Math.round);
            const [r, g, b] = picture.context.getImageData(x, y, 1, 1).data;
            if (r > 200 && g < 140 && b > 180) kinds.dash += 1;
            else kinds.other += 1;
          }
          return kinds;
        }""",
        made_up.curve_px(2.0 * 0.85),
    )
    share = shares["dash"] / sum(shares.values())
    assert 0.35 < share < 0.7, shares  # dashes, and gaps through which the sheet is seen


@pytest.mark.thorough
@pytest.mark.parametrize("width", [390, 1920, pytest.param(1024, marks=pytest.mark.thorough)])
def test_lines_over_the_image_are_as_wide_as_the_image_allows(fake, visit, width):
    page = visit(f"{fake.url}#/run", width, 900)
    page.wait_for_function("labrig.page?.view.picture.shown === 1")
    widths = page.evaluate(
        """async () => {
          const overlay = await import("/static/js/live/overlay.js");
          const { canvas } = labrig.page.view.picture;
          const found = [];
          const context = new Proxy({}, {
            get: () => () => {},
            set: (_, name, value) => (name === "lineWidth" && found.push(value), true),
          });
          overlay.drawPrediction(context, [[0, 0], [1, 1]], canvas.width, 1);
          overlay.drawCurve(context, [[0, 0], [1, 1]], canvas.width, 1);
          return found;
        }"""
    )
    rim, prediction, _, measured = widths
    assert rim > prediction > 1.5 * measured > 1.5
    assert prediction < 0.02 * page.evaluate("labrig.page.view.picture.canvas.width") + 3


@pytest.mark.thorough
def test_all_that_is_drawn_shares_the_frames_of_the_browser(fake, visit):
    page = opened(fake, visit)
    page.wait_for_function("labrig.page?.view.picture.shown === 1")
    found = page.evaluate(
        """async () => {
          const { nextFrame } = await import("/static/js/frames.js");
          const calls = [];
          const frames = new Set();
          let frame = 0;
          const count = () => { frame += 1; requestAnimationFrame(count); };
          requestAnimationFrame(count);
          const work = (name) => () => { calls.push(name); frames.add(frame); };
          const [a, b, late] = ["a", "b", "late"].map(work);
          const fails = () => { throw new Error("a fault of one"); };
          const asks = () => { nextFrame(late); nextFrame(a); };
          const quiet = (event) => event.preventDefault();
          addEventListener("error", quiet);
          for (let i = 0; i < 10; i += 1) for (const one of [a, fails, asks, b]) nextFrame(one);
          await new Promise((go) => setTimeout(go, 20));
          await new Promise((go) => requestAnimationFrame(() => setTimeout(go, 0)));
          while (calls.length < 4) await new Promise(requestAnimationFrame);
          return [calls.slice(0, 4), calls.length];
        }"""
    )
    assert found[0] == ["a", "b", "late", "a"], found  # `a` again: in the tick after


@pytest.mark.thorough
def test_traces_give_way_to_images_where_the_browser_does_not_keep_up(fake, visit):
    page = opened(fake, visit)
    page.wait_for_function("labrig.page?.view.strips.points > 0")
    for number in range(300, 460, 8):  # seven of eight frames are missed
        drawn(fake, page, number, exposed_s=1.0)
    at_once, later = page.evaluate(
        """async () => {
          const strips = labrig.page.view.strips;
          let shown = 0;
          const show = strips.show.bind(strips);
          strips.show = () => { shown += 1; show(); };
          strips.show();
          for (let i = 0; i < 5; i += 1) strips.update(new Set(["signals"]));
          const atOnce = shown - 1;
          const end = performance.now() + 10000;
          const pause = () => new Promise((go) => setTimeout(go, 50));
          while (shown < 2 && performance.now() < end) await pause();
          return [atOnce, shown - 1];
        }"""
    )
    assert at_once == 0
    assert later == 1  # what came last is drawn all the same


def test_no_spike_is_lost_in_a_column_of_the_chart(fake, visit):
    page = opened(fake, visit)
    found = page.evaluate(
        """async () => {
          const { columns } = await import("/static/js/live/envelope.js");
          const times = Float64Array.from({ length: 3000 }, (_, i) => i / 100);
          const least = times.map(() => -1);
          const most = times.map((t) => (Math.abs(t - 12.34) < 1e-9 ? 90 : 1));
          const bars = [];
          const add = (...bar) => bars.push(bar);
          columns([times, least, most], [0, 30], (t) => 20 * t, (v) => -v, add);
          return bars;
        }"""
    )
    assert max(-top for _, _, top, _ in found) == 90
    assert len(found) == 601
    for (_, right, top, foot), (left, _, after, after_foot) in pairwise(found):
        assert right == left  # no gap from left to right, nor from top to bottom
        assert after <= foot
        assert top <= after_foot
