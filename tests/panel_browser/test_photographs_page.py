"""The page of a folder of photographs in the browser: click once, look, accept, refuse."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
from urllib.parse import urlsplit

import cv2
import numpy as np
import pytest

from tests.labrig.vision import drawn_strips
from tests.processes import last_words

CLAMP = drawn_strips.BENT_UP.optics.clamp_px
SIZE = drawn_strips.BENT_UP.image.shape[::-1]
RULER_PX, RULER_MM = ((24.0, 20.0), (144.0, 20.0)), 30  # 4 pixels a mm


@pytest.fixture
def folder(tmp_path):
    """Three photographs, the last one without a strip; nothing is known of them."""
    up = drawn_strips.BENT_UP.image
    images = (up, drawn_strips.bright_down(), 0 * up + 90)
    for name, image in zip(("a", "b", "c"), images, strict=True):
        cv2.imwrite(str(tmp_path / f"{name}.png"), image)
    return tmp_path


@pytest.fixture
def address(folder):
    """`labrig curves --page FOLDER` as a process."""
    command = [sys.executable, "-m", "labrig", "curves", "--page", str(folder), "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        yield process.stdout.readline().strip()
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
    finally:
        process.kill()
        last_words(process)


def click_at(page, px):
    """Click on a pixel of the photograph."""
    box = page.locator(".photograph-canvas").bounding_box()
    scale = min(box["width"] / SIZE[0], box["height"] / SIZE[1])
    x = box["x"] + box["width"] / 2 + (px[0] + 0.5 - SIZE[0] / 2) * scale
    y = box["y"] + box["height"] / 2 + (px[1] + 0.5 - SIZE[1] / 2) * scale
    page.mouse.click(x, y)


def tile(page, name, state):
    found = page.locator(f".photograph-tile[data-state='{state}']").filter(has_text=name)
    found.wait_for()
    return found


def test_clicked_once_for_all_then_accepted_and_refused(folder, address, visit):
    page = visit(address)
    tile(page, "a", "new")
    assert page.title()
    click_at(page, CLAMP)
    click_at(page, (CLAMP[0] + 60, CLAMP[1]))
    for end in RULER_PX:
        click_at(page, end)
    page.get_by_label("ruler, mm").fill(str(RULER_MM))
    for length, thickness, said in (
        ("30,5", "", "free length: 30,5 is no length"),
        ("30", "-1", "thickness: -1 is no length"),
        ("", "0.6", "state the free length as well"),
    ):
        page.get_by_label("free length, mm").fill(length)
        page.get_by_label("thickness, mm").fill(thickness)
        page.click("text=Measure all")
        page.get_by_text(said).wait_for()
        assert not (folder / "optics.json").exists()
    page.get_by_label("thickness, mm").fill("")
    page.get_by_label("free length, mm").fill("30")
    page.click("text=Measure all")
    tile(page, "a", "found")
    tile(page, "b", "found")
    tile(page, "c", "refused")
    optics = json.loads((folder / "optics.json").read_text())
    assert optics["px_per_mm"] == pytest.approx(4.0, rel=0.02)
    assert optics["clamp_px"] == pytest.approx(CLAMP, abs=1.0)
    assert "free_length_mm = 30" in (folder / "sheet.toml").read_text()

    # a ruler's length that is corrected without a click says where it is not known
    page.get_by_label("ruler, mm").fill(str(2 * RULER_MM))
    page.click("text=Measure all")
    page.locator("text=click both its ends again").wait_for()
    page.get_by_label("ruler, mm").fill("")  # what is sent later says nothing of a ruler
    page.get_by_label("ruler, mm").blur()

    page.keyboard.press("a")  # the first one; the next one is shown then
    page.locator(".photograph-tile[data-decision='accepted']").wait_for()
    page.locator(".photograph-editor h2").filter(has_text="b.png").wait_for()
    page.fill("[placeholder^=why]", "it swings")
    page.click("text=Refuse (R)")
    page.locator(".photograph-tile[data-decision='refused']").wait_for()
    page.click("text=Write the tables")
    page.locator("text=Wrote curves/curves.csv and curves/summary.csv.").wait_for()
    rows = list(csv.DictReader((folder / "curves" / "summary.csv").read_text().splitlines()))
    assert [(row["image"], row["state"]) for row in rows] == [
        ("a", "found"), ("b", "refused"), ("c", "refused"),
    ]  # fmt: skip
    assert "it swings" in rows[1]["reason"]

    # a mask for one photograph alone is its own file; the accepted one is left as it was
    page.locator(".photograph-open[aria-label=c]").click()
    page.locator(".photograph-editor h2").filter(has_text="c.png").wait_for()
    page.click("button[data-tool=mask]")
    for corner in ((100, 100), (150, 100), (150, 140)):
        click_at(page, corner)
    page.click("text=Close the polygon")
    page.click("text=Measure this photograph")
    page.locator("text=Wrote c.optics.json").wait_for()
    assert len(json.loads((folder / "c.optics.json").read_text())["mask_px"][0]) == 3
    assert urlsplit(page.url).fragment == "/photographs"
    page.locator("text=pixels a mm (c.optics.json: ").wait_for()  # and not that of all

    # a curve that was lost: places on the strip, and its tip
    page.locator(".photograph-open[aria-label=b]").click()
    page.locator(".photograph-editor h2").filter(has_text="b.png").wait_for()
    page.click("button[data-tool=through]")
    click_at(page, (100, 100))
    click_at(page, (140, 100))
    page.click("text=Remove the last place")
    page.click("button[data-tool=tip]")
    click_at(page, (180, 100))
    page.click("text=Measure this photograph")
    page.locator("text=Wrote b.optics.json").wait_for()
    places = json.loads((folder / "b.optics.json").read_text())
    assert np.array(places["through_px"]) == pytest.approx(np.array([[100, 100]]), abs=1)
    assert places["tip_px"] == pytest.approx((180, 100), abs=1)
