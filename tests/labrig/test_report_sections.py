"""The report's sections: each a plug-in, ours and those of other distributions."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

import pytest

from drivers.plugins import PluginFolder, PluginWarning
from labrig.errors import BadInputError
from labrig.report.data.findings import Findings
from labrig.report.data.fitted import FittedSheets
from labrig.report.page.page import render
from labrig.report.page.sections import ReportContent, report_content
from labrig.report.page.write import write_report
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Folded, Section
from labrig.report.parts.style import figure
from labrig.report.parts.table import Table
from labrig.report.sections.conformance import content_faults, faults
from labrig.report.sections.interface import SECTIONS, ReportSection, ordered
from labrig.session import Mark, add_mark, open_session
from tests.cases import few
from tests.labrig.report_data import measure, session, stopped_session

pytestmark = pytest.mark.usefixtures("data_unchecked")

DOCS = Path(__file__).parents[2] / "docs" / "howto" / "report.md"


def documented(language: str) -> str:
    """The example of docs/howto/report.md in this language, as it stands there."""
    (found,) = re.findall(rf"```{language}\n(.*?)```", DOCS.read_text("utf-8"), re.DOTALL)
    return str(found)


@pytest.fixture
def findings(tmp_path):
    with open_session(session(tmp_path / "made.h5", None)) as opened:
        yield Findings(
            session=opened, measurements=None, fitted=FittedSheets(None), why_not="it was not tried"
        )


def made(title: str, make, order: float = 1.0, figures: tuple[str, ...] = ()) -> ReportSection:
    return ReportSection(
        title=title, order=order, applies=lambda _findings: True, make=make, figures=figures
    )


def content(findings: Findings, folder: Path, *sections: ReportSection) -> ReportContent:
    known = {f"part{i}": section for i, section in enumerate(sections)}
    return report_content(findings, FigureFolder(folder / "figures"), known)


@pytest.mark.slow
def test_marks_stand_in_the_report_with_who_when_and_why(tmp_path):
    path = session(tmp_path / "marked.h5", None)
    add_mark(path, Mark(run=1, reading=None, why="a bubble", who="A. P."))
    add_mark(path, Mark(run=1, reading=None, why="it had gone", who="B. Q.", invalid=False))
    with open_session(path) as opened:
        found = Findings(
            session=opened, measurements=None, fitted=FittedSheets(None), why_not="it was not tried"
        )
        sections = {name: SECTIONS.get(name) for name in ("marks", "record")}
        assert sections["marks"].applies(found)
        figures = FigureFolder(tmp_path / "figures")
        made, record = (one.make(found, figures) for one in sections.values())
        when = opened.marks_after_end[0].when[:16].replace("T", " ")
    (table,) = made.items
    assert table.rows == (
        ("2", "whole run", "invalid", "a bubble", "A. P.", when),
        ("2", "whole run", "mark taken back", "it had gone", "B. Q.", when),
    )
    assert "2 after its end" in made.sentences[0]
    assert not any("Marks" in getattr(item, "title", "") for item in record.items)


@pytest.mark.slow
def test_a_report_without_marks_has_no_section_of_them(findings):
    assert not SECTIONS.get("marks").applies(findings)


@pytest.mark.parametrize("name", SECTIONS.parts())
def test_each_of_our_sections_keeps_the_contract(name):
    assert faults(SECTIONS.get(name)) == []


def test_each_fault_of_a_section_is_named():
    class Odd:
        title, order, applies, make, figures = " ", float("nan"), None, 1, ("../out",)

    assert len(faults(Odd())) == 5
    assert len(faults("no section")) >= 4


def test_sections_stand_in_the_order_of_their_numbers():
    orders = [section.order for section in ordered().values()]
    assert orders == sorted(orders)


@pytest.mark.slow
def test_a_section_that_fails_is_left_out_with_a_sentence_and_the_others_are_written(
    findings, tmp_path
):
    def fail(_findings, _figures):
        raise KeyError("temperature_K")

    found = content(
        findings, tmp_path, made("Climate", fail), made("Words", lambda *_: "All is well.")
    )
    assert [section.title for section in found.sections] == ["Words"]
    assert found.left_out == (
        (
            "The section 'Climate' (part0) is left out: its `make` failed with KeyError: "
            "'temperature_K'."
        ),
    )
    text = render(findings, found)
    assert "All is well." in text
    assert "(part0) is left out" in text


@pytest.mark.slow
def test_a_section_that_fails_names_the_distribution_that_it_is_of(findings, tmp_path, monkeypatch):
    monkeypatch.setattr(PluginFolder, "origins", lambda _folder: {"part0": "weather 0.3"})
    found = content(findings, tmp_path, made("Climate", lambda *_: 1 / 0))
    assert "The section 'Climate' (part0 of weather 0.3) is left out: " in found.left_out[0]


def test_a_section_that_cannot_decide_whether_it_applies_is_left_out_too(findings, tmp_path):
    def fail(_findings):
        raise RuntimeError("no idea")

    odd = ReportSection(title="Odd", order=0, applies=fail, make=lambda *_: "never")
    found = content(findings, tmp_path, odd)
    assert found.sections == ()
    assert "its `applies` failed with RuntimeError: no idea." in found.left_out[0]


def test_a_section_that_ends_the_program_is_left_out_too(findings, tmp_path):
    def leave(*_):
        sys.exit(3)

    found = content(
        findings, tmp_path, made("Climate", leave), made("Words", lambda *_: "All is well.")
    )
    assert [section.title for section in found.sections] == ["Words"]
    assert found.left_out[0].endswith("is left out: its `make` failed with SystemExit: 3.")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "says"),
    few(
        [
            (lambda *_: None, "neither a Section nor a sentence"),
            (lambda *_: Section(("text",)), "neither a table nor a figure"),
            (
                lambda *_: Section((Table(title="T", columns=("a", "b"), rows=(("1",),)),)),
                "not as many cells",
            ),
            (
                lambda *_: Section(
                    (Folded("F", Table(title="", columns=("a",), rows=(("1", "2"),))),)
                ),
                "not as many cells",
            ),
            (lambda *_: "  ", "its sentence is empty"),
        ]
    ),
)
def test_content_that_the_page_cannot_show_is_left_out(make, says, findings, tmp_path):
    found = content(findings, tmp_path, made("Odd", make))
    assert found.sections == ()
    assert says in found.left_out[0]
    assert content_faults(make())


@pytest.mark.parametrize(
    ("made_of", "says"),
    [
        (
            Section((Table(title="T", columns=("a", "b"), rows=(("1", 2.5),)),)),
            "a cell of the table 'T' must be a text, not 2.5 (float)",
        ),
        (Section(sentences=("All is well.", None)), "a sentence must be a text, not None"),
    ],
)
def test_a_section_with_what_is_no_text_is_left_out_and_the_page_is_written(
    made_of, says, findings, tmp_path
):
    found = content(findings, tmp_path, made("Odd", lambda *_: made_of))
    assert found.sections == ()
    assert says in found.left_out[0]


def dot():
    with figure(1.0, 1.0) as fig:
        fig.subplots().plot([0], [0], "o")
        return fig


def draw_dot(_findings, figures):
    return Section(figures.draw("dot", "Dot", "A dot.", dot))


@pytest.mark.slow
def test_two_sections_or_figures_of_one_name_cannot_stand_on_a_page(findings, tmp_path):
    found = content(
        findings, tmp_path,
        made("Same", lambda *_: "first"), made("same", lambda *_: "second"),
        made("One", draw_dot, figures=("dot",)), made("Two", draw_dot, figures=("dot",)),
    )  # fmt: skip
    assert [section.title for section in found.sections] == ["Same", "One"]
    assert "called same already" in found.left_out[0]
    assert "two figures called dot" in found.left_out[1]


@pytest.mark.parametrize("name", ["../out", "dots"])
def test_a_figure_that_a_section_does_not_list_is_not_written(name, findings, tmp_path):
    def draw(_findings, figures):
        return Section(figures.draw(name, "Dot", "A dot.", dot))

    found = content(findings, tmp_path, made("Dot", draw, figures=("dot",)))
    assert f"the figure {name} is not among its figures" in found.left_out[0]
    assert [path.name for path in tmp_path.rglob("*.png")] == []


@pytest.mark.slow
def test_figures_that_are_no_longer_drawn_lose_their_files(findings, tmp_path):
    figures = tmp_path / "figures"
    figures.mkdir()
    (figures / "mine.png").write_bytes(b"mine")
    drawn = content(findings, tmp_path, made("Dot", draw_dot, figures=("dot",)))
    assert drawn.sections[0].items[0].svg.startswith("<svg")
    assert (figures / "dot.png").exists()
    content(findings, tmp_path, made("Dot", lambda *_: "none", figures=("dot",)))
    assert [path.name for path in figures.iterdir()] == ["mine.png"]


@pytest.mark.slow
def test_a_figure_that_cannot_be_written_ends_the_report(findings, tmp_path):
    (tmp_path / "figures" / "dot.png").mkdir(parents=True)
    with pytest.raises(BadInputError, match="dot"):
        content(findings, tmp_path, made("Dot", draw_dot, figures=("dot",)))


@pytest.fixture
def distribution(tmp_path, monkeypatch):
    """`labrig-every-force` 0.3: the section of the docs, and one that is none."""
    code = documented("python")
    (tmp_path / "labrig_every_force.py").write_text(code + 'BAD = "no section"\n')
    info = tmp_path / "labrig_every_force-0.3.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: labrig-every-force\nVersion: 0.3\n"
    )
    points = tomllib.loads(documented("toml"))["project"]["entry-points"]
    lines = [f"{name} = {point}" for name, point in points["labrig.report_sections"].items()]
    lines += ["bad = labrig_every_force:BAD"]
    (info / "entry_points.txt").write_text("\n".join(["[labrig.report_sections]", *lines]))
    monkeypatch.syspath_prepend(tmp_path)
    yield
    sys.modules.pop("labrig_every_force", None)


AGAIN = """
from labrig import ReportSection
SECTION = ReportSection(
    title="quality  of the Data", order=0, applies=lambda found: True, make=lambda *_: "Well."
)
"""


def test_a_section_whose_title_is_taken_is_left_out_though_it_would_stand_first(
    tmp_path, monkeypatch
):
    (tmp_path / "labrig_again.py").write_text(AGAIN)
    info = tmp_path / "labrig_again-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: labrig-again\nVersion: 1\n")
    (info / "entry_points.txt").write_text("[labrig.report_sections]\nagain = labrig_again:SECTION")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.warns(PluginWarning) as told:
        known = ordered()
    assert "again" not in known
    assert known["quality"].title == "Quality of the data"
    (said,) = (str(one.message) for one in told if "'again'" in str(one.message))
    assert said == (
        "the report section 'again' of labrig-again is left out: there is a section with "
        "the title 'Quality of the data' already ('quality' of labrig)."
    )


def test_a_section_with_a_figure_of_ours_is_left_out_and_costs_ours_nothing(tmp_path, monkeypatch):
    code = AGAIN.replace("quality  of the Data", "Mine").replace(
        "order=0,", 'order=0, figures=("mine", "frames"),'
    )
    (tmp_path / "labrig_again.py").write_text(code)
    info = tmp_path / "labrig_again-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: labrig-again\nVersion: 1\n")
    (info / "entry_points.txt").write_text("[labrig.report_sections]\nagain = labrig_again:SECTION")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "labrig_again", raising=False)
    with pytest.warns(PluginWarning) as told:
        known = ordered()
    assert "again" not in known
    (said,) = (str(one.message) for one in told if "'again'" in str(one.message))
    assert "there is a section with the figure 'frames' already ('" in said


@pytest.mark.slow
def test_the_section_of_the_docs_stands_where_its_order_puts_it(distribution, tmp_path):
    path = session(tmp_path / "long.h5", measure("long", curves=False))
    with pytest.warns(PluginWarning, match="report section 'bad' of labrig-every-force"):
        page = write_report(path)
    text = page.read_text(encoding="utf-8")
    order = ("Simulation and measurement", "Every force", "Quality of the data")
    headings = [text.index(f">{title}</h2>") for title in order]
    assert headings == sorted(headings)
    assert "every_force (labrig-every-force 0.3)" in text
    assert (page.parent / "figures" / "every-force.svg").exists()


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
def test_a_section_does_not_appear_where_it_does_not_apply(distribution, tmp_path):
    path = stopped_session(tmp_path / "none.h5", after_runs=0)
    with pytest.warns(PluginWarning):
        text = write_report(path).read_text(encoding="utf-8")
    assert ">Every force</h2>" not in text
    assert "left out" not in text
