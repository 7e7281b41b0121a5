"""The report of a session: complete, self-contained, and honest about what is missing."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from drivers.interfaces import DeviceIdentity
from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.progress import silent
from labrig.report.data.findings import Findings, measured
from labrig.report.data.fitted import FittedSheets
from labrig.report.page.summary import remarks
from labrig.report.page.write import write_report
from labrig.report.parts.svg import inline
from labrig.session import export_session, import_session, open_session, store_measurements
from labrig.session.format.devices import RecordedDevice
from tests.labrig.report_data import TEXTS, invalid, measure, session, stopped_session

pytestmark = pytest.mark.usefixtures("data_unchecked")
VOID = {"meta", "br", "hr", "img", "link", "input"}


class Balanced(HTMLParser):
    """Raises AssertionError where tags do not close in the order they were opened."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.ids += [value for key, value in attrs if key == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.ids += [value for key, value in attrs if key == "id"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def read(path: Path) -> str:
    text = path.read_text(encoding="utf-8")
    parser = Balanced()
    parser.feed(text)
    assert parser.open == []
    return text


@pytest.fixture(scope="module")
def whole(tmp_path_factory, data_unchecked):
    folder = tmp_path_factory.mktemp("report")
    path = session(folder / "made.h5", measure())
    return write_report(path, folder / "out")


@pytest.mark.slow
def test_the_page_is_well_formed_and_names_nothing_twice(whole):
    parser = Balanced()
    parser.feed(whole.read_text(encoding="utf-8"))
    assert parser.open == []
    assert len(parser.ids) == len(set(parser.ids))


@pytest.mark.slow
def test_the_page_asks_no_other_host_for_anything(whole):
    text = read(whole)
    spaces = re.sub(r'xmlns(:\w+)?="[^"]*"', "", text)
    assert "http://" not in spaces
    assert "https://" not in spaces
    assert "<script" not in text
    assert all(
        link.startswith(("#", "data:")) for link in re.findall(r'(?:href|src)="([^"]*)"', text)
    )
    assert "default-src 'none'" in text


@pytest.mark.slow
def test_the_page_has_the_papers_tables_and_figures(whole):
    text = read(whole)
    for number in (3, 4, 5, 6):
        assert f"Table {number}." in text
    for number in (5, 6, 7, 8, 9):
        assert f"Figure {number}." in text
    for quoted in ("0.322", "0.622", "0.424", "2.23"):
        assert f'class="quoted">{quoted}<' in text
    files = {path.name for path in (whole.parent / "figures").iterdir()}
    names = [f"figure-{number}" for number in (5, 6, 7, 8, 9)] + ["table-5"]
    wanted = {f"{name}.{kind}" for name in names for kind in ("png", "svg")}
    assert wanted <= files
    assert not [name for name in files if name.endswith(".part")]


@pytest.mark.slow
def test_each_error_of_constant_eibm_says_what_was_held_or_refitted(whole):
    """Three errors of one name once stood in the report, each of another fit."""
    text = re.sub(r"<svg.*?</svg>", "", read(whole), flags=re.DOTALL)
    blocks = re.findall(
        r'<figure.*?</figure>|<div class="scroll".*?</div>|<div class="card">.*?</div>',
        text,
        flags=re.DOTALL,
    )
    of_errors = [
        block
        for block in blocks
        if "constant eibm" in block.lower() and re.search(r"RMSE|Root mean|error|simulated", block)
    ]
    assert len(of_errors) >= 7  # 2 cards, tables 5 and 6, 2 figures, errors of each condition
    for block in of_errors:
        rows = re.findall(r"<dt>([^<]*constant EIBM[^<]*)</dt>", block) or [block]
        assert all("B held" in row or "refitted" in row for row in rows), block[:300]


@pytest.mark.slow
def test_the_page_holds_what_the_session_was_made_with(whole):
    text = read(whole)
    assert "free_length_mm = 50.0" in text
    assert "sensitivity_V_per_N" in text
    assert "All runs were done." in text
    assert "is left out" not in text


@pytest.mark.slow
def test_figures_take_the_colour_of_the_page(whole):
    svg = re.findall(r"<svg.*?</svg>", read(whole), re.DOTALL)
    assert len(svg) >= 6
    assert all("currentColor" in one and "#1b1f24" not in one for one in svg)


@pytest.mark.thorough
def test_a_second_report_removes_the_figures_that_it_no_longer_has(tmp_path):
    out = tmp_path / "out"
    write_report(session(tmp_path / "made.h5", measure("long")), out)
    assert (out / "figures" / "figure-7.png").exists()
    write_report(stopped_session(tmp_path / "bare.h5", after_runs=0), out)
    assert not (out / "figures" / "figure-7.png").exists()


@pytest.mark.thorough
@pytest.mark.usefixtures("words_only")
def test_one_configuration_alone_is_reported_and_said(tmp_path):
    text = read(write_report(session(tmp_path / "made.h5", measure("long"))))
    assert "Only the configuration long was measured." in text
    assert "short, this session" not in text


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
def test_a_session_without_valid_readings_gets_a_page_that_says_why(tmp_path):
    stuck = invalid(measure("long"), "long", "the sheet <stuck> in the rolls")
    text = read(write_report(session(tmp_path / "made.h5", stuck)))
    assert "The configuration long could not be fitted" in text
    assert "&lt;stuck&gt;" in text
    assert "<stuck>" not in text
    assert "Table 4." not in text
    assert "Figure 7." in text


def test_whoever_reads_a_session_stopped_half_way_is_told(tmp_path):
    """`labrig fit` said only what it had left out, and that was not all that is missing."""
    path, told = stopped_session(tmp_path / "half.h5", after_runs=1), []
    store_measurements(path, measure("long"))
    measured(path, silent, told.append)
    (text,) = told
    assert "half.h5: this session was not completed (aborted): 1 of its 4 runs" in text


@pytest.mark.thorough
@pytest.mark.usefixtures("words_only")
def test_a_session_stopped_half_way_is_analysed_and_reported(tmp_path):
    path = stopped_session(tmp_path / "half.h5", after_runs=1)
    told = []
    text = read(write_report(path, tell=told.append))
    assert "not completed (aborted): 1 of its 4 runs are complete" in told[0]
    assert "not analysed yet" in told[1]
    assert "The session did not end as planned: aborted (stopped by Ctrl-C)." in text
    assert "1 of 4" in text


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
def test_a_session_in_which_nothing_was_run_gets_a_page_all_the_same(tmp_path):
    text = read(write_report(stopped_session(tmp_path / "none.h5", after_runs=0)))
    assert "Nothing could be measured" in text
    assert "Figure 5." not in text


@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
def test_texts_of_a_session_cannot_put_markup_into_the_page(tmp_path):
    evil = "# </pre><script>alert(1)</script>\n" + TEXTS["sheet.toml"]
    path = session(tmp_path / "evil.h5", None, texts=TEXTS | {"sheet.toml": evil})
    text = read(write_report(path))
    assert "<script" not in text
    assert "&lt;script&gt;" in text


def test_a_file_where_the_folder_should_be_is_refused(tmp_path):
    path = session(tmp_path / "made.h5", None)
    (tmp_path / "out").write_text("mine")
    with pytest.raises(BadInputError, match="a folder is needed"):
        write_report(path, tmp_path / "out")


HEAD = '<!DOCTYPE html><meta name="generator" content="labrig 0.1">'


@pytest.mark.parametrize(
    ("command", "page", "said"),
    [
        ("report", "<h1>My own page</h1>", "this is no page of labrig's; give another folder"),
        ("report", HEAD, "this page is a diagnosis (labrig diagnose); give another folder"),
        ("diagnose", "<h1>My own page</h1>", "this is no page of labrig's; give another folder"),
        ("diagnose", f'{HEAD}<meta name="labrig-session-state" content="1">',
         "this page is a session's (labrig report); give another folder"),
    ],
)  # fmt: skip
def test_a_page_of_another_kind_is_not_replaced(command, page, said, tmp_path, capsys):
    path = session(tmp_path / "made.h5", None)
    (tmp_path / "index.html").write_text(page, encoding="utf-8")
    option = {"report": "-o", "diagnose": "--report"}[command]
    assert run([command, str(path), option, str(tmp_path)]) == 2
    assert said in " ".join(capsys.readouterr().err.split())
    assert (tmp_path / "index.html").read_text(encoding="utf-8") == page


def test_a_folder_that_cannot_be_made_is_told_before_the_session_is_analysed(tmp_path):
    path = session(tmp_path / "made.h5", measure("long"))
    (tmp_path / "file").write_text("")
    told = []
    with pytest.raises(BadInputError, match="cannot be written"):
        write_report(path, tmp_path / "file" / "out", progress=lambda *_: told.append(1))
    assert not told


def test_what_is_no_session_is_refused_before_anything_is_written(tmp_path):
    (tmp_path / "made.h5").write_text("no")
    with pytest.raises(BadInputError, match="not an HDF5 file"):
        write_report(tmp_path / "made.h5")
    assert not (tmp_path / "made-report").exists()


def test_an_inline_figure_has_names_of_its_own_and_no_metadata():
    svg = (
        '<?xml version="1.0"?>\n<!DOCTYPE svg>\n<svg width="72pt" height="36.5pt" '
        'viewBox="0 0 72 36.5"><metadata>who</metadata><defs><path id="a"/></defs>'
        '<use xlink:href="#a" clip-path="url(#b)" style="stroke: #1b1f24"/></svg>'
    )
    text = inline(svg, "figure-5", 'a "b" <c>')
    assert text.startswith("<svg role")
    assert 'id="figure-5-a"' in text
    assert 'href="#figure-5-a"' in text
    assert "url(#figure-5-b)" in text
    assert "who" not in text
    assert 'width="72pt"' not in text
    assert "max-width: 108px" in text
    assert "stroke: currentColor" in text
    assert "a &quot;b&quot; &lt;c>" in text


@pytest.mark.thorough
@pytest.mark.usefixtures("words_only")
def test_imported_tables_are_reported_without_what_only_a_recording_has(tmp_path):
    path = session(tmp_path / "made.h5", measure("long"))
    forces, curves, *_ = export_session(path, tmp_path / "csv")
    sheet = tmp_path / "sheet.toml"
    sheet.write_text(TEXTS["sheet.toml"], encoding="utf-8")
    import_session(sheet, forces, tmp_path / "imported.h5", curves=curves)
    text = read(write_report(tmp_path / "imported.h5"))
    assert "imported tables" in text
    assert "Table 4." in text
    assert "Figure 5." not in text
    assert "The output was left" not in text
    assert "Saturation" not in text


@pytest.mark.slow
def test_many_warnings_are_counted_at_the_top(tmp_path):
    many = replace(
        measure("long", curves=False), warnings=tuple(f"curve {i} is odd" for i in range(30))
    )
    with open_session(session(tmp_path / "made.h5", many)) as opened:
        said = remarks(
            Findings(session=opened, measurements=many, fitted=FittedSheets(None), why_not="")
        )
    assert said[-1] == "22 more are listed with the data's quality."
    assert sum("is odd" in text for text in said) == 8


@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
@pytest.mark.thorough
def test_the_page_says_of_the_boards_what_they_reported_and_nothing_else(tmp_path):
    def device(simulated: bool) -> RecordedDevice:
        identity = DeviceIdentity(name="PCI6703", product="PCI-6703", is_simulated=simulated)
        return RecordedDevice(part="boards", kind="ni", identity=identity)

    for name, devices, wanted in (
        ("simulated", (device(True),), "boards: simulated"),
        ("real", (device(False),), "boards: real"),
        ("silent", (), "boards: not known"),
    ):
        path = session(
            tmp_path / f"{name}.h5", None, devices=devices, simulated=name == "simulated"
        )
        text = read(write_report(path))
        assert wanted in text, name
        assert ("PCI-6703" in text) == bool(devices)


@pytest.mark.thorough
@pytest.mark.usefixtures("words_only")
def test_the_experiments_title_stands_above_the_page_where_one_is_stated(tmp_path):
    about = 'title = "Water and back relaxation"\n[[people]]\nname = "Ada Example"\n'
    text = read(
        write_report(session(tmp_path / "made.h5", None, texts=TEXTS | {"about.toml": about}))
    )
    assert "<h1>Water and back relaxation</h1>" in text
    assert "made.h5: pulse train" in text
    assert "Ada Example" in text
