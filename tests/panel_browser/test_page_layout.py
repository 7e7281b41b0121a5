"""Nothing is cut, on a desk or on a phone."""

from __future__ import annotations

import pytest

from tests.cases import few
from tests.panel_browser.every_page import every_page

PAGES = every_page()

SIZES = {"desk": (1440, 900), "laptop": (1280, 800), "phone": (390, 844)}


@pytest.mark.parametrize(
    "sizes", [("laptop", "phone"), pytest.param(("desk",), marks=pytest.mark.thorough)]
)
@pytest.mark.parametrize("name", few(PAGES, "run", "new", "library"))
def test_nothing_is_wider_than_what_it_stands_in(turn_to, name, sizes):
    for where in sizes:
        page = turn_to(name, *SIZES[where])
        page.wait_for_timeout(300)
        assert page.evaluate(CUT) == [], where


# What sticks out of the window, and boxes whose content is wider than they are.
CUT = """() => {
  const name = (it) =>
    `${it.tagName.toLowerCase()}${it.id ? '#' + it.id : ''}.${[...it.classList].join('.')}: ` +
    (it.innerText ?? '').trim().slice(0, 40);
  const hidden = (it) => it.closest('.visually-hidden, .skip, [hidden], svg, option, .uplot');
  const found = [];
  for (const it of document.body.querySelectorAll('*')) {
    if (hidden(it)) continue;
    const box = it.getBoundingClientRect();
    if (!box.width || !box.height) continue;
    if (box.right > innerWidth + 1 || box.left < -1) found.push(`outside: ${name(it)}`);
    if (getComputedStyle(it).display !== 'inline' && it.scrollWidth > it.clientWidth + 2
        && !['INPUT', 'SELECT', 'TEXTAREA'].includes(it.tagName))
      found.push(`cut: ${name(it)} (${it.scrollWidth} in ${it.clientWidth})`);
  }
  return found.slice(0, 12);
}"""


@pytest.mark.parametrize("name", few(PAGES, "new"))
def test_labels_stand_above_their_fields_on_a_phone(turn_to, name):
    page = turn_to(name, *SIZES["phone"])
    assert page.evaluate(BESIDE) == []


BESIDE = """() => {
  const fields = document.querySelectorAll('main input, main select, main textarea');
  const beside = (it) => {
    if (['checkbox', 'radio', 'hidden', 'file'].includes(it.type) || !it.offsetParent) return false;
    const label = it.labels?.[0];
    if (!label || label.closest('.visually-hidden')) return false;
    const words = document.createRange();
    const text = [...label.childNodes].find((n) => n.textContent.trim() && !n.contains(it));
    if (!text) return false;
    words.selectNodeContents(text);
    return words.getBoundingClientRect().bottom > it.getBoundingClientRect().top + 2;
  };
  return [...fields].filter(beside).map((it) => it.labels[0].innerText.slice(0, 40));
}"""


@pytest.mark.parametrize("width", [1280, pytest.param(1440, marks=pytest.mark.thorough)])
def test_the_table_of_single_readings_shows_all_its_columns(turn_to, width):
    page = turn_to("run", width, 800)
    page.wait_for_selector(".readings-single td")
    hidden = page.locator(".readings-single .scroll").evaluate(
        "(box) => box.scrollWidth - box.clientWidth"
    )
    assert hidden <= 0
