"""A person who has never seen the command line: the whole shipped experiment, by the mouse alone.

What is done here is done by clicks on controls that can be seen, by the words on them. What is
expected here is read from the page, and compared with the files that the person is left with.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from labrig.session import open_session
from tests.labrig.panel.page import panel

PATIENCE_S = 1200.0  # for one step, on a computer that does much else; all takes 90 s
SETTLED = re.compile(r"After \d+ positions?: B [\d.]+ µN·m², 90 %: [\d.]+ to [\d.]+")
POINT = re.compile(r"90 %: ([\d.]+) to ([\d.]+), after (\d+) position")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """What the first line of the manual makes."""
    command = [sys.executable, "-m", "labrig", "init", "--simulated", "first"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, timeout=60)
    monkeypatch.chdir(tmp_path / "first")
    return tmp_path / "first"


@pytest.mark.timeout(2 * PATIENCE_S)
@pytest.mark.thorough
def test_the_shipped_experiment_from_start_to_report_with_the_mouse_alone(folder, visit, tmp_path):
    with panel(None) as server:
        page = visit(server.address)
        click(page, "New run")
        click(page, "Start the run")
        click(page, "The result so far")

        watch_it_grow(page)
        output = page.get_by_role("status", name="Output").inner_text()
        assert "SAFE" in output
        assert "0 V written and read back" in output
        widths = [high - low for low, high in read_b_by_positions(page)]
        assert len(widths) >= 2
        assert widths[-1] < 0.7 * widths[0]

        click(page, "Diagnose")
        steps = follow(page, "Diagnose", until="Diagnosis (JSON)")
        assert len({share for share in steps if share}) >= 3
        found = json.loads(saved(page, "Diagnosis (JSON)", tmp_path))
        assert found == json.loads(next(folder.glob("*.diagnosis.json")).read_text())
        page.get_by_text(f"Verdict: {found['sentence']}").wait_for(timeout=1e3 * PATIENCE_S)
        said = card(page, "Model discrepancy").lower()
        assert found["verdict"] == "effect_named"
        assert all(one["title"].lower() in said for one in found["effects"])

        sheet, B_uNm2, low, high = read_model(page)
        assert low < B_uNm2 < high

        click(page, "Report")
        follow(page, "Report", until="Save the report")
        text = saved(page, "Save the report", tmp_path)
        assert text == next(folder.glob("*.report.html")).read_text()
        with page.expect_popup() as opened:
            click(page, "Open the report")
        read_report(opened.value, found["sentence"], sheet, B_uNm2)
    with open_session(next(folder.glob("*.h5"))) as session:
        assert session.outcome == "completed"
        assert len(session.runs) == 14


def click(page, words):
    """Press what bears these words, once it can be pressed, as a hand would."""
    control = page.get_by_role("button", name=words, exact=True).or_(
        page.get_by_role("link", name=words, exact=True)
    )
    control.first.click(timeout=1e3 * PATIENCE_S)


def watch_it_grow(page):
    """Without a click B appears, and again with further positions; until the run has ended."""
    going = page.get_by_role("status", name="Run")
    parameters = page.locator("section", has=page.get_by_role("heading", name="Parameters"))
    seen = set()
    end_s = time.monotonic() + PATIENCE_S
    while len(seen) < 2 or "COMPLETED" not in going.inner_text():
        assert time.monotonic() < end_s, f"{going.inner_text()}: {seen}"
        seen |= set(SETTLED.findall(page.locator(".page").inner_text()))
        page.wait_for_timeout(200)
    assert re.search(r"EIBM at \+2 V\s+[\d.]+ µN·m\s+90 %: [\d.]+ to", parameters.inner_text())


def read_b_by_positions(page):
    """The interval of B after each number of positions, read off the chart by pointing."""
    chart = page.get_by_role("application", name="B against the number of positions measured")
    read = page.locator(".chart", has=chart).locator(".chart-read")
    found = {}
    for x, y in point_all_over(page, chart):
        page.mouse.move(x, y)
        point = POINT.search(read.inner_text())
        if point:
            low, high, count = point.groups()
            found[int(count)] = (float(low), float(high))
    return [found[count] for count in sorted(found)]


def point_all_over(page, chart):
    """Places of a chart, as a hand moves over it."""
    chart.scroll_into_view_if_needed()
    box = chart.bounding_box()
    for row in (0.25, 0.5, 0.75):
        for column in range(1, 20):
            yield box["x"] + column / 20 * box["width"], box["y"] + row * box["height"]


def follow(page, job, until):
    """The shares that were shown of a job until its outcome is there."""
    row = page.get_by_role("listitem").filter(has=page.get_by_role("button", name=job, exact=True))
    shares = []
    end_s = time.monotonic() + PATIENCE_S
    while not row.get_by_role("link", name=until).is_visible():
        text = row.inner_text()
        assert time.monotonic() < end_s, text
        assert "Failed" not in text
        shares += re.findall(r"\d+ %", text)
        page.wait_for_timeout(100)
    return shares


def card(page, title):
    """What is written under a title."""
    return page.locator("section", has=page.get_by_role("heading", name=title)).last.inner_text()


def read_model(page):
    """Sheet, B and interval of the model that is drawn; its lines are found by pointing."""
    chart = page.get_by_role("application", name="force over position")
    read = set()
    for x, y in point_all_over(page, chart):
        page.mouse.move(x, y)
        read |= set(re.findall(r"model, (.\d V|0 V)", page.locator(".page").inner_text()))
    assert read >= {"+2 V", "−2 V", "0 V"}
    text = card(page, "Parameters")
    found = re.search(r"B\s+([\d.]+) µN·m²\s+90 %: ([\d.]+) to ([\d.]+)", text)
    sheet = re.search(r"Parameters, (\w+) sheet", text)
    return sheet[1], *(float(one) for one in found.groups())


def saved(page, words, folder):
    """The text of the file that a click hands out."""
    with page.expect_download() as download:
        click(page, words)
    path = Path(folder) / download.value.suggested_filename
    download.value.save_as(path)
    return path.read_text()


def read_report(report, sentence, sheet, B_uNm2):
    """The report as it is shown: its figures, the verdict, B with its interval."""
    report.wait_for_load_state("load")  # a page of megabytes, whose heading comes first
    report.get_by_role("heading", level=1).wait_for()
    text = report.locator("body").inner_text()
    assert sentence in text
    row = re.search(r"bending stiffness B, µN·m²(.*)", text)[1]
    own = re.findall(r"([\d.]+) ± [\d.]+\s+([\d.]+) to ([\d.]+)", row)
    value, low, high = map(float, own[("long", "short").index(sheet)])
    assert low < value < high
    assert value == pytest.approx(B_uNm2, rel=0.05)
    figures = report.get_by_role("img").all()
    assert len(figures) >= 6
    for figure in figures:
        assert figure.bounding_box()["height"] > 100
