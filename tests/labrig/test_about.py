"""about.toml: what is accepted, the sentence for what is not, and its path into the session."""

from __future__ import annotations

import datetime as dt
import json
from pathlib import Path

import h5py
import pytest

from labrig.cli.main import run
from labrig.config import load_about, parse_about
from labrig.config.templates import write_templates
from labrig.errors import BadInputError
from labrig.session import compare_sessions, open_session, verify

FULL = """\
title = "Blocked force of aged sheets"
project = "Sheets 2026"
licence = "cc-by-4.0"
[[people]]
name = "Ada Example"
affiliation = "Example University"
email = "ada@example.org"
orcid = "https://orcid.org/0000-0002-1825-0097"
[[people]]
name = "Bo Contact"
role = "contact"
[sample]
identity = "S-17"
material = "Nafion 117, gold electrodes"
batch = "2026-11"
preparation = "Li+ exchanged, stored in water"
made = 2026-11-02
notes = "one corner is torn"
"""


def test_all_that_about_toml_states_is_understood():
    about = parse_about(FULL, "about.toml")
    assert about.licence == "CC-BY-4.0"
    assert about.operators == ("Ada Example",)
    assert about.people[0].orcid == "0000-0002-1825-0097"
    assert about.people[1].role == "contact"
    assert about.sample is not None
    assert about.sample.made == dt.date(2026, 11, 2)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('licence = "CC-BY-9"', r"about: licence = 'CC-BY-9': should be a licence of the SPDX"),
        ('license = "CC0-1.0"', r"license is not a known key; did you mean licence"),
        (
            '[[people]]\nname = "A"\norcid = "0000-0002-1825-0098"',
            r"entry 1 of \[\[people\]\]: orcid.*check",
        ),
        ('[[people]]\nname = "A"\norcid = "12"', r"orcid = '12': should be an ORCID iD such as"),
        ('[[people]]\nname = "A"\nrole = "boss"', r"role = 'boss': should be 'operator', 'con"),
        ('[[people]]\nname = "A"\nemail = "a.org"', r"email = 'a.org': should be an address"),
        ('[[people]]\nname = " "', r"entry 1 of \[\[people\]\]: name = ' ': should not be empty"),
        ("[[people]]\nrole = 'operator'", r"entry 1 of \[\[people\]\]: name is missing"),
        ("[sample]\nbatch = '1'", r"\[sample\] identity is missing"),
        ("[sample]\nidentity = 'S'\nmade = 3", r"made = 3: should be a date such as 2026-11-21"),
        ("[sample]\nidentity = 17", r"\[sample\] identity = 17: should be a text in quotes"),
        ('title = "a\\u0000b"', r"title = .*: should be text without control characters"),
        ('title = "a\\nb"', r"title = .*: should be one line"),
        (f'title = "{"x" * 201}"', r"title = .*should have at most 200 characters"),
        ('sampel = "S"', r"sampel is not a known key; did you mean sample"),
    ],
)
def test_a_fault_in_about_toml_is_named_with_key_value_and_range(text, said):
    with pytest.raises(BadInputError, match=said):
        parse_about(text, "about")


@pytest.mark.parametrize(
    "orcid", ["0000-0002-1825-0097", "0000-0001-5109-3700", "0000-0002-1694-233X"]
)
def test_the_check_digit_of_orcid_is_computed_as_iso_7064(orcid):
    # Examples of orcid.org; a change of any single digit is found.
    text = '[[people]]\nname = "A"\norcid = "{}"\n'
    assert parse_about(text.format(orcid), "a").people[0].orcid == orcid
    for place in (0, 6, 12, 17):
        other = orcid[:place] + str((int(orcid[place]) + 1) % 10) + orcid[place + 1 :]
        with pytest.raises(BadInputError, match="check digit"):
            parse_about(text.format(other), "a")


def test_init_writes_an_about_toml_that_states_nothing_and_can_be_filled_in(tmp_path):
    write_templates(tmp_path, simulated=True)
    path = tmp_path / "about.toml"
    assert load_about(path).is_empty
    filled = path.read_text().replace("# [", "[").replace("# name", "name").replace("# id", "id")
    path.write_text(filled)
    about = load_about(path)
    assert (about.people[0].name, about.sample.identity) == ("Ada Example", "S-17")


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """A simulated rig's folder with an about.toml, and a protocol that takes a moment."""
    folder = tmp_path_factory.mktemp("about") / "rig"
    write_templates(folder, simulated=True)
    (folder / "about.toml").write_text(FULL)
    (folder / "protocol.toml").write_text(
        "[pulse_train]\nzero_readings = 2\nreadings_per_voltage = 3\n"
        '[[places]]\nconfiguration = "long"\npositions_mm = [10]\n[extras]\nmode = "paper"\n'
    )
    return folder


def measured(rig: Path, output: Path, *more: str) -> int:
    files = [str(rig / f"{name}.toml") for name in ("rig", "protocol", "sheet")]
    return run(["run", *files, "-o", str(output), "--yes", *more])


@pytest.fixture(scope="module")
def recorded(rig):
    path = rig / "s.h5"
    assert measured(rig, path) == 0
    return path


@pytest.mark.slow
def test_a_session_holds_people_and_sample_as_nexus_has_them(recorded):
    with h5py.File(recorded) as file:
        entry = file["session"]
        user, sample = entry["user_1"], entry["sample"]
        assert (user.attrs["NX_class"], sample.attrs["NX_class"]) == ("NXuser", "NXsample")
        assert entry["title"][()] == b"Blocked force of aged sheets"
        assert entry["license"][()] == b"CC-BY-4.0"
        assert user["ORCID"][()] == b"0000-0002-1825-0097"
        assert sample["name"][()] == b"S-17"
        assert sample["preparation_date"][()] == b"2026-11-02"
        sums = {row["dataset"] for row in entry["checksums"][()]}
    assert {b"/session/title", b"/session/user_2/role", b"/session/sample/batch"} <= sums
    assert all(check.ok for check in verify(recorded))
    with open_session(recorded) as session:
        assert session.about == parse_about(FULL, "about")
        assert session.texts["about.toml"] == FULL


@pytest.mark.thorough
@pytest.mark.slow
def test_a_rig_without_about_toml_runs_and_states_nothing(rig, tmp_path, capsys):
    (rig / "about.toml").rename(rig / "away.toml")
    try:
        assert measured(rig, tmp_path / "s.h5") == 0
    finally:
        (rig / "away.toml").rename(rig / "about.toml")
    with open_session(tmp_path / "s.h5") as session:
        assert session.about.is_empty
        assert "about.toml" not in session.texts


@pytest.mark.thorough
def test_another_about_toml_can_be_given(rig, tmp_path, recorded):
    (tmp_path / "other.toml").write_text('title = "Another"\n')
    assert measured(rig, tmp_path / "s.h5", "--about", str(tmp_path / "other.toml")) == 0
    with open_session(tmp_path / "s.h5") as session:
        assert session.about.title == "Another"
    differences = compare_sessions(recorded, tmp_path / "s.h5")
    assert not [text for text in differences if "run_" in text]  # the measurement is the same


def test_a_wrong_about_toml_stops_the_run_before_it_begins(rig, tmp_path, capsys):
    (tmp_path / "bad.toml").write_text('licence = "mine"\n')
    assert measured(rig, tmp_path / "s.h5", "--about", str(tmp_path / "bad.toml")) == 2
    assert "licence = 'mine'" in capsys.readouterr().err
    assert not (tmp_path / "s.h5").exists()


@pytest.mark.slow
def test_the_preflight_names_operator_and_sample(rig, capsys):
    assert run(["check", str(rig / "rig.toml"), "--json"]) == 0
    checks = json.loads(capsys.readouterr().out)["checks"]
    (found,) = [check for check in checks if check["name"] == "operator and sample"]
    assert found["ok"]
    assert found["found"] == "operator Ada Example, sample S-17"


def test_the_about_toml_of_the_docs_is_understood():
    page = (Path(__file__).parents[2] / "docs" / "howto" / "about.md").read_text(encoding="utf-8")
    about = parse_about(page.split("```toml\n")[1].split("```")[0], "docs/howto/about.md")
    assert (about.licence, about.sample.identity) == ("CC-BY-4.0", "S-17")
