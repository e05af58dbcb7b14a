"""The robot in a real browser: it is drawn, walks, turns, heeds keys and preferences; without WebGL it is a drawing."""

from __future__ import annotations

import os

import pytest

from pipeline.commands.claims import Claim, Claims
from pipeline.report import page as page_of
from stages.figures.drawn import figure
from tests.figures import browser
from tests.figures.made_up_results import drawn

pytestmark = [
    pytest.mark.skipif(browser.installed() is None, reason="no Chromium or Chrome is installed"),
    pytest.mark.skipif(os.name != "posix", reason="drives the browser through inherited pipes"),
]
FIND = "document.querySelector('#robot {}')"
#: What the canvas shows right after `act`: shares of all points that are anything, green, orange and pale blue.
LOOK = """(() => { %s; const from = document.querySelector('#robot canvas'), to = document.createElement('canvas');
  to.width = from.width; to.height = from.height; const pen = to.getContext('2d'); pen.drawImage(from, 0, 0);
  const points = pen.getImageData(0, 0, to.width, to.height).data, count = [0, 0, 0, 0]; let sum = 0;
  for (let k = 0; k < points.length; k += 4) { const [r, g, b, a] = points.slice(k, k + 4);
    if (a) count[0]++; if (a && g > r + 40 && g > b) count[1]++; if (a && r > g + 60) count[2]++;
    if (a && b > r + 40 && b > g) count[3]++; sum = (sum * 31 + r + 3 * g + 7 * b) %% 2147483647; }
  return [...count.map(part => part / points.length * 4), sum]; })()"""
REDRAWN = "document.querySelector('#robot .speed').oninput()"


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robot")
    fragment = drawn("robot_in_space")
    ids = ("step_frequency", "hip_displacement", "stable_gait", "twin_settles")
    claims = [Claim(name, "1", "said", "meant", "1", "holds", "", [], []) for name in ids]
    caption = {"name": "robot_in_space", "title": "Robot", "text": "made up", "claims": figure("robot_in_space").claims}
    captions = {"figures": [{**caption, "opens": True}]}
    opening = list(page_of._figures({"results/figures/robot_in_space.html": fragment.encode()}, captions, ()))
    content = page_of.Content(Claims(claims, [], []), opening, "A passive biped", "", [], {}, {}, {})
    (folder / "report.html").write_bytes(page_of.html(content, "seal", "", {}))
    return folder


@pytest.fixture(scope="module")
def page(report):
    opened = browser.Page((report / "report.html").as_uri(), report / "profile", 1280, 800)
    yield opened
    opened.close()


@pytest.fixture
def still(page):
    """The page with the walk stopped, the view as it begins, and the canvas in focus."""
    if page.value(FIND.format(".play") + ".textContent") == "Pause":
        page.value(FIND.format(".play") + ".click()")
    page.value(FIND.format(".reset") + ".click(), " + FIND.format("canvas") + ".focus()")
    return page


def look(page, act=REDRAWN):
    return page.value(LOOK % act)


def data(page, name):
    return float(page.value(f"document.getElementById('robot').dataset.{name}"))


def test_it_is_drawn_below_the_title_and_above_the_verdicts_without_the_network(page):
    assert page.value("document.getElementById('robot').classList.contains('live')")
    anything, green, orange, blue, _ = look(page)
    assert 0.2 < anything < 0.9 and min(green, orange) > 0.004 and blue > 0.001
    order = "['h1', '#robot', '.strip'].map(one => document.querySelector(one).getBoundingClientRect())"
    assert page.value(f"{order}.every((box, at, all) => !at || all[at - 1].bottom <= box.top)")
    below = "document.querySelector('.strip').getBoundingClientRect().bottom"
    assert page.value(below) < 800, "robot, numbers and verdicts stand on the first screen"
    assert page.said == [] and [at for at in page.requests if not at.startswith(("data:", "file:"))] == []


def test_it_plays_by_itself_and_stops_by_key_and_button(page):
    start = data(page, "frame")
    page.until(f"Number(document.getElementById('robot').dataset.frame) > {start}")
    page.value(FIND.format("canvas") + ".focus()")
    page.press(" ")
    assert page.value(FIND.format(".play") + ".textContent") == "Play"
    stopped = look(page)
    assert look(page) == stopped, "it stands"
    page.value(FIND.format(".play") + ".click()")
    page.until(f"Number(document.getElementById('robot').dataset.frame) > {data(page, 'frame') + 2}")
    page.press(" ")
    assert look(page)[-1] != stopped[-1] and page.said == []


def test_it_steps_by_keys_and_buttons(still):
    frame, seen = data(still, "frame"), look(still)
    still.press(".")
    still.press(".")
    still.press(",")
    assert data(still, "frame") == frame + 1 and look(still)[-1] != seen[-1]
    still.value(FIND.format(".back") + ".click()")
    assert data(still, "frame") == frame


def test_it_turns_by_keys_and_by_drag_and_comes_back(still):
    turn, tilt, seen = data(still, "turn"), data(still, "tilt"), look(still)
    still.press("ArrowRight")
    still.press("ArrowUp")
    assert data(still, "turn") > turn and data(still, "tilt") > tilt and look(still)[-1] != seen[-1]
    still.press("Home")
    assert look(still) == seen
    still.drag((400.0, 250.0), (500.0, 250.0))
    assert data(still, "turn") < turn
    still.press("Home")
    still.press("+")
    assert look(still)[1] > seen[1], "nearer is larger"


def test_ghost_forces_and_speed_are_chosen(still):
    seen = look(still)
    assert look(still, FIND.format(".ghosted") + ".click()")[3] < 0.2 * seen[3]
    assert look(still, FIND.format(".forced") + ".click()")[-1] != seen[-1]
    still.value(FIND.format(".ghosted") + ".click(), " + FIND.format(".forced") + ".click()")
    assert look(still) == seen
    still.value(f"(s => {{ s.value = 1; s.oninput(); s.value = 5; }})({FIND.format('.speed')})")
    assert "1/20 speed" in still.value(FIND.format("output") + ".textContent")


def test_numbers_and_verdicts_lead_to_claims_and_claims_to_the_figure(still):
    leads = "[...document.querySelectorAll('#robot .numbers a, .strip a')].map(a => a.getAttribute('href'))"
    targets = still.value(leads)
    assert len(targets) == 3 + 4 and all(still.value(f"!!document.querySelector('{at}')") for at in targets)
    row = "document.querySelector('#claim-step_frequency a').getAttribute('href')"
    assert still.value(row) == "#robot_in_space" and still.value("!!document.getElementById('robot_in_space')")


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_dark_and_light_and_a_phone(still, scheme):
    still.prefer(scheme)
    still.resize(390, 844, mobile=True)
    try:
        assert still.value("document.documentElement.scrollWidth") <= 390
        assert still.value(FIND.format("canvas") + ".getBoundingClientRect().bottom") < 844
        names = "[...document.querySelectorAll('#robot button, #robot input')]"
        assert still.value(names + ".every(part => part.textContent || part.ariaLabel || part.closest('label'))")
        sizes = still.value("[...document.querySelectorAll('#robot p, #robot span, #robot li')]"
                            ".map(part => parseFloat(getComputedStyle(part).fontSize))")  # fmt: skip
        assert min(sizes) >= 13
        back = still.value("getComputedStyle(document.querySelector('#robot .view')).backgroundColor.match(/[0-9]+/g)")
        assert (sum(map(int, back)) < 200) == (scheme == "dark")
        assert look(still)[0] > 0.2
    finally:
        still.resize(1280, 800)


def test_who_prefers_less_motion_finds_it_standing(page):
    page.prefer("light", motion="reduce")
    page.reload()
    assert page.value(FIND.format(".play") + ".textContent") == "Play" and look(page)[0] > 0.2
    page.prefer("light")


def test_without_webgl_the_drawing_stays_and_in_print_too(report, page):
    drawing = "getComputedStyle(document.querySelector('#robot svg')).display"
    assert page.value(drawing) == "none"
    page.call("Emulation.setEmulatedMedia", media="print")
    assert page.value(drawing) == "block"
    page.call("Emulation.setEmulatedMedia", media="")
    plain = browser.Page((report / "report.html").as_uri(), report / "plain", flags=("--disable-3d-apis",))
    try:
        assert plain.value(drawing) == "block" and plain.value("getComputedStyle("
            + FIND.format("canvas") + ").display + getComputedStyle(" + FIND.format(".bar") + ").display") == "nonenone"
        assert plain.value(FIND.format("svg path:last-child") + ".getBoundingClientRect().height") > 1
        assert plain.said == []
    finally:
        plain.close()
