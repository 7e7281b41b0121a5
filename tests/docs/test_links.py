"""Every link of the documentation, README and CONTRIBUTING leads somewhere."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(
    path
    for path in [*ROOT.glob("*.md"), ROOT / "benchmarks" / "README.md", *DOCS.rglob("*.md")]
    if "_build" not in path.parts and path.parent.name != "made"
)
_FENCED = re.compile(r"^(`{3,}).*?^\1$", re.DOTALL | re.MULTILINE)
_LINK = re.compile(r"\]\((?!https?:|mailto:)([^)\s#]*)(?:#([^)\s]*))?\)")
_HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)


# Pages that the build makes from the code take seconds: they are made where a test reads them.
_MAKERS = {path.stem: path.read_text() for path in sorted((DOCS / "made").glob("[a-z]*.py"))}
MAKERS = list(_MAKERS)
OF_ONE_PAGE = [name for name, code in _MAKERS.items() if "def page()" in code]  # of its own name
MADE = DOCS / "reference" / "made"
DRAWN = {DOCS / "images" / "made" / f"{p.stem}.svg" for p in (DOCS / "drawings").glob("[a-z]*.py")}


@cache
def pages_made_by(maker: str) -> dict[Path, str]:
    """The pages of one module of docs/made, with their texts."""
    from made import pages_of

    return {MADE / f"{name}.md": text for name, text in pages_of(maker).items()}


def made(page: Path) -> str | None:
    """The text of a page that the build makes; None where no module makes it."""
    if page.parent != MADE:
        return None
    makers = [page.stem] if page.stem in OF_ONE_PAGE else MAKERS
    return next((pages_made_by(m)[page] for m in makers if page in pages_made_by(m)), None)


def is_there(to: Path) -> bool:
    """Whether a link may lead to this file."""
    known = to.parent == MADE and to.stem in OF_ONE_PAGE
    return known or to in DRAWN or to.exists() or made(to) is not None


def check_links(page: Path, text: str) -> None:
    for target, anchor in _LINK.findall(_FENCED.sub("", text)):
        to = (page.parent / target).resolve() if target else page
        assert is_there(to), f"{page.name}: {target} is not there"
        if anchor and to.suffix == ".md":
            assert anchor in _anchors(to), f"{page.name}: {target} has no heading #{anchor}"


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_resolve(page):
    check_links(page, page.read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "maker",
    [
        # All models are run for it, as the build does, which finds a link to nowhere, too.
        pytest.param(name, marks=pytest.mark.thorough) if name == "model_features" else name
        for name in MAKERS
    ],
)
def test_links_of_made_pages_resolve(maker):
    pages = pages_made_by(maker)
    assert pages
    for page, text in pages.items():
        check_links(page, text)


def _anchors(page: Path) -> set[str]:
    text = made(page) or page.read_text(encoding="utf-8")
    return {_slug(heading) for heading in _HEADING.findall(_FENCED.sub("", text))}


def _slug(heading: str) -> str:
    plain = re.sub(r"[`*]|\[([^]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")


_PATH = re.compile(
    r"`((?:benchmarks|docs|drivers|labrig|model|protocols|sim_hardware|tests)/[\w./]+)`"
)
YOURS = ("NAME.py", "NAME.json", "triangle.py")  # files that a reader makes
PAST = ("CHANGELOG.md", "vision_record.md", "worlds_record.md")  # they tell what was


@pytest.mark.parametrize("page", [p for p in PAGES if p.name not in PAST], ids=lambda p: p.stem)
def test_files_that_a_page_names_are_there(page):
    named = _PATH.findall(page.read_text(encoding="utf-8"))
    assert [p for p in named if not p.endswith(YOURS) and not (ROOT / p).exists()] == []


def test_a_link_to_nowhere_would_be_found():
    assert _LINK.findall("see [here](../nowhere.md#there)") == [("../nowhere.md", "there")]


def test_each_page_is_on_one_of_the_four_shelves():
    shelves = {"tutorials", "howto", "explanation", "reference"}
    pages = [page.relative_to(DOCS) for page in PAGES if DOCS in page.parents]
    astray = [p for p in pages if p.parts[0] not in {*shelves, "index.md", "images"}]
    assert not astray
