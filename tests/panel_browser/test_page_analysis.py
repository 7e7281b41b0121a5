"""Analysis with mouse and keyboard: started, followed, cancelled, its outputs opened."""

from __future__ import annotations

import shutil

import pytest

from tests.end_to_end.small_rig import two_positions
from tests.panel_browser.conftest import text_of
from tests.panel_browser.rig_world import enter

NAME = "s.h5"


def row(kind):
    return f"li[data-kind='{kind}']"


def job(kind="diagnose", state="running", **more):
    return {
        "id": f"{kind}-1", "kind": kind, "session": NAME, "by": "Ann", "wall": "", "state": state,
        "step": "", "fraction": 0.0, "message": "", "result": {}, **more,
    }  # fmt: skip


def jobs(*all_jobs):
    return {"type": "analysis", "jobs": list(all_jobs)}


@pytest.fixture
def page(fake, visit):
    fake.answers["GET", "/api/library/session"] = {"name": NAME, "log": []}
    fake.answers["GET", "/api/analysis/outputs"] = {"outputs": {}, "analysed": False}
    found = visit(f"{fake.url}#/session?name={NAME}")
    found.wait_for_selector(".analysis-jobs")
    return found


def test_a_running_job_shows_its_step_its_progress_and_a_way_to_cancel(fake, page):
    page.click(f"{row('diagnose')} button")
    fake.until_asked("/api/analysis/start")
    assert ("POST", "/api/analysis/start", {"kind": "diagnose", "session": NAME}) in fake.asked
    other = job("fit", session="other.h5", step="not ours")
    fake.tell(jobs(other, job(step="searching for effect 2", fraction=0.25)))
    words = f"{row('diagnose')} .analysis-words"
    page.wait_for_function(
        f"document.querySelector(\"{words}\").textContent === 'searching for effect 2, 25 %'"
    )
    bar = page.locator(f"{row('diagnose')} progress")
    assert bar.is_visible()
    assert bar.evaluate("bar => bar.value") == 0.25
    assert bar.get_attribute("aria-label") == "Diagnose"
    assert page.get_by_role("button", name="Diagnose", exact=True).is_disabled()
    assert "not ours" not in text_of(page, ".analysis")
    page.get_by_role("button", name="Cancel: Diagnose").click()
    fake.until_asked("/api/analysis/cancel")
    assert ("POST", "/api/analysis/cancel", {"id": "diagnose-1"}) in fake.asked


@pytest.mark.thorough
def test_the_outcome_is_one_sentence_that_is_read_aloud_and_the_focus_stays(fake, page):
    page.focus(f"{row('fit')} button")
    fake.tell(jobs(job("fit")))
    cancel = page.get_by_role("button", name="Cancel: Fit")
    cancel.wait_for()
    cancel.focus()
    found = {"model": {"file": "s.model.toml", "wall": "2026-11-23T00:00:00+00:00"}}
    fake.answers["GET", "/api/analysis/outputs"] = {"outputs": found, "analysed": True}
    notes = ["short: could not be fitted: it was not measured."]
    result = {"files": {"model": "s.model.toml"}, "notes": notes}
    fake.tell(jobs(job("fit", "done", message="long: B 1.27.", result=result)))
    page.get_by_role("link", name="Model file").wait_for()
    assert text_of(page, f"{row('fit')} .analysis-words") == "long: B 1.27."
    assert page.locator(".analysis [aria-live]").text_content() == "Fit: long: B 1.27."
    assert page.evaluate("document.activeElement.textContent") == "Fit"
    assert not cancel.is_visible()
    page.get_by_text("Remarks (1)").click()
    assert notes[0] in text_of(page, f"{row('fit')} details")


def test_a_failed_job_says_why_and_a_refusal_too(fake, page):
    fake.tell(jobs(job("report", "failed", message="the disk is full.")))
    page.get_by_text("Failed: the disk is full.").wait_for()
    fake.answers["POST", "/api/analysis/start"] = (409, {"error": "s.h5 is being recorded."})
    page.click(f"{row('analyze')} button")
    page.get_by_role("alert").filter(has_text="is being recorded").wait_for()


@pytest.fixture(scope="module")
def recorded(shared_world, tmp_path_factory):
    """A session that is not analysed yet."""
    shutil.copy(two_positions(tmp_path_factory), shared_world.folder / NAME)


@pytest.mark.thorough  # what is asked and told is tested with a made-up panel and without a page
@pytest.mark.usefixtures("recorded")
def test_a_session_is_fitted_with_the_mouse_alone(world, visit):
    page = enter(visit, world, f"session?name={NAME}")
    page.click(f"{row('fit')} button")
    page.locator(f"{row('fit')} progress").wait_for()
    page.get_by_role("link", name="Model file").wait_for(timeout=180_000)
    assert "long: B " in text_of(page, f"{row('fit')} .analysis-words")
    assert (world.folder / "s.model.toml").is_file()
    page.wait_for_function("document.querySelector('.facts').innerText.includes('B, long')")


@pytest.mark.thorough
@pytest.mark.usefixtures("recorded")
def test_a_job_is_cancelled_with_the_keyboard(world, visit):
    page = enter(visit, world, f"session?name={NAME}")
    page.focus(f"{row('diagnose')} button")
    page.keyboard.press("Enter")
    page.locator(f"{row('diagnose')} progress").wait_for()
    page.get_by_role("button", name="Cancel: Diagnose").focus()
    page.keyboard.press("Space")
    page.get_by_text("It was cancelled.").first.wait_for()
    assert not (world.folder / "s.diagnosis.json").exists()


PROPOSED = """# To tell effects apart: what stands here is for those who read the file
[pulse_train]
zero_readings = 2
readings_per_voltage = 4
[[places]]
configuration = "long"
positions_mm = [7.5]
"""


@pytest.mark.thorough
@pytest.mark.usefixtures("recorded")
def test_the_protocol_that_was_proposed_is_opened_and_checked_as_a_new_run(world, visit):
    folder = world.folder / "night"
    folder.mkdir()
    shutil.copy(world.folder / NAME, folder)
    (folder / "s.next.toml").write_text(PROPOSED)
    page = enter(visit, world, f"result?session=night/{NAME}")
    page.get_by_role("link", name="Open it as a new run").click()
    page.locator(".file-choose select").first.wait_for()
    page.get_by_text("s.next.toml, proposed after night/s.h5").wait_for()
    page.get_by_label("save the changed protocol as").wait_for()
    page.get_by_role("button", name="Start the run").and_(page.locator(":enabled")).wait_for()
    page.get_by_role("button", name="Add to the queue").click()
    page.locator("main.page-queue").get_by_text("s.next.toml").first.wait_for()
    assert (world.folder / "s.next.toml").read_text() == PROPOSED
    page.go_back()
    page.locator("summary").get_by_text("s.next.toml", exact=True).wait_for()  # nothing to save
