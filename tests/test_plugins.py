"""The loader of plug-in folders."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from drivers import plugins
from drivers.plugins import PluginFolder, PluginWarning, UnknownPartError, first_faults

ROOT = Path(__file__).parents[1]


def folder() -> PluginFolder[object]:
    def faults(part: object) -> list[str]:
        return [] if isinstance(part, int) else ["it is no number"]

    return PluginFolder(
        what="number",
        package="numbers_of_a_test",
        constant="NUMBER",
        group="labrig.test_numbers",
        faults=faults,
    )


@pytest.fixture
def numbers(tmp_path, monkeypatch):
    package = tmp_path / "numbers_of_a_test"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "one.py").write_text("NUMBER = 1\n")
    (package / "helper.py").write_text("x = 0\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for name in [n for n in sys.modules if n.startswith("numbers_of_a_test")]:
        del sys.modules[name]


def install(where: Path, name: str, point: str, code: str) -> None:
    (where / f"{name}.py").write_text(code)
    info = where / f"{name}-1.2.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(f"[labrig.test_numbers]\n{point}\n")


def test_a_module_with_the_constant_is_a_part(numbers):
    assert {name: p.part for name, p in folder().parts().items()} == {"one": 1}
    assert folder().origins() == {}


def test_an_entry_point_is_a_part_and_its_origin_is_known(numbers, monkeypatch):
    install(numbers, "more_numbers", "two = more_numbers:TWO", "TWO = 2\n")
    assert folder().get("two") == 2
    assert folder().origins() == {"two": "more_numbers 1.2"}


@pytest.mark.parametrize(
    ("point", "said"),
    [
        ("two = bad_numbers:WORD", "it is no number"),
        ("two = bad_numbers:NONE", "has no attribute 'NONE'"),
        ("one = bad_numbers:TWO", "there is a number of that name already"),
    ],
)
def test_a_part_that_cannot_be_used_is_left_out_with_a_sentence(numbers, point, said):
    install(numbers, "bad_numbers", point, "TWO = 2\nWORD = 'two'\n")
    with pytest.warns(PluginWarning, match="is left out") as caught:
        parts = folder().parts()
    assert said in str(caught[0].message)
    assert list(parts) == ["one"]
    sys.modules.pop("bad_numbers", None)


def test_of_two_parts_that_claim_the_same_the_first_is_kept_and_the_other_named(numbers):
    install(numbers, "same_numbers", "also_one = same_numbers:ONE", "ONE = 1\n")
    of_numbers = replace(folder(), claim=lambda part: f"its value {part}")
    with pytest.warns(PluginWarning, match="left out: its value 1 is that of the number 'one'"):
        assert list(of_numbers.parts()) == ["one"]
    sys.modules.pop("same_numbers", None)


@pytest.mark.parametrize(
    ("faults", "said"),
    [
        (lambda _: ["a is wrong"] * 5 + list("bcdef"), "left out: a is wrong; b; c; and 3 more."),
        (lambda _: ["nobody looked.", "it is not there."], "nobody looked; it is not there."),
        (lambda part: part / 0, "left out: its code raised ZeroDivisionError: division by zero ("),
    ],
)
def test_the_sentence_about_a_part_is_short_and_says_who_raised_what(numbers, faults, said):
    install(numbers, "bad_numbers", "two = bad_numbers:TWO", "TWO = 2\n")
    with pytest.warns(PluginWarning, match="is left out") as caught:
        replace(folder(), faults=faults).parts()
    assert said in str(caught[0].message)
    sys.modules.pop("bad_numbers", None)


def test_a_part_that_cannot_be_called_as_the_contract_says_names_no_line_of_ours():
    (said,) = first_faults([len])
    assert said == "its code raised TypeError: len() takes exactly one argument (0 given)"


def test_what_fails_when_a_part_is_loaded_is_told_with_its_file_and_line(numbers):
    install(numbers, "hasty_numbers", "two = hasty_numbers:TWO", "ONE = 1\nTWO = len()\n")
    with pytest.warns(PluginWarning, match=r"\(0 given\) \(hasty_numbers\.py, line 2\)\.$"):
        assert list(folder().parts()) == ["one"]
    sys.modules.pop("hasty_numbers", None)


def test_a_module_that_ends_python_when_it_is_imported_ends_nothing_else(numbers):
    install(numbers, "ending_numbers", "two = ending_numbers:TWO", "import sys; sys.exit(3)\n")
    with pytest.warns(PluginWarning, match="loading it failed with SystemExit: 3"):
        assert list(folder().parts()) == ["one"]


@pytest.mark.parametrize("error", ["GeneratorExit", "BaseException('gone')"])
def test_nothing_that_a_part_raises_when_it_is_loaded_ends_the_program(numbers, error):
    install(numbers, "raising_numbers", "two = raising_numbers:TWO", f"raise {error}\n")
    with pytest.warns(PluginWarning, match="loading it failed with"):
        assert list(folder().parts()) == ["one"]


def test_one_part_is_had_without_loading_any_other(numbers):
    install(numbers, "bystander_numbers", "two = bystander_numbers:TWO", "raise KeyError\n")
    assert folder().get("one") == 1
    assert "bystander_numbers" not in sys.modules
    (numbers / "numbers_of_a_test" / "broken.py").write_text("raise KeyError\n")
    assert folder().get("one") == 1
    assert folder().find("three") is None
    assert folder().find("../one") is None
    assert folder().find("helper") is None


def test_of_two_parts_of_a_name_the_one_that_can_be_used_is_taken(numbers):
    install(numbers, "bad_numbers", "two = bad_numbers:WORD", "WORD = 'two'\n")
    install(numbers, "good_numbers", "two = good_numbers:TWO", "TWO = 2\n")
    of_numbers = folder()
    with pytest.warns(PluginWarning, match="it is no number"):
        assert of_numbers.get("two") == 2
    assert of_numbers.parts()["two"].part == 2  # what is wrong with the other was told
    for name in ("bad_numbers", "good_numbers"):
        sys.modules.pop(name, None)


def test_a_part_that_takes_long_to_load_is_named_meanwhile(numbers, monkeypatch):
    monkeypatch.setattr(plugins, "_SLOW_S", 0.05)
    code = "import time; time.sleep(0.3)\nTWO = 2\n"
    install(numbers, "slow_numbers", "two = slow_numbers:TWO", code)
    with pytest.warns(PluginWarning, match=r"'two' of slow_numbers .* takes long to load"):
        assert folder().get("two") == 2


def test_an_unknown_name_is_answered_with_those_there_are(numbers):
    with pytest.raises(UnknownPartError, match=r"no number 'on'; choose one of: one .*'one'"):
        folder().get("on")


def test_the_three_copies_of_the_loader_are_one():
    texts = {(ROOT / p / "plugins.py").read_text() for p in ("drivers", "model", "sim_hardware")}
    assert len(texts) == 1
