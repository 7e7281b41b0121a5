"""Every link of the documentation, README and CONTRIBUTING leads somewhere."""

from __future__ import annotations

import re
import sys
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


def _made() -> dict[Path, str]:
    """The pages that the build makes from the code, with their texts."""
    sys.path.insert(0, str(DOCS))
    try:
        from made import modules_of, pages_of
    finally:
        sys.path.remove(str(DOCS))
    folder = DOCS / "reference" / "made"
    pages = [pages_of(name) for name in modules_of(DOCS / "made")]
    return {folder / f"{name}.md": text for made in pages for name, text in made.items()}


MADE = _made()
DRAWN = {DOCS / "images" / "made" / f"{p.stem}.svg" for p in (DOCS / "drawings").glob("[a-z]*.py")}


@pytest.mark.parametrize("page", [*PAGES, *MADE], ids=lambda page: str(page.relative_to(ROOT)))
def test_links_resolve(page):
    text = _FENCED.sub("", MADE[page] if page in MADE else page.read_text(encoding="utf-8"))
    for target, anchor in _LINK.findall(text):
        to = (page.parent / target).resolve() if target else page
        assert to in MADE or to in DRAWN or to.exists(), f"{page.name}: {target} is not there"
        if anchor and to.suffix == ".md":
            assert anchor in _anchors(to), f"{page.name}: {target} has no heading #{anchor}"


def _anchors(page: Path) -> set[str]:
    text = MADE[page] if page in MADE else page.read_text(encoding="utf-8")
    return {_slug(heading) for heading in _HEADING.findall(_FENCED.sub("", text))}


def _slug(heading: str) -> str:
    plain = re.sub(r"[`*]|\[([^]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")


def test_a_link_to_nowhere_would_be_found():
    assert _LINK.findall("see [here](../nowhere.md#there)") == [("../nowhere.md", "there")]


def test_each_page_is_on_one_of_the_four_shelves():
    shelves = {"tutorials", "howto", "explanation", "reference"}
    pages = [page.relative_to(DOCS) for page in PAGES if DOCS in page.parents]
    astray = [p for p in pages if p.parts[0] not in {*shelves, "index.md", "images"}]
    assert not astray
