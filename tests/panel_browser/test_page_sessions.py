"""Recorded sessions on the page: found, sorted, replayed, compared, exported."""

from __future__ import annotations

import io
import shutil
import zipfile

import pytest

from labrig.panel.replay import Recording
from labrig.session import open_session
from tests.end_to_end.small_rig import TWO_POSITIONS, labrig, make_rig, run_rig, two_positions
from tests.labrig.panel.page import panel
from tests.panel_browser.conftest import text_of
from tests.panel_browser.rig_world import RigWorld, enter


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    folder = make_rig(tmp_path_factory.mktemp("sessions") / "rig")
    (folder / "protocol.toml").write_text(TWO_POSITIONS.replace("5, 15", "5, 10"))
    run_rig(folder, "a.h5")
    shutil.copy(two_positions(tmp_path_factory), folder / "b.h5")
    with panel(folder / "rig.toml", lean=True) as server:
        yield RigWorld(server, folder)


def test_sessions_are_listed_filtered_sorted_and_opened(world, visit):
    page = enter(visit, world, "library")
    rows = page.locator(".library-table tbody tr")
    rows.nth(1).wait_for()
    assert rows.count() == 2
    page.click("th >> text=session")
    page.locator("th[aria-sort='descending'] >> text=session").wait_for()
    page.wait_for_function("document.querySelector('.library-table tbody a').innerText === 'b.h5'")
    page.fill("input[type='search']", "a.h5")
    page.wait_for_function("document.querySelectorAll('.library-table tbody tr').length === 1")
    page.click(".library-table a")
    page.locator(".facts dd").filter(has_text="completed").wait_for()
    assert "16, 0 invalid" not in text_of(page, ".session-two")  # 10 readings a run, two runs
    assert "20, 0 invalid" in text_of(page, ".session-two")
    assert page.locator(".log-lines li").count() > 4
    page.click("text=Export tables")
    page.locator(".fault").filter(has_text="run labrig analyze").wait_for()
    assert labrig("analyze", world.folder / "a.h5") == 0
    with page.expect_download() as download:
        page.click("text=Export tables")
    names = zipfile.ZipFile(io.BytesIO(download.value.path().read_bytes())).namelist()
    assert any(name.endswith("forces.csv") for name in names)


@pytest.mark.thorough
def test_a_reading_of_a_closed_session_is_marked_and_taken_back_with_the_mouse(world, visit):
    page = enter(visit, world, "session?name=b.h5")
    card = page.locator(".session-marks")
    card.locator("text=Mark…").nth(1).click()
    card.get_by_role("spinbutton").fill("3")
    card.get_by_role("textbox").fill("a bubble")
    card.get_by_text("Mark invalid", exact=True).click()
    card.locator("td").filter(has_text="reading 3 of run 2: INVALID").wait_for()
    assert "20, 1 invalid" in text_of(page, ".facts")
    with open_session(world.folder / "b.h5") as session:
        assert session.runs[1].readings["why"][2] == "a bubble"
        assert session.marks_after_end[0].who.startswith("operator")
    card.get_by_text("Take back…").click()
    card.get_by_role("textbox").fill("it was none")
    card.get_by_text("Take back", exact=True).click()
    card.locator("td").filter(has_text="mark taken back").wait_for()
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    with open_session(world.folder / "b.h5") as session:
        assert session.runs[1].readings["valid"].all()


def test_a_session_plays_at_once_at_ten_times_and_by_hand(world, visit):
    page = enter(visit, world, "replay?session=a.h5")
    page.wait_for_function("labrig.page?.player.duration_s > 10")
    page.click("text='10×'")
    page.click("button >> text='Play'")
    page.wait_for_function("labrig.page.player.job.runs.get(1)?.readings.size === 10")
    page.wait_for_function("labrig.page.view.picture.shown > 0")  # as many as it has time for
    shown = page.evaluate(
        "[...labrig.page.player.job.runs.get(1).readings.values()].map((r) => r.force_mN)"
    )
    with open_session(world.folder / "a.h5") as session:
        recorded = 1e3 * session.runs[1].readings["force_N"]
    assert sorted(shown) == pytest.approx(sorted(recorded))
    # by hand, to the first run's fourth reading: what came later is forgotten
    page.evaluate("labrig.page.player.pause()")
    at_s = page.evaluate(
        "labrig.page.player.job.replay.marks.filter((m) => m.kind === 'reading')[3].at_s"
    )
    page.evaluate(
        """(at) => {
          const slider = document.querySelector(".transport input[type=range]");
          slider.value = at + 0.1;
          slider.dispatchEvent(new Event("input", { bubbles: true }));
          slider.dispatchEvent(new Event("change", { bubbles: true }));
        }""",
        at_s,
    )
    page.wait_for_function("labrig.page.player.job.runs.get(0)?.readings.size === 4")
    assert not page.evaluate("labrig.page.player.job.runs.has(1)")
    page.wait_for_function("labrig.page.player.job.signals.count > 50")
    page.focus(".transport input[type=range]")
    page.click("text=reading ▶")
    page.wait_for_function("labrig.page.player.job.runs.get(0)?.readings.size === 5")
    assert "NOT IN USE" in text_of(page, "#output")  # the rig's, not the recording's


@pytest.mark.thorough
def test_a_replay_opens_on_the_first_reading_with_the_curve_that_the_session_holds(world, visit):
    with open_session(world.folder / "a.h5") as session:
        analysed = session.has_measurements
    if not analysed:
        assert labrig("analyze", world.folder / "a.h5") == 0
    recording = Recording(world.folder / "a.h5", "a.h5")
    stored = recording.stored_curve(-1.0, recording.first_s)
    recording.close()
    page = enter(visit, world, "replay?session=a.h5")
    page.wait_for_function("labrig.page?.player.job.runs.get(0)?.readings.size === 1")
    page.wait_for_function("labrig.page.view.picture.shown === 1")
    page.wait_for_function("labrig.page.player.job.curve?.points_px.length > 20")
    curve, frame = page.evaluate(
        "[labrig.page.player.job.curve, labrig.page.view.picture.header.frame]"
    )
    assert curve["frame"] == frame == stored["frame"]
    assert curve["ok"]
    assert stored["stored"]
    assert len(stored["points_px"]) > 20
    assert not page.evaluate("labrig.page.player.job.replay.playing")


@pytest.mark.thorough
def test_two_sessions_are_compared_at_the_same_position_and_voltage(world, visit):
    text = TWO_POSITIONS.replace("5, 15", "10, 5")
    (world.folder / "protocol.toml").write_text(text)
    run_rig(world.folder, "c.h5")
    page = enter(visit, world, "compare?a=a.h5&b=c.h5")
    where = """labrig.page?.players.map(({ job }) => {
      const run = job.planned(job.now_run);
      const last = [...(job.runs.get(job.now_run)?.readings.values() ?? [])].at(-1);
      return [run?.run, run?.position_mm, last?.voltage_V, last?.index];
    })"""
    page.wait_for_function(f"({where})?.every(([, mm, , index]) => mm === 5 && index === 0)")
    assert [run for run, *_ in page.evaluate(where)] == [0, 1]  # measured at different times
    for index in range(1, 4):
        page.click("text=reading \u25b6")
        page.wait_for_function(f"({where}).every(([, mm, , at]) => mm === 5 && at === {index})")
    (_, _, volts_a, _), (_, _, volts_b, _) = page.evaluate(where)
    assert volts_a == volts_b
    page.locator("text=\u25c0 reading").evaluate("(button) => (button.click(), button.click())")
    page.wait_for_function(f"({where}).every(([, mm, , at]) => mm === 5 && at === 1)")


def test_a_file_that_is_no_session_is_told_in_a_sentence(world, visit):
    (world.folder / "broken.h5").write_bytes(b"no session" * 100)
    page = enter(visit, world, "replay?session=broken.h5")
    page.locator(".transport .fault").filter(has_text="broken.h5").wait_for()
    (world.folder / "broken.h5").unlink()


@pytest.mark.thorough
def test_two_sessions_stand_side_by_side(world, visit):
    page = enter(visit, world, "library")
    page.get_by_label("choose a.h5").check()
    page.get_by_label("choose b.h5").check()
    page.click("text=Compare the two")
    page.locator(".compare-forces tbody tr").first.wait_for()
    found = page.evaluate("fetch('/api/library/compare?a=a.h5&b=b.h5').then((x) => x.json())")
    positions = {row["position_mm"]: (row["a"] is None, row["b"] is None) for row in found["rows"]}
    assert positions == {5: (False, False), 10: (False, True), 15: (True, False)}
    assert page.locator(".compare-forces tbody tr").count() == len(found["rows"])
    page.wait_for_function("labrig.page.players.every((one) => one.duration_s > 10)")
    page.click("text='100×'")
    page.click("button >> text='Play'")
    page.wait_for_function(
        "labrig.page.players.every((one) => one.job.runs.get(0)?.readings.size >= 5)"
    )
