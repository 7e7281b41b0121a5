"""Analysis by the panel: what the command line writes, and a fit that grows with a run."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path

import pytest

from labrig.analysis.results import converging, result_of
from labrig.panel.analysis.outputs import ENDINGS
from labrig.report.data.fitted import fit_what_can_be
from labrig.report.data.kept_diagnosis import kept_diagnosis
from labrig.serialise import finite
from labrig.session import load_measurements
from tests.end_to_end.small_rig import TWO_POSITIONS, labrig, make_rig, two_positions
from tests.fits_unchecked import fits_unchecked
from tests.labrig.panel.page import Page, panel

pytestmark = pytest.mark.slow  # processes that analyse images

WAIT_S = 200.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = make_rig(tmp_path_factory.mktemp("analysed") / "rig", TWO_POSITIONS)
    shutil.copy(two_positions(tmp_path_factory), folder)
    return folder


@pytest.fixture(scope="module")
def server(folder):
    with panel(folder / "rig.toml", lean=True) as found:
        yield found


@pytest.fixture
def page(server):
    found = Page(server)
    found.take_control(force=True)
    yield found
    found.close()


def ended(page, job):
    """The job when it has ended, as the live socket has it."""

    def mine(message):
        return next((one for one in message["jobs"] if one["id"] == job["id"]), {})

    def over(message):
        return message["type"] == "analysis" and mine(message).get("state") not in (
            None, "queued", "running",
        )  # fmt: skip

    return mine(page.until(over, WAIT_S))


def done(page, kind, session="session.h5", **more):
    job = ended(page, page.do("/api/analysis/start", kind=kind, session=session, **more))
    assert job["state"] == "done", job["message"]
    return job


def test_only_who_holds_control_starts_and_cancels(server, page):
    watcher = Page(server)
    body = {"kind": "fit", "session": "session.h5"}
    assert watcher.ask("POST", "/api/analysis/start", body)[0] == 403
    assert watcher.ask("POST", "/api/analysis/cancel", {"id": "x"})[0] == 403
    assert watcher.ask("GET", "/api/analysis")[0] == 200
    watcher.close()


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ({"kind": "fit", "session": "gone.h5"}, 404),
        ({"kind": "fit", "session": "../session.h5"}, 400),
        ({"kind": "fit", "session": "rig.toml"}, 400),
        ({"kind": "live", "session": "session.h5"}, 400),
        ({"kind": "fit", "session": "session.h5", "between": ["gravity", "clamp_angle"]}, 400),
    ],
)
def test_requests_that_make_no_sense_are_refused(page, body, status):
    assert page.ask("POST", "/api/analysis/start", body)[0] == status
    assert page.ask("POST", "/api/analysis/cancel", {"id": "nobody"})[0] == 404


def test_a_session_is_analysed_and_fitted_as_by_the_command_line(folder, page, tmp_path):
    first = done(page, "fit")  # which analyses first
    assert first["result"]["files"] == {"model": "session.model.toml"}
    assert "not analysed yet" in first["result"]["notes"][0]
    assert "long: B " in first["message"]
    with fits_unchecked():  # which adds words, not numbers
        assert labrig("fit", folder / "session.h5", "-o", tmp_path / "cli.toml") == 0
    assert (folder / "session.model.toml").read_text() == (tmp_path / "cli.toml").read_text()


@pytest.mark.thorough
def test_a_session_is_diagnosed_and_reported_as_by_the_command_line(folder, page, server):
    done(page, "fit")
    found = done(page, "next")["result"]  # which diagnoses first, as there is no diagnosis yet
    kept = kept_diagnosis(folder / "session.h5")
    assert f"It was diagnosed first: {kept.sentence}" in found["notes"]
    assert {"completed_model", "diagnosis"} <= {*found["files"]}
    written = json.loads((folder / "session.diagnosis.json").read_text())
    assert written == finite(kept.to_json())  # what diagnose --json prints
    done(page, "report")
    status, text = server.ask("GET", "/api/analysis/output?session=session.h5&name=report")
    assert status == 200
    assert b"</html>" in text
    assert b"session.figures.zip as PDF and SVG" in text
    with zipfile.ZipFile(folder / "session.figures.zip") as figures:
        endings = {Path(name).suffix for name in figures.namelist()}
        assert {"figure-5.pdf", "figure-5.svg"} <= set(figures.namelist())
        assert endings == {".pdf", ".svg"}
    ask = "/api/analysis/output?session=session.h5&name=figures&save=true"
    status, packed = server.ask("GET", ask)
    assert (status, packed) == (200, (folder / "session.figures.zip").read_bytes())
    listed = server.ask("GET", "/api/analysis/outputs?session=session.h5")[1]
    assert set(listed["outputs"]) == {*ENDINGS} - {"next"}  # there is nothing to tell apart
    assert listed["analysed"]
    with panel(folder / "rig.toml", lean=True) as again:  # which knows no jobs, but finds the files
        assert again.ask("GET", "/api/analysis")[1]["jobs"] == []
        assert again.ask("GET", "/api/analysis/outputs?session=session.h5")[1] == listed


@pytest.mark.thorough
def test_curves_alone_and_a_measurement_between_two_effects_are_jobs_too(page, server):
    assert "curve" in done(page, "analyze")["message"]
    assert done(page, "next", between=["gravity", "clamp_angle"])["result"]["files"]
    listed = server.ask("GET", "/api/analysis/outputs?session=session.h5")[1]
    assert "next" in listed["outputs"]


def test_an_output_that_is_not_there_is_a_sentence(page, server, folder):
    (folder / "sub").mkdir(exist_ok=True)
    shutil.copy(folder / "session.h5", folder / "sub" / "other.h5")
    ask = "/api/analysis/output?session=sub/other.h5&name="
    assert server.ask("GET", f"{ask}report")[0] == 404
    assert server.ask("GET", f"{ask}h5")[0] == 400


@pytest.fixture
def fitting(folder):
    """A page of a panel that fits beside a run."""
    with panel(folder / "rig.toml") as server:
        found = Page(server)
        found.take_control(force=True)
        yield found
        found.close()


@pytest.mark.thorough
def test_the_fit_grows_with_each_position_of_a_run_and_ends_as_the_analysis_does(folder, fitting):
    page = fitting
    job = page.do(
        "/api/run", protocol="protocol.toml", sheet="sheet.toml", session="live.h5",
        clock="virtual",
    )  # fmt: skip
    counts = set()

    def both(message):
        if message["type"] == "result" and message["session"] == "live.h5":
            counts.update(point["positions"] for point in message["convergence"]["long"])
        return 2 in counts

    last = page.until(both, WAIT_S)
    assert page.ended(job)["code"] == 0
    own = [m["convergence"]["long"] for m in page.of("result") if m["session"] == "live.h5"]
    assert [point["positions"] for point in own[-1]] == [1, 2]
    assert all(point["B_uNm2"]["sigma"] > 0 for point in own[-1])
    assert labrig("analyze", folder / "live.h5") == 0
    measurements = load_measurements(folder / "live.h5")
    fitted = fit_what_can_be(measurements).fit
    whole = result_of(
        measurements, session="live.h5", fitted=fitted,
        convergence=converging(measurements, whole=fitted),
    )  # fmt: skip
    whole = json.loads(json.dumps(whole))
    assert last["convergence"] == whole["convergence"]
    assert last["configurations"] == whole["configurations"]
