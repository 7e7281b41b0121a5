"""The dynamic model beside the run, on the run's page."""

from __future__ import annotations

import pytest

from labrig.model_file import save_model
from tests.labrig.moving_model import model
from tests.labrig.panel.test_live_model import MOVING
from tests.panel_browser import made_up
from tests.panel_browser.conftest import text_of
from tests.panel_browser.rig_world import answer_until, enter, rig_world, start

CARD = ".model-beside"


def has_colour(page, canvas, near):
    """Whether a canvas has a pixel about of this colour."""
    return page.evaluate(
        """([canvas, [r, g, b]]) => {
          const of = document.querySelector(canvas);
          const { data } = of.getContext("2d").getImageData(0, 0, of.width, of.height);
          let count = 0;
          for (let i = 0; i < data.length; i += 4)
            if (Math.hypot(data[i] - r, data[i + 1] - g, data[i + 2] - b) < 40) count += 1;
          return count > 50;
        }""",
        [canvas, near],
    )


def test_the_card_shows_errors_and_slow_parameters_with_their_sigma(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(f"{CARD} canvas")
    said = text_of(page, CARD)
    for words in (
        "0.085 mN", "mean −0.012 mN", "noise 0.043 mN", "0.30 mm", "over the last 10 s",
        "1.46 ± 0.02 µN m²", "115.0 ± 1.2 %", "97.5 ± 0.6 %",
        "Stiffness B is 15 % above the model’s.",
    ):  # fmt: skip
        assert words in said
    assert "Moment per volt is" not in said  # 2.5 % are none that is worth a sentence
    page.focus(f"{CARD} .chart-plot")
    page.keyboard.press("ArrowRight")
    assert "stiffness B" in text_of(page, f"{CARD} .chart-read")


def test_the_predicted_force_lies_over_the_strip_chart_and_the_shape_over_the_image(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_function("labrig.job.predicted.count > 1000 && labrig.page?.view?.picture.shown")
    assert page.evaluate("labrig.job.predicted.column('force_mN_least').length") == 1290
    page.wait_for_timeout(300)
    magenta = (0xB0, 0x00, 0xA0)
    assert has_colour(page, ".strip[data-row=force_mN] canvas", magenta)
    assert not has_colour(page, ".strip[data-row=drive_V] canvas", magenta)
    assert "0.29 mm RMS distance" in text_of(page, ".picture-error")
    page.hover(".strip[data-row=force_mN] .u-over")
    assert "(model " in text_of(page, ".strips .chart-read")


def test_more_of_a_prediction_is_appended_and_another_run_begins_anew(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_function("labrig.job.predicted.count === 1290")
    fake.tell(made_up.predicted(4, 12.9, 13.0, fresh=False))
    page.wait_for_function("labrig.job.predicted.count === 1300")
    fake.tell(made_up.predicted(5, 0.0, 0.1, fresh=True))
    page.wait_for_function("labrig.job.predicted.count === 10 && labrig.job.predicted.run === 5")


def test_a_failure_is_a_sentence_and_no_model_is_no_card(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(CARD)
    why = "The model beside the run has ended without a word; it is started again. The run goes on."
    fake.tell({"type": "motion", "state": "none", "why": why, "run": None})
    page.wait_for_function(f"document.querySelector('{CARD}').innerText.includes('goes on')")
    assert page.locator(f"{CARD} table").is_hidden()
    fake.tell({"type": "motion", "state": "none", "why": "", "run": None})
    page.wait_for_selector(CARD, state="hidden")


# ------------------------------------------------------------------- a real run in the moving world

FIGURES = """() => {
  const { motion, estimates } = labrig.job;
  const row = estimates?.rows.at(-1) ?? [];
  return { motion, B: row[2], B_sigma: row[3], moment: row[4], rows: estimates?.rows.length ?? 0 };
}"""


@pytest.mark.alone
def test_a_stiffness_that_is_off_shows_while_the_sheet_moves(tmp_path, visit):
    """On the real clock, with the true model and with one whose B is 20 % too high."""
    found = {}
    with rig_world(tmp_path) as world:
        (tmp_path / "world.toml").write_text(MOVING)
        rig = tmp_path / "rig.toml"
        rig.write_text(rig.read_text().replace("# world =", "world ="))
        page = enter(visit, world)
        for name, stiffness in (("true", 1.0), ("stiff", 1.2)):
            sheet = model(load_cell=True, negative_ratio=0.8, stiffness=stiffness)
            save_model(sheet, tmp_path / f"{name}.toml")
            page.evaluate(
                """async (name) => {
                  const net = await import("/static/js/net.js");
                  await labrig.control.take(!labrig.control.free);
                  await net.post("/api/model", { name });
                }""",
                f"{name}.toml",
            )
            page.wait_for_function("labrig.job.motion !== null", timeout=120_000)  # it is ready
            start(page, world, "long.toml", f"{name}.h5")
            answer_until(page, "labrig.job.motion?.run_s > 12", 240)
            found[name] = page.evaluate(FIGURES)
            assert page.evaluate("labrig.job.predicted.count") > 1000
            page.wait_for_function("labrig.job.motion?.shape?.points_px.length > 10")
            answer_until(page, "['ended', 'lost'].includes(labrig.job.job?.state)", 120)
            assert page.evaluate("labrig.job.ended.outcome") == "completed"
    true, stiff = found["true"], found["stiff"]
    assert true["motion"]["force_rms_mN"] < 0.2
    assert stiff["motion"]["force_rms_mN"] > 1.3 * true["motion"]["force_rms_mN"]
    assert true["B"] == pytest.approx(1.0, abs=max(3 * true["B_sigma"], 0.04))
    assert stiff["B"] == pytest.approx(1 / 1.2, abs=max(3 * stiff["B_sigma"], 0.04))
