"""The dynamic model beside the run, on the run's page."""

from __future__ import annotations

import pytest

from labrig.model_file import save_model
from tests.labrig.moving_model import model
from tests.labrig.panel.moving_session import MOVING, followed, moving_session
from tests.panel_browser import made_up
from tests.panel_browser.conftest import text_of
from tests.panel_browser.rig_world import (
    ENDED,
    answer_until,
    enter,
    rig_world,
    start,
)

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


@pytest.mark.thorough
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


@pytest.mark.thorough
def test_more_of_a_prediction_is_appended_and_another_run_begins_anew(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_function("labrig.job.predicted.count === 1290")
    fake.tell(made_up.predicted(4, 12.9, 13.0, fresh=False))
    page.wait_for_function("labrig.job.predicted.count === 1300")
    fake.tell(made_up.predicted(5, 0.0, 0.1, fresh=True))
    page.wait_for_function("labrig.job.predicted.count === 10 && labrig.job.predicted.run === 5")


@pytest.mark.thorough
def test_a_failure_is_a_sentence_and_no_model_is_no_card(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(CARD)
    why = "The model beside the run has ended without a word; it is started again. The run goes on."
    fake.tell({"type": "motion", "state": "none", "why": why, "run": None})
    page.wait_for_function(f"document.querySelector('{CARD}').innerText.includes('goes on')")
    assert page.locator(f"{CARD} table").is_hidden()
    fake.tell({"type": "motion", "state": "none", "why": "", "run": None})
    page.wait_for_selector(CARD, state="hidden")


# -------------------------------------------------------------- what a model says of a real session


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return moving_session(tmp_path_factory)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("stiffness", "said"),
    [
        (1.0, None),
        (1.2, "Stiffness B is {} % below the model’s."),
    ],
    ids=["true", "20 % too stiff"],
)
def test_a_stiffness_that_is_off_shows_while_the_sheet_moves(
    fake, visit, recorded, tmp_path, stiffness, said
):
    path = tmp_path / "model.toml"
    save_model(model(load_cell=True, negative_ratio=0.8, stiffness=stiffness), path)
    answers = followed(recorded, str(path))
    estimates = [a.estimates for a in answers if a.estimates is not None]
    B = dict(zip(estimates[-1]["columns"], estimates[-1]["rows"][-1], strict=True))["B"]
    assert (B < 0.9) == (stiffness > 1.0)  # how well it is found: test_live_model
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(f"{CARD} canvas")
    fake.tell(estimates[-1], answers[-1].motion)  # what is waited for comes last
    off = f"{answers[-1].motion['force_rms_mN']:.3f} mN"
    page.wait_for_function(f"document.querySelector('{CARD}').innerText.includes('{off}')")
    shown = text_of(page, CARD)
    if said is None:
        assert "Stiffness B is" not in shown
    else:
        assert said.format(round(100 * (1 - B))) in shown


@pytest.mark.thorough
@pytest.mark.alone
@pytest.mark.timeout(400)
def test_the_model_follows_a_run_on_the_real_clock(tmp_path, visit):
    with rig_world(tmp_path) as world:
        (tmp_path / "world.toml").write_text(MOVING)
        save_model(model(load_cell=True, negative_ratio=0.8), tmp_path / "true.toml")
        page = enter(visit, world)
        page.evaluate(
            """async () => {
              const net = await import("/static/js/net.js");
              await labrig.control.take(!labrig.control.free);
              await net.post("/api/model", { name: "true.toml" });
            }"""
        )
        page.wait_for_function("labrig.job.motion !== null", timeout=120_000)  # it is ready
        text = (tmp_path / "long.toml").read_text()
        assert "zero_readings = 2" in text
        at_rest = text.replace("zero_readings = 2", "zero_readings = 100")  # a minute for it:
        (tmp_path / "at_rest.toml").write_text(at_rest)  # its process has a low priority
        start(page, world, "at_rest.toml", "followed.h5")
        follows = "labrig.job.motion.run_s > 2 && labrig.job.estimates?.rows.length > 1"
        answer_until(page, f"({follows}) || {ENDED}", 200)
        assert page.evaluate(follows), page.evaluate("[labrig.job.motion, labrig.job.ended]")
        assert page.evaluate("labrig.job.predicted.count") > 100
