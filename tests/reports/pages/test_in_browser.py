"""The study's page in headless Chromium: sorting, filtering, panels, the address, themes and keys work."""

import json
import re

import pytest

from reports.pages.page import embedded

pytestmark = pytest.mark.slow


@pytest.fixture
def page(browser, study):
    """The page open in the browser; afterwards nothing was logged as an error, nothing asked of the network."""
    browser.events.clear()
    browser.emulate(prefers_color_scheme="light")
    browser.open(study)
    yield browser
    assert browser.errors() == []
    assert browser.requests() == []


COLUMN = """
const table = document.getElementById(arguments[0]), i = arguments[1];
return [...table.tBodies[0].rows].map(row => row.cells[i].textContent);
"""
PRESS = "document.querySelectorAll(`#${arguments[0]} thead button`)[arguments[1]].click();"


def figures(texts):
    return [float(t.replace(",", "").replace("%", "").replace("<", "").replace("−", "-")) for t in texts if t != "–"]


def test_static_tables_sort_both_ways_with_the_missing_last(page):
    column = page.run(
        "return [...document.querySelectorAll('#summary-table th')].findIndex(h => /proof/.test(h.textContent))"
    )
    for way in ("ascending", "descending"):
        page.run(PRESS, "summary-table", column)
        texts = page.run(COLUMN, "summary-table", column)
        values = figures(texts)
        assert values == sorted(values, reverse=way == "descending")
        assert all(t == "–" for t in texts[len(values) :])
        assert page.run("return document.querySelectorAll('#summary-table th')[arguments[0]].ariaSort", column) == way


def test_runs_sort_filter_and_search(page):
    page.run(PRESS, "run-list-table", 4)
    values = figures(page.run(COLUMN, "run-list-table", 4))
    assert len(values) > 10
    assert values == sorted(values)
    choose = (
        "const s = document.getElementById(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('input'));"
    )
    page.run(choose, "run-list-method", "milp")
    assert set(page.run(COLUMN, "run-list-table", 1)) == {"milp"}
    page.run(choose, "run-list-status", "OPTIMAL")
    assert set(page.run(COLUMN, "run-list-table", 3)) == {"OPTIMAL"}
    type_in = (
        "const s = document.getElementById(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('input'));"
    )
    page.run(type_in, "run-list-search", "ring n8")
    names = page.run(COLUMN, "run-list-table", 0)
    assert names
    assert all("ring" in name and "n8" in name for name in names)
    page.run(type_in, "run-list-search", "no such thing")
    assert page.run(COLUMN, "run-list-table", 0) == []
    assert "0 of 0 shown" in page.run("return document.querySelector('#run-list output').textContent")


def test_a_row_opens_its_run_and_the_instance(page):
    page.run("document.querySelector('#run-list-table tbody tr').click()")
    text = page.run("return document.getElementById('panel').innerText")
    for word in ("Routes", "Trace", "Options", "Cost of each tour", "Status"):
        assert word in text
    assert page.run("return document.querySelectorAll('#panel svg polyline').length") >= 1
    page.run("[...document.querySelectorAll('#panel button')].find(b => b.textContent.startsWith('All runs')).click()")
    assert "Best found" in page.run("return document.getElementById('panel').innerText")
    assert page.run("return document.querySelectorAll('#panel tbody tr').length") > 3
    page.run("document.getElementById('panel-close').click()")
    assert not page.run("return document.getElementById('panel').open")


def test_the_keyboard_alone_opens_and_closes_a_run(page):
    page.run("document.querySelector('#run-list-table tbody button').focus()")
    page.keys("Enter")
    assert page.run("return document.getElementById('panel').open")
    page.keys("Escape")
    page.settle()
    assert not page.run("return document.getElementById('panel').open")
    assert page.run("return document.activeElement.closest('#run-list-table') !== null")


def test_what_a_run_printed_is_shown_as_text(page):
    script = """
    const s = document.getElementById('run-list-method'); s.value = 'ga'; s.dispatchEvent(new Event('input'));
    for (const row of document.querySelectorAll('#run-list-table tbody tr')) {
      row.click();
      const body = document.getElementById('panel-body');
      if (body.textContent.includes('rubbish')) return [body.textContent, body.querySelectorAll('b, i').length];
    }
    """
    text, elements = page.run(script)
    assert "</script><b>rubbish</b>" in text
    assert elements == 0


def test_light_dark_and_the_toggle(page):
    colour = "return getComputedStyle(document.body).backgroundColor"
    page.run("localStorage.clear(); delete document.documentElement.dataset.theme")
    page.emulate(prefers_color_scheme="light")
    light = page.run(colour)
    page.emulate(prefers_color_scheme="dark")
    dark = page.run(colour)
    assert light != dark
    page.run("document.getElementById('theme').click()")
    assert page.run(colour) == light
    page.run("document.getElementById('theme').click()")
    assert page.run(colour) == dark
    page.emulate(prefers_color_scheme="light")


def test_alarms_are_on_top_and_everything_has_a_name(page):
    assert page.run("return document.querySelector('main section').id") == "contradictions"
    assert "broken.json" in page.run("return document.getElementById('warnings').textContent")
    assert page.run("return [...document.querySelectorAll('main svg:not([aria-hidden])')].every(s => s.ariaLabel)")
    assert page.run("return [...document.querySelectorAll('input, select')].every(e => e.labels.length)")
    assert page.run("return [...document.querySelectorAll('main figure')].every(f => f.querySelector('figcaption'))")
    assert page.run(
        "const i = [...document.querySelectorAll('[id]')].map(e => e.id); return i.length === new Set(i).size"
    )


ADDRESS = "return decodeURIComponent(location.hash)"
PANEL = (
    "const p = document.getElementById('panel'); return p.open ? document.getElementById('panel-h').textContent : null"
)
SET = "const s = document.getElementById(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('input'));"
ORDER = "return [...document.querySelectorAll('#run-list-table tbody tr')].map(row => row.innerText)"


def test_back_closes_a_panel_and_forward_opens_it_again(page):
    page.run("document.querySelector('#run-list-table tbody tr').click()")
    title = page.run(PANEL)
    assert title
    page.run("history.back()")
    page.settle()
    assert page.run(PANEL) is None
    assert "open=" not in page.run(ADDRESS)
    page.run("history.forward()")
    page.settle()
    assert page.run(PANEL) == title


def test_back_goes_from_panel_to_panel_and_close_leaves_both(page):
    page.run("document.querySelector('nav a[href=\"#runs\"]').click()")
    page.run("document.querySelector('#run-list-table tbody tr').click()")
    first = page.run(PANEL)
    page.run("[...document.querySelectorAll('#panel button')].find(b => b.textContent.startsWith('All runs')).click()")
    assert page.run(PANEL) not in (None, first)
    page.run("history.back()")
    page.settle()
    assert page.run(PANEL) == first
    page.run("history.forward()")
    page.settle()
    page.run("document.getElementById('panel-close').click()")
    page.settle()
    assert page.run(PANEL) is None
    assert page.run(ADDRESS) == "#runs"  # the section the reader had gone to before


def test_a_link_and_a_reload_show_the_same(page, study):
    page.run(SET, "run-list-method", "milp (cuts=false)")
    page.run(SET, "run-list-search", "ring")
    page.run(PRESS, "run-list-table", 6)
    page.run(PRESS, "run-list-table", 6)
    page.run(PRESS, "summary-table", 1)
    page.run("document.getElementById('theme').click()")
    page.run("document.querySelector('#run-list-table tbody tr').click()")
    look = "return [document.documentElement.dataset.theme, document.querySelector('#summary-table tbody').innerText]"
    seen = page.run(PANEL), page.run(ORDER), page.run(look)
    assert None not in seen
    hash = page.run("return location.hash")
    page.reload()
    assert (page.run(PANEL), page.run(ORDER), page.run(look)) == seen
    page.run("localStorage.clear()")
    page.open(study, hash)
    assert (page.run(PANEL), page.run(ORDER), page.run(look)) == seen
    page.run("document.getElementById('panel-close').click()")
    page.settle()
    assert page.run(PANEL) is None  # without a page before it to go back to
    assert "sort.run-list=-" in page.run(ADDRESS)


def test_the_address_of_something_that_is_not_there_opens_the_page_as_it_is(page, study):
    page.open(study, "#nowhere&open=no~such~run&sort.run-list=what&run-list.method=none&theme=pink")
    assert page.run(PANEL) is None
    assert page.run("return document.querySelectorAll('#instance-list-table tbody tr').length") > 3


def test_methods_shown_in_the_figures_stand_in_the_address(page, study):
    page.open(study, "#summary")
    first, *others = page.run("return window.charts.shown()")
    page.run("window.charts.show(arguments[0])", others)
    page.settle()
    assert first not in page.run("return new URLSearchParams(location.hash.slice(1)).getAll('method')")
    page.reload()
    page.settle()
    assert page.run("return window.charts.shown()") == others
    page.run("window.charts.show([])")
    page.reload()
    page.settle()
    assert page.run("return window.charts.shown()") == []
    page.run("window.charts.show(arguments[0])", [first, *others])
    assert "method=" not in page.run("return location.hash")


def test_the_section_of_the_navigation_comes_into_view_and_the_keyboard_goes_on_there(page, study):
    page.run("document.querySelector('nav a[href=\"#groups\"]').click()")
    assert page.run("return location.hash") == "#groups"
    assert page.run("return document.activeElement.id") == "groups"
    assert 0 <= page.run("return document.getElementById('groups').getBoundingClientRect().top") < 200
    page.open(study, "#groups&theme=dark")
    page.settle()
    assert 0 <= page.run("return document.getElementById('groups').getBoundingClientRect().top") < 200


def test_first_values_do_not_flatten_a_trace(page, study, tmp_path):
    text = study.read_text(encoding="utf-8")
    (data,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, flags=re.S)
    told = json.loads(data)
    run = next(int(k) for k, detail in told["details"].items() if len(detail["trace"]) > 2)
    told["details"][str(run)]["trace"] = [[0.01, 9000, 0], [0.02, 101, 99], [1, 100.5, 99.5], [10, 100, 99.8]]
    cut = tmp_path / "page.html"
    cut.write_text(text.replace(data, embedded(told)), encoding="utf-8")
    page.open(cut)
    while page.run("return !document.querySelector('#run-list .more').hidden"):
        page.run("document.querySelector('#run-list .more').click()")
    page.run("document.querySelectorAll('#run-list-table tbody tr')[arguments[0]].click()", run)
    assert "The axis is cut" in page.run("return document.getElementById('panel-body').innerText")
    texts = "return [...document.querySelectorAll(arguments[0])].map(t => t.textContent)"
    ticks = page.run(texts, "#panel svg[aria-label^=Objective] text")
    values = [float(t.replace(",", "")) for t in ticks if re.fullmatch(r"[\d.,]+", t)]
    assert 99 < max(values) < 110


TOLD = """
const inside = (root) => [...root.querySelectorAll('*')]
  .flatMap((part) => [part, ...(part.shadowRoot ? inside(part.shadowRoot) : [])]);
return inside(document).filter((part) => part.classList.contains('bk-tooltip-row-value'))
  .map((part) => part.textContent);
"""
FIRST = "const box = document.querySelector('figure.interactive .panels > div');"


def test_values_are_told_under_the_pointer(page):
    page.run(f"await window.charts.ready; {FIRST} box.scrollIntoView({{ block: 'center' }});")
    page.settle()
    x, y, width, height = page.run(
        f"{FIRST} const at = box.getBoundingClientRect(); return [at.x, at.y, at.width, at.height];"
    )
    told = []
    for step in range(30 * 20):  # until the pointer has met a line
        across, down = (step % 30 + 1) / 31, (step // 30 + 1) / 21
        page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + across * width, y=y + down * height)
        if step % 30 == 29:
            page.settle()
        if told := page.run(TOLD):
            break
    assert any(character.isdigit() for value in told for character in value)


def test_a_method_is_hidden_in_all_figures_at_once(page):
    page.run("await window.charts.ready;")
    row = "document.querySelectorAll('.methods button.method')"
    name = page.run(f"return {row}[0].value")
    page.run(f"{row}[0].click();")
    page.settle()
    pressed = page.run(
        "return [...document.querySelectorAll('button.method')].map(b => [b.value, b.getAttribute('aria-pressed')])"
    )
    assert len({value for value, _ in pressed}) > 1
    assert all((state == "false") == (value == name) for value, state in pressed)
    assert name not in page.run("return window.charts.shown()")
