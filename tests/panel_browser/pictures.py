"""`python -m tests.panel_browser.pictures`: the page's pictures in docs/images, from a real run.

A simulated rig is measured, fitted, and measured again with the model's curve drawn over it.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from tests.end_to_end.small_rig import labrig, make_rig, run_rig
from tests.labrig.panel.page import panel
from tests.panel_browser.conftest import NAMES
from tests.panel_browser.rig_world import RigWorld, answer_until, enter, start

IMAGES = Path(__file__).parents[2] / "docs" / "images"
PROTOCOL = """
[pulse_train]
zero_readings = 5
readings_per_voltage = 6
[[places]]
configuration = "long"
positions_mm = [5, 15]
[extras]
mode = "paper"
"""


def main() -> None:
    """Take them all."""
    path = next(filter(None, map(shutil.which, NAMES)))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        rig = make_rig(Path(folder) / "rig", PROTOCOL)
        for name in ("monday.h5", "tuesday.h5"):
            run_rig(rig, name)
            assert labrig("analyze", rig / name) == 0
        assert labrig("fit", rig / "monday.h5", "-o", rig / "model.toml") == 0
        browser = play.chromium.launch(executable_path=path, args=["--no-sandbox"])
        with panel(rig / "rig.toml", "--model", str(rig / "model.toml")) as server:
            _take(browser, RigWorld(server, rig))
        browser.close()


def _take(browser: object, world: RigWorld) -> None:
    def visit(
        url: str, width: int = 1440, height: int = 900, dark: bool = False, **more: object
    ) -> Page:
        scheme = "dark" if dark else "light"
        context = browser.new_context(  # type: ignore[attr-defined]
            viewport={"width": width, "height": height}, color_scheme=scheme, **more
        )
        page: Page = context.new_page()
        page.set_default_timeout(90_000)
        page.goto(url)
        return page

    page = enter(visit, world)
    phone = enter(visit, world, width=390, height=844, dark=True)
    start(page, world, "protocol.toml", "wednesday.h5")
    # in the second run, while energised, with both curves on the picture
    ready = (
        "labrig.job.runs.get(1)?.readings.size >= 9 && labrig.job.output.state === 'energised'"
        " && labrig.page.view.picture.curve()?.model"
    )
    answer_until(page, ready, 200)
    page.screenshot(path=IMAGES / "panel-run.png")
    phone.screenshot(path=IMAGES / "panel-phone.png")
    answer_until(page, "['ended', 'lost'].includes(labrig.job.job?.state)", 300)
    page.emulate_media(color_scheme="dark")
    for name, where, ready in (
        ("new", "new", "labrig.page?.planned != null"),
        (
            "compare",
            "compare?a=monday.h5&b=tuesday.h5",
            "document.querySelector('.compare-forces tbody tr')",
        ),
        (
            "sessions",
            "library",
            "document.querySelectorAll('.library-table tbody tr').length === 3",
        ),
    ):
        page.goto(world.url(where))
        page.wait_for_function(ready)
        page.wait_for_timeout(800)
        page.screenshot(path=IMAGES / f"panel-{name}.png")


if __name__ == "__main__":
    main()
