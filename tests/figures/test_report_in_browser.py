"""The report and the robot in a real browser: nothing on its console; it moves, turns, heeds keys and preferences."""

import os

import matplotlib.pyplot as plt
import pytest

from pipeline.commands.claims import VERDICTS, Claim, Claims
from pipeline.report import page as page_of
from stages.drawing import style
from stages.figures.drawn import figure
from tests.comparison.made_up import make_walk
from tests.figures import browser
from tests.figures.made_up_results import drawn, twin

pytestmark = [
    pytest.mark.skipif(browser.installed() is None, reason="no Chromium or Chrome is installed"),
    pytest.mark.skipif(os.name != "posix", reason="drives the browser through inherited pipes"),
]


#: A page without claims, figures and stages.
BARE = {"title": "A report", "synthetic": "", "stages": [], "parameters": {}, "versions": {"python": "3"},
        "missing": {}, "about": "", "answers": (), "claims_first": False}  # fmt: skip


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
    parameters = {"biped": [{"key": "hip_mass", "value": "0.3", "unit": "kg", "source": "made up"}]}
    content = {**BARE, "claims": Claims(claims, ["One sentence."], [table]), "figures": figures, "stages": [row],
               "synthetic": "All of it.", "parameters": parameters, "answers": answers}  # fmt: skip
    (folder / "report.html").write_bytes(page_of.html(content, "1", {}))
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
    assert f"{count} claims: 1 holds," in page.value("document.getElementById('claims').nextElementSibling.innerText")
    key = page.value("[...document.querySelectorAll('.key li')].map(one => one.innerText.trim())")
    assert key == [f"1 {one}" for (one, _), _ in VERDICTS.values()]
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


# --- The robot in a real browser: it is drawn, walks, turns, heeds keys and preferences; without WebGL it is a
# drawing.


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
    content = {**BARE, "claims": Claims(claims, [], []), "figures": opening}
    (folder / "report.html").write_bytes(page_of.html(content, "", {}))
    return folder


@pytest.fixture(scope="module")
def robot_page(report):
    opened = browser.Page((report / "report.html").as_uri(), report / "profile", 1280, 800)
    yield opened
    opened.close()


@pytest.fixture
def still(robot_page):
    """The page with the walk stopped, the view as it begins, and the canvas in focus."""
    if robot_page.value(FIND.format(".play") + ".textContent") == "Pause":
        robot_page.value(FIND.format(".play") + ".click()")
    robot_page.value(FIND.format(".reset") + ".click(), " + FIND.format("canvas") + ".focus()")
    return page


def look(robot_page, act=REDRAWN):
    return robot_page.value(LOOK % act)


def data(robot_page, name):
    return float(robot_page.value(f"document.getElementById('robot').dataset.{name}"))


def test_it_is_drawn_below_the_title_and_above_the_verdicts_without_the_network(robot_page):
    assert robot_page.value("document.getElementById('robot').classList.contains('live')")
    anything, green, orange, blue, _ = look(robot_page)
    assert 0.2 < anything < 0.9 and min(green, orange) > 0.004 and blue > 0.001
    order = "['h1', '#robot', '.strip'].map(one => document.querySelector(one).getBoundingClientRect())"
    assert robot_page.value(f"{order}.every((box, at, all) => !at || all[at - 1].bottom <= box.top)")
    below = "document.querySelector('.strip').getBoundingClientRect().bottom"
    assert robot_page.value(below) < 800, "robot, numbers and verdicts stand on the first screen"
    assert robot_page.said == [] and [at for at in robot_page.requests if not at.startswith(("data:", "file:"))] == []


def test_it_plays_by_itself_and_stops_by_key_and_button(robot_page):
    start = data(robot_page, "frame")
    robot_page.until(f"Number(document.getElementById('robot').dataset.frame) > {start}")
    robot_page.value(FIND.format("canvas") + ".focus()")
    robot_page.press(" ")
    assert robot_page.value(FIND.format(".play") + ".textContent") == "Play"
    stopped = look(robot_page)
    assert look(robot_page) == stopped, "it stands"
    robot_page.value(FIND.format(".play") + ".click()")
    robot_page.until(f"Number(document.getElementById('robot').dataset.frame) > {data(robot_page, 'frame') + 2}")
    robot_page.press(" ")
    assert look(robot_page)[-1] != stopped[-1] and robot_page.said == []


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


def test_who_prefers_less_motion_finds_it_standing(robot_page):
    robot_page.prefer("light", motion="reduce")
    robot_page.reload()
    assert robot_page.value(FIND.format(".play") + ".textContent") == "Play" and look(robot_page)[0] > 0.2
    robot_page.prefer("light")


def test_without_webgl_the_drawing_stays_and_in_print_too(report, robot_page):
    drawing = "getComputedStyle(document.querySelector('#robot svg')).display"
    assert robot_page.value(drawing) == "none"
    robot_page.call("Emulation.setEmulatedMedia", media="print")
    assert robot_page.value(drawing) == "block"
    robot_page.call("Emulation.setEmulatedMedia", media="")
    plain = browser.Page((report / "report.html").as_uri(), report / "plain", flags=("--disable-3d-apis",))
    try:
        assert plain.value(drawing) == "block" and plain.value("getComputedStyle("
            + FIND.format("canvas") + ").display + getComputedStyle(" + FIND.format(".bar") + ").display") == "nonenone"
        assert plain.value(FIND.format("svg path:last-child") + ".getBoundingClientRect().height") > 1
        assert plain.said == []
    finally:
        plain.close()
