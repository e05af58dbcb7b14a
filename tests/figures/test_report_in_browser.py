"""The report in a real browser: it says nothing on its console, moves, heeds keys, fits a phone, has a dark side."""

from __future__ import annotations

import os

import matplotlib.pyplot as plt
import pytest

from pipeline.commands.claims import VERDICTS, Claim, Claims
from pipeline.report import page as page_of
from stages.drawing import style
from tests.comparison.made_up import make_walk
from tests.figures import browser
from tests.figures.made_up_results import drawn, twin

pytestmark = [
    pytest.mark.skipif(browser.installed() is None, reason="no Chromium or Chrome is installed"),
    pytest.mark.skipif(os.name != "posix", reason="drives the browser through inherited pipes"),
]


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    faster = twin()
    faster.walk = make_walk(speed=0.31)
    fragment = drawn("gait_animation", twin=faster)
    words = "1 < 2 & <b>more</b>"
    claims = [Claim(f"{verdict}", "1.2", words, "1 < 2", "x" * 200, verdict, "", ["made up"], ["a.b 1"], plain="Plain.")
              for verdict in VERDICTS]  # fmt: skip
    table = {"title": "Table", "columns": ["", "one", "two"], "rows": [["a row", "1.0", ""]]}
    row = {"name": "analytic", "summary": "walks", "key": "0" * 32, "seconds": "1.0", "size": "1.00", "inputs": ""}
    captions = {"figures": [{"name": "gait_animation", "title": "Gait", "text": "made up"},
                            {"name": "wide", "title": "Wide", "text": "a wide one"}]}  # fmt: skip
    with style.drawing():
        picture = style.pictures("wide", plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 2.0))[0], 80, pdf=False)
    files = {"results/figures/gait_animation.html": fragment.encode(),
             "results/figures/wide.png": picture["figures/wide.png"]}  # fmt: skip
    figures = list(page_of._figures(files, captions, ()))
    answers = [{"question": "Does it walk?", "answer": "Yes.", "errors": "solver 1 %", "means": "Build it."}]
    content = page_of.Content(
        Claims(claims, ["One sentence."], [table]), figures, "A report", "All of it.", [row],
        {"biped": [{"key": "hip_mass", "value": "0.3", "unit": "kg", "source": "made up"}]}, {"python": "3"}, {},
        answers=answers,
    )  # fmt: skip
    (folder / "report.html").write_bytes(page_of.html(content, "seal", "1", {}))
    opened = browser.Page((folder / "report.html").as_uri(), folder / "profile")
    yield opened
    opened.close()


def frame(page):
    return int(page.value("document.getElementById('gait').dataset.frame"))




def test_it_loads_without_a_word_and_without_the_network(page):
    assert page.said == []
    assert [address for address in page.requests if not address.startswith(("data:", "file:"))] == []
    assert page.value("document.querySelectorAll('b').length") == 0, "text from results is text, not markup"
    assert "1 < 2 & <b>more</b>" in page.value("document.body.innerText")


def test_every_claim_has_a_place_in_the_strip_of_verdicts(page):
    count = len(VERDICTS)
    assert page.value("document.querySelectorAll('.strip a').length") == count
    strip = "[...document.querySelectorAll('.strip a')]"
    widths = page.value(strip + ".map(part => part.getBoundingClientRect().width)")
    assert min(widths) > 10 and max(widths) - min(widths) < 1
    assert f"{count} claims: 1 hold" in page.value("document.getElementById('claims').nextElementSibling.innerText")
    key = page.value("[...document.querySelectorAll('.key li')].map(one => one.innerText.trim())")
    assert key == [f"1 {words}" for words, _ in VERDICTS.values()]
    assert page.value(strip + ".every(part => document.getElementById(part.getAttribute('href').slice(1)))")


def test_the_first_screen_answers_and_each_figure_is_one_click_from_it(page):
    assert page.value("document.querySelector('.answers').getBoundingClientRect().bottom") < 900
    assert "Does it walk?" in page.value("document.querySelector('.answers').innerText")
    links = page.value("[...document.querySelectorAll('header a')].map(one => one.getAttribute('href').slice(1))")
    assert {"gait_animation", "wide", "claims", "numbers"} <= set(links)
    assert all(page.value(f"document.getElementById('{place}') !== null") for place in links)
    assert page.value("document.querySelector('.cards td[data-name=said]').innerText.startsWith('Plain.')")


def test_the_animation_plays_by_key_and_by_button_and_stops(page):
    page.value("document.getElementById('gait').focus()")
    page.press("Home")
    start = page.value("document.querySelector('#gait .scene').toDataURL()")
    page.press(" ")
    page.until("Number(document.getElementById('gait').dataset.frame) > 3")
    page.press(" ")
    stopped = frame(page)
    assert page.value("document.querySelector('#gait .scene').toDataURL()") != start
    page.value("document.querySelector('#gait .play').focus()")
    page.press("Enter")
    page.until(f"Number(document.getElementById('gait').dataset.frame) > {stopped}")
    page.press("Enter")
    assert page.value("document.querySelector('#gait .play').textContent") == "Play"
    assert page.said == []


def test_arrow_keys_step_and_the_slider_scrubs(page):
    page.value("document.getElementById('gait').focus()")
    page.press("Home")
    page.press("ArrowRight")
    page.press("ArrowRight")
    page.press("ArrowLeft")
    assert frame(page) == 1
    page.press("End")
    assert frame(page) == int(page.value("document.querySelector('#gait .scrub').max"))
    page.value("(s => { s.value = 100; s.dispatchEvent(new Event('input')); })(document.querySelector('#gait .scrub'))")
    assert frame(page) == 100
    # the second walk is as fast as the first, the third 10 mm/s quicker: after one second 10 mm ahead
    assert page.value("document.querySelector('#gait output').textContent").endswith("digital twin 10.0 mm")


def test_a_source_can_be_hidden(page):
    shown = page.value("document.querySelector('#gait .scene').toDataURL()")
    page.value("document.querySelector('#gait .sources input').click()")
    assert page.value("document.querySelector('#gait .scene').toDataURL()") != shown
    page.value("document.querySelector('#gait .sources input').click()")
    assert page.value("document.querySelector('#gait .scene').toDataURL()") == shown


@pytest.mark.parametrize(("scheme", "is_dark"), [("dark", True), ("light", False)])
def test_dark_and_light(page, scheme, is_dark):
    page.prefer(scheme)
    brightness = page.value(
        "getComputedStyle(document.body).backgroundColor.match(/[0-9]+/g).map(Number).reduce((a, b) => a + b)"
    )
    assert (brightness < 200) == is_dark
    page.until("document.querySelector('#gait .scene').clientWidth > 0")
    assert ("invert" in page.value("getComputedStyle(document.querySelector('.picture svg')).filter")) == is_dark
    ink = page.value("getComputedStyle(document.getElementById('gait')).getPropertyValue('--line').trim()")
    assert ink == ("#eee" if is_dark else "#222")


def test_it_fits_a_phone(page):
    page.resize(390, 844, mobile=True)
    try:
        assert page.value("document.documentElement.scrollWidth") <= 390
        wide = page.value(
            "[...document.querySelectorAll('main *:not(svg *)')]"
            ".filter(part => part.getBoundingClientRect().right > 391).length"
        )
        assert wide == 0
        sizes = page.value(
            "[...document.querySelectorAll('td, p, figcaption, output')]"
            ".map(part => parseFloat(getComputedStyle(part).fontSize))"
        )
        assert min(sizes) >= 13
        assert page.value("getComputedStyle(document.querySelector('.cards td')).display") == "block"
        pictures = "[...document.querySelectorAll('.picture svg')]"
        shown = page.value(f"{pictures}.map(one => one.getBoundingClientRect().width)")
        assert shown[0] == 0.0 and len(shown) == 3 and min(shown[1:]) > 300.0 and max(shown) < 370.0
    finally:
        page.resize(1200, 900)


def test_it_prints(page):
    printed = page.printed()
    assert printed.startswith(b"%PDF-") and len(printed) > 10_000
    assert page.said == []
