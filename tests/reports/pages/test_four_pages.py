"""All four pages in headless Chromium, light and dark: accessible, quiet, as wide as a phone, whole in print.

axe-core (npm) is found by the variable AXE_JS of the environment, or in a node_modules folder above this one.
"""

import os
import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

THEMES = pytest.mark.parametrize("theme", ["light", "dark"])
AUDIT = """
const found = await axe.run(document, { resultTypes: ["violations", "incomplete"] });
return found.violations.filter(v => ["serious", "critical"].includes(v.impact))
  .map(v => [v.id, v.nodes.length, v.nodes[0].target.join(" "), v.nodes[0].failureSummary]);
"""
HEADS = "return [...document.querySelectorAll('main th')].map(h => h.innerText).filter(Boolean)"
EDGE = """
const parts = [...document.querySelectorAll("main :is(th, td, p, svg)")];
return Math.max(...parts.map(part => part.getBoundingClientRect().right));
"""
PRINTABLE = 259 / 25.4 * 96
"""Width of US Letter, which is narrower than A4, on its side between margins of 10 mm [CSS pixels]."""


@pytest.fixture(scope="module")
def axe():
    """The program axe-core."""
    beside = [folder / "node_modules" / "axe-core" / "axe.min.js" for folder in Path(__file__).resolve().parents]
    named = [Path(os.environ["AXE_JS"])] if os.environ.get("AXE_JS") else []
    for path in [*named, *beside]:
        if path.is_file():
            return path.read_text(encoding="utf-8")
    pytest.skip("axe-core is not installed: npm install axe-core, or AXE_JS=…/axe.min.js")


@pytest.fixture
def page(browser, any_page):
    """Each page, open; afterwards nothing was logged as an error, nothing asked of the network."""
    browser.events.clear()
    browser.emulate(prefers_color_scheme="light")
    browser.size(1280, 1000)
    browser.open(any_page)
    yield browser
    errors, requests = browser.errors(), browser.requests()
    browser.emulate()
    browser.size(1280, 1000)
    assert errors == []
    assert requests == []


def audited(page, axe, theme):
    page.emulate(prefers_color_scheme=theme)
    page.settle()
    page.run(axe + "\n;window.axe = axe;")
    return page.run(AUDIT)


@THEMES
def test_axe_finds_nothing_serious(page, axe, theme):
    assert audited(page, axe, theme) == []


@THEMES
def test_axe_finds_nothing_serious_in_a_panel(browser, study, axe, theme):
    for list_ in ("instance-list", "run-list"):
        browser.open(study)
        browser.run("document.querySelector(`#${arguments[0]}-table tbody tr`).click()", list_)
        assert audited(browser, axe, theme) == []
    browser.emulate()


@pytest.mark.parametrize("width", [390, 320])
def test_a_phone_scrolls_no_page_sideways(page, any_page, width):
    page.size(width, 800, mobile=True)
    page.open(any_page)
    assert page.run("return document.documentElement.scrollWidth") <= width
    wide = page.run(
        "return [...document.querySelectorAll('.scroll')].filter(s => s.scrollWidth > s.clientWidth).length"
    )
    assert page.run("return document.querySelectorAll('.scroll[tabindex]').length") == wide  # for the keyboard


def test_a_panel_fits_a_phone(browser, study):
    browser.size(390, 800, mobile=True)
    browser.open(study)
    browser.run("document.querySelector('#run-list-table tbody tr').click()")
    body = "return [document.getElementById('panel').scrollWidth, document.getElementById('panel').clientWidth]"
    whole, seen = browser.run(body)
    browser.size(1280, 1000)
    assert whole <= seen


def test_every_column_of_every_table_is_in_print(page, any_page, pdf_text):
    page.run("document.getElementById('theme').click()")  # dark
    heads = [re.sub(r"\s+|[▲▼]", "", text) for text in page.run(HEADS)]
    data = page.pdf(**pdf_text.A4)
    assert set(pdf_text.sizes_of(data)) == {(297, 210)}
    text = "".join(pdf_text.pages_of(data)).replace("ﬁ", "fi").replace("ﬀ", "ff").replace("ﬂ", "fl")
    assert len(heads) > 3
    assert [head for head in heads if head not in text] == []
    page.emulate(media="print", prefers_color_scheme="dark")
    page.size(round(PRINTABLE), 700)
    page.settle()
    edge = page.run(EDGE)
    assert edge <= PRINTABLE + 1
    assert page.run("return document.documentElement.scrollWidth") <= PRINTABLE + 1


def test_dark_prints_as_light(page, any_page, pdf_text):
    light = page.pdf(**pdf_text.A4)
    page.emulate(prefers_color_scheme="dark")
    page.open(any_page, "#theme=dark")
    dark = page.pdf(**pdf_text.A4)
    assert pdf_text.colours_of(dark) == pdf_text.colours_of(light)
    assert (0.0, 0.0, 0.0) in pdf_text.colours_of(dark)


def test_without_javascript_every_row_is_there(browser, any_page):
    browser.size(1280, 1000)
    browser.open(any_page)
    rows = "return [...document.querySelectorAll('main table')].map(t => [t.id, t.tBodies[0].rows.length])"
    count = re.compile(r"<tr>").findall(any_page.read_text(encoding="utf-8"))
    browser.scripts(False)
    browser.open(any_page)
    listed = browser.call("Runtime.evaluate", expression="1", returnByValue=True)
    assert listed["result"]["value"] == 1  # the tools' own scripts still run
    shown = browser.run(rows)
    seen = browser.run(
        "return [...document.querySelectorAll('main tr')].every(r => r.getBoundingClientRect().height > 0)"
    )
    browser.scripts(True)
    assert sum(n for _, n in shown) + len(shown) == len(count)
    assert seen


def test_a_study_without_javascript_lists_all_runs(browser, study):
    browser.scripts(False)
    browser.open(study)
    runs = browser.run("return document.querySelectorAll('#run-list-table tbody tr').length")
    browser.scripts(True)
    assert runs == 132


def test_everything_has_a_name_and_ids_are_unique(page):
    assert page.run("return [...document.querySelectorAll('main svg:not([aria-hidden])')].every(s => s.ariaLabel)")
    assert page.run("return [...document.querySelectorAll('input, select')].every(e => e.labels.length || e.ariaLabel)")
    assert page.run("return [...document.querySelectorAll('main figure')].every(f => f.querySelector('figcaption'))")
    assert (
        page.run("const i = [...document.querySelectorAll('[id]')].map(e => e.id); return i.length - new Set(i).size")
        == 0
    )


def test_the_keyboard_reaches_every_link_button_and_field_in_order(page):
    page.run("document.activeElement.blur(); window.scrollTo(0, 0)")
    page.keys("Tab")
    assert page.run("return document.activeElement.className") == "skip"
    seen = []
    for _ in range(8):
        page.keys("Tab")
        place = page.run("const b = document.activeElement.getBoundingClientRect(); return [b.width, b.height, b.top]")
        seen.append(place)
    assert all(width > 0 and height > 0 and 0 <= top < 1000 for width, height, top in seen)
    outline = page.run("return getComputedStyle(document.activeElement).outlineStyle")
    assert outline != "none"
