"""Forms made from the schemas: file, command line and page have one set of limits."""

from __future__ import annotations

import copy
import tomllib

import pytest

from labrig.config.templates import template_text
from tests.panel_browser import made_up
from tests.panel_browser.conftest import text_of


@pytest.fixture
def fake(fake):
    """Nothing is going on."""
    fake.greeting = []
    return fake


def field(page, key):
    return page.locator(f"[data-key='{key}']").first


def fault_of(page, key):
    found = field(page, key).get_attribute("aria-describedby").split()[1]
    return page.locator(f"#{found}")


def until_fault(page, key, text):
    fault_of(page, key).filter(has_text=text).wait_for()


def keys_of(schema, root):
    """Every key that a file of this schema may have, as fields have them."""
    if "$ref" in schema:
        schema = root["$defs"][schema["$ref"].rsplit("/", 1)[1]]
    for one in schema.get("anyOf", ()):
        yield from keys_of(one, root)
    if "items" in schema:
        yield from keys_of(schema["items"], root)
    for name, one in schema.get("properties", {}).items():
        yield name
        yield from keys_of(one, root)


def test_every_key_of_the_protocol_has_a_field(fake, visit):
    page = visit(f"{fake.url}#/new")
    page.wait_for_selector("[data-key='pulse_s']")
    schema = fake.answers["GET", "/api/schemas"]["protocol"]
    shown = set(
        page.evaluate("[...document.querySelectorAll('[data-key]')].map((e) => e.dataset.key)")
    )
    assert set(keys_of(schema, schema)) <= shown


@pytest.mark.thorough
@pytest.mark.parametrize("kind", ["protocol", "sheet"])
def test_an_untouched_form_says_what_the_file_says(fake, visit, kind):
    page = visit(f"{fake.url}#/new")
    page.wait_for_selector("[data-key='pulse_s']")
    said = page.evaluate(f"labrig.page.{kind}.form.get()")
    assert said == tomllib.loads(template_text(f"{kind}.toml"))
    assert page.evaluate(f"labrig.page.{kind}.form.faults()") == []


def test_a_value_beyond_its_limit_is_refused_with_the_limit(fake, visit):
    page = visit(f"{fake.url}#/new")
    field(page, "voltages_V").fill("2, -31")
    until_fault(page, "voltages_V", "−31 is not allowed: at least −30, at most 30 V.")
    assert page.is_disabled("text=Start the run")
    assert field(page, "voltages_V").get_attribute("aria-invalid") == "true"
    field(page, "voltages_V").fill("2, -2")
    page.wait_for_function("!document.querySelector('.new-start .main').disabled")


@pytest.mark.thorough
def test_the_limit_is_the_schemas_own(fake, visit):
    schemas = copy.deepcopy(fake.answers["GET", "/api/schemas"])
    schemas["protocol"]["$defs"]["PulseTrain"]["properties"]["pulse_s"]["maximum"] = 0.55
    fake.answers["GET", "/api/schemas"] = schemas
    page = visit(f"{fake.url}#/new")
    field(page, "pulse_s").fill("0.6")
    until_fault(page, "pulse_s", "0.6 is not allowed: more than 0, at most 0.55 s.")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("typed", "told"),
    [("", ""), pytest.param("ten", "a number", marks=pytest.mark.thorough), ("2.5", "whole")],
)
def test_what_is_no_whole_number_is_told(fake, visit, typed, told):
    page = visit(f"{fake.url}#/new")
    field(page, "zero_readings").fill(typed)
    if told:
        until_fault(page, "zero_readings", told)
    else:  # left empty, the default holds
        page.wait_for_function("labrig.page.protocol.touched && labrig.page.protocol.text")
        assert "zero_readings" not in page.evaluate("labrig.page.protocol.form.get().pulse_train")


def test_what_only_the_server_knows_is_told_too(fake, visit):
    page = visit(f"{fake.url}#/new")
    page.wait_for_selector("[data-key='pulse_s']")
    sentence = "protocol.toml: sample_at_s must lie within the pulse."
    fake.answers["POST", "/api/files/check"] = {"ok": False, "errors": [sentence], "text": ""}
    field(page, "sample_at_s").fill("0.7")
    page.locator(".file-said").filter(has_text=sentence).wait_for()
    assert page.is_disabled("text=Start the run")


def test_a_changed_protocol_is_saved_before_it_runs(fake, visit):
    page = visit(f"{fake.url}#/new")
    field(page, "readings_per_voltage").fill("3")
    page.wait_for_function("labrig.page.protocol.ready && labrig.page.protocol.touched")
    page.get_by_label("save the changed protocol as").fill("short.toml")
    page.get_by_label("session file").fill("mine.h5")
    page.click("text=Start the run")
    page.wait_for_function("location.hash === '#/run'")
    wanted = ("/api/files/short.toml", "/api/run")  # plans may be asked for meanwhile
    acts = [one for one in fake.asked if one[0] != "GET" and one[1] in wanted]
    (saving, saved_as, saved), (starting, started, run) = acts
    assert (saving, saved_as, starting, started) == ("PUT", wanted[0], "POST", wanted[1])
    assert saved["values"]["pulse_train"]["readings_per_voltage"] == 3
    files = {"protocol": "short.toml", "sheet": "sheet.toml"}
    assert run == {**files, "session": "mine.h5", "clock": "real"}


@pytest.mark.thorough
def test_places_can_be_added_and_removed(fake, visit):
    page = visit(f"{fake.url}#/new")
    page.click("text=Add to places")
    assert page.evaluate("labrig.page.protocol.form.get().places.length") == 3
    page.keyboard.type("long")  # the first field of the new one has the focus
    page.keyboard.press("Tab")
    page.keyboard.type("1, 2.5")
    places = page.evaluate("labrig.page.protocol.form.get().places")
    assert places[2] == {"configuration": "long", "positions_mm": [1, 2.5]}
    for _ in range(3):
        page.locator(".entry >> text=Remove").first.click()
    page.locator(".list .field-fault").filter(has_text="at least 1").wait_for()


@pytest.mark.thorough
def test_a_protocol_is_of_the_one_kind_that_is_chosen(fake, visit):
    page = visit(f"{fake.url}#/new")
    kinds = page.locator("select[data-key='kind']")
    assert kinds.locator("option:checked").inner_text() == "pulse train"
    assert not field(page, "relax_s").is_visible()
    kinds.select_option(label="hold")
    assert not field(page, "pulse_s").is_visible()
    field(page, "relax_s").fill("4")
    said = page.evaluate("labrig.page.protocol.form.get()")
    assert "pulse_train" not in said
    assert said["hold"] == {"relax_s": 4}
    kinds.select_option(label="pulse train")  # what was there has stayed
    assert page.evaluate("labrig.page.protocol.form.get()")["pulse_train"]["pulse_s"] == 0.6


@pytest.mark.thorough
def test_an_extra_is_on_or_off_or_has_values_of_its_own(fake, visit):
    page = visit(f"{fake.url}#/new")
    choice = page.locator("select[data-key='release']")
    swing = field(page, "swing_s")
    assert not swing.is_visible()
    choice.select_option(label="yes")
    assert page.evaluate("labrig.page.protocol.form.get()")["extras"]["release"] is True
    swing.fill("2")
    said = page.evaluate("labrig.page.protocol.form.get()")
    assert said["extras"]["release"] == {"swing_s": 2}
    choice.select_option(label="no")
    assert not swing.is_visible()
    assert page.evaluate("labrig.page.protocol.form.get()")["extras"]["release"] is False


@pytest.mark.thorough
def test_curvature_is_a_number_or_nodes_or_measured(fake, visit):
    page = visit(f"{fake.url}#/new")
    page.click("summary:has-text('Sheet')")
    kinds = page.locator("select[data-key='initial_curvature_per_m']")
    kinds.nth(0).select_option(label="measured")
    kinds.nth(1).select_option(label="curvature")
    said = page.evaluate("labrig.page.sheet.form.get()")
    assert said["long"]["initial_curvature_per_m"] == "measured"
    page.evaluate("labrig.page.sheet.form.faults()")
    assert "needed" in text_of(page, ".page-new .file:nth-child(2)")


def test_the_plan_is_shown_before_anything_is_touched(fake, visit):
    page = visit(f"{fake.url}#/new")
    page.locator(".facts").filter(has_text="up to 2 V of 2.5 V allowed").wait_for()
    facts = text_of(page, ".facts")
    assert "14, 448 readings" in facts
    assert "up to 13.2 s of 30 s" in facts
    assert page.locator(".new .timeline-runs .cell-run").count() == 14
    asked = [body for how, path, body in fake.asked if (how, path) == ("POST", "/api/plan")]
    assert asked[-1] == {"protocol_text": template_text("protocol.toml"), "sheet": "sheet.toml"}


def test_a_schedule_that_is_refused_cannot_be_started(fake, visit):
    sentence = "Run 1 would be under voltage for 40 s, more than the 30 s that are allowed."
    fake.answers["POST", "/api/plan"] = (400, {"error": sentence})
    page = visit(f"{fake.url}#/new")
    page.locator(".fault").filter(has_text=sentence).wait_for()
    assert page.is_disabled("text=Start the run")


@pytest.mark.thorough
def test_preflight_results_are_shown(fake, visit):
    page = visit(f"{fake.url}#/new")
    page.wait_for_selector("[data-key='pulse_s']")
    checks = made_up.checks()
    checks[1] = {**checks[1], "ok": False}
    fake.tell({"type": "preflight", "ok": False, "checks": checks})
    page.locator(".preflight .check-failed").wait_for()
    assert "FAILED output at 0 V +10.0 mV read back" in text_of(page, ".preflight .check-failed")
