"""`bipedstudy figures --check`: what differs is found, said and drawn."""

import json
import shutil

import numpy as np
import pytest
from matplotlib.image import imread, imsave

from pipeline.report.figures import compare, differing_numbers, rms


@pytest.fixture
def folders(tmp_path):
    """Two folders with the same grey picture and one text."""
    grey = np.full((40, 60, 3), 0.5)
    grey[10:30, 20] = 0.0
    for name in ("expected", "drawn"):
        (tmp_path / name).mkdir()
        imsave(tmp_path / name / "a.png", grey)
        (tmp_path / name / "a.pdf").write_text("same")
    return tmp_path / "expected", tmp_path / "drawn", tmp_path / "kept"


def test_a_moved_line_is_found_and_drawn_in_two_colours(folders):
    expected, drawn, kept = folders
    moved = np.full((40, 60, 3), 0.5)
    moved[10:30, 21] = 0.0
    imsave(drawn / "a.png", moved)
    (found,) = compare(*folders)
    share = 2 * 20 / (40 * 60)
    assert rms(expected / "a.png", drawn / "a.png") == pytest.approx(127 * np.sqrt(share), rel=1e-3)
    assert found["fails"] and found["picture"] == kept / "a-difference.png" and "rms" in found["what"]
    picture = imread(found["picture"])[15, 19:23, :3]
    assert picture[1] == pytest.approx([0.84, 0.37, 0.0], abs=0.01), "only in the first: orange"
    assert picture[2] == pytest.approx([0.0, 0.45, 0.70], abs=0.01), "only in the second: blue"
    assert np.ptp(picture[0]) == pytest.approx(0, abs=1e-6)


def test_other_bytes_with_the_same_pixels_are_said_and_pass(folders):
    expected, drawn, _ = folders
    (drawn / "a.png").write_bytes((expected / "a.png").read_bytes() + b"\0")
    (drawn / "a.pdf").write_text("other")
    assert [(one["name"], one["fails"]) for one in compare(*folders)] == [("a.pdf", False), ("a.png", False)]


def test_missing_new_and_resized_pictures_fail(folders):
    expected, drawn, _ = folders
    (expected / "old.png").write_bytes(b"")
    (drawn / "new.png").write_bytes(b"")
    imsave(drawn / "a.png", np.zeros((10, 10, 3)))
    found = {one["name"]: (one["what"], one["fails"]) for one in compare(*folders)}
    assert found == {
        "a.png": ("has another size", True),
        "new.png": ("is missing", True),
        "old.png": ("is no longer drawn", True),
    }


def two_programs(expected, drawn, numbers, other):
    """Give the folders a figure that two versions of a program drew, and its numbers in both."""
    for folder, version, text in ((expected, "3.10", numbers), (drawn, "3.11", other)):
        grey = np.full((40, 60, 3), 0.5)
        grey[10:30, 20 if version == "3.10" else 23] = 0.0
        imsave(folder / "a.png", grey, metadata={"Software": f"Painter {version}"})
        if text is not None:
            (folder / "a.csv").write_text(text)


NUMBERS = "# panel a: x: time [s]\npanel,series,x,y\n" + "".join(
    f'a,"{name}",{x / 10:.6g},{y}\n' for name, y in (("the gait", "2.5"), ("nothing", "1e-17"), ("words", "slow"))
    for x in range(11))  # fmt: skip


def test_pictures_of_two_programs_are_compared_by_their_numbers(folders):
    two_programs(*folders[:2], NUMBERS, NUMBERS.replace("2.5", "2.5001").replace("[s]", "[ s ]"))
    text, picture = compare(*folders)
    assert (text["name"], text["fails"], picture["fails"]) == ("a.csv", False, False) and not folders[2].exists()
    assert picture["what"] == "shows the same numbers; Painter 3.10 drew it, and here Painter 3.11"


@pytest.mark.parametrize(("change", "said"), [
    (("2.5", "2.525"), '"the gait" in panel a has y = 2.525, not 2.5 (allowed: 0.1 %)'),
    (("0.7,1e-17", "0.7,1e-7"), '"nothing" in panel a has y = 1e-7, not 1e-17 (allowed: 0.1 %)'),
    (("0.3,slow", "0.3,fast"), '"words" in panel a has y = fast, not slow (allowed: 0.1 %)'),
    (("0.3,slow", "0.3,nan"), '"words" in panel a has y = nan, not slow (allowed: 0.1 %)'),
    (('a,"words",0.5,slow\n', ""), '"words" in panel a has 10 points, not 11'),
    (("the gait", "a gait"), '"the gait" in panel a has 0 points, not 11'),
])  # fmt: skip
def test_a_curve_that_is_off_fails_with_a_picture_whoever_drew_it(folders, change, said):
    two_programs(*folders[:2], NUMBERS, NUMBERS.replace(*change))
    (picture,) = (each for each in compare(*folders) if each["fails"])
    assert picture["name"] == "a.png" and picture["what"].startswith(f"shows other numbers: {said}; ")
    assert picture["picture"] == folders[2] / "a-difference.png" and picture["picture"].exists()


def test_a_picture_without_numbers_is_compared_where_one_program_drew_both(folders):
    two_programs(*folders[:2], None, None)
    (found,) = compare(*folders)
    assert found["what"].startswith("has no numbers to compare; ") and not found["fails"]
    imsave(folders[0] / "a.png", np.zeros((40, 60, 3)), metadata={"Software": "Painter 3.11"})
    assert compare(*folders)[0]["fails"]


def test_numbers_that_are_not_four_words_a_row_are_no_failure_of_the_program():
    assert differing_numbers(b"panel,series\n\n\xff", b"panel,series\n\n\xff") == ""
    assert differing_numbers(b"panel,series\n", b"") == '"series" in panel panel has 0 points, not 1'


def test_a_figure_is_drawn_alone_from_the_artefacts_that_it_names(ran):
    toy, before, extra = ran, ran.results(), "--set picture.extra=true"
    (toy.root / "results/bounce.h5").unlink()
    assert toy.says(f"figures tw {extra}") == "results/drawn/two.svg\nthis is two\n"
    assert (toy.root / "results/drawn/two.svg").read_bytes() == b"fall" + before["side.bin"]
    told = json.loads(toy.says(f"figures two --into mine --json {extra}"))
    assert told == {"figures": [{"files": ["mine/two.svg"], "caption": "this is two", "said": ""}]}
    assert toy.answers("figures one", "figures twoo", "figures twoo --json") == {
        "figures one": (2, "", "error: results/bounce.h5 is not there yet; make it with: bipedstudy run-all\n"),
        **dict.fromkeys(("figures twoo", "figures twoo --json"), (
            2, "", 'error: there is no figure "twoo" (figures: one, two); did you mean "two"?\n'))}  # fmt: skip
    after = {name: content for name, content in toy.results().items() if not name.startswith("drawn/")}
    assert after == {name: content for name, content in before.items() if name != "bounce.h5"}
    (toy.root / "stages/picture/drawn.py").unlink()
    toy.says("figures one", "draws its figures only together", code=2)


def test_a_figure_that_cannot_be_drawn_says_why_after_the_others(ran):
    ran.edit("stages/picture/drawn.py", '    if name == "two":', """    if name == "one":
        from stages.fall.errors import NoFall
        raise NoFall("it hangs")
    if name == "two":""")
    code, out, errors = ran.command("figures", "one", "two", "--set", "picture.extra=true")
    assert code == 3 and out.endswith("this is two\n") and errors.endswith("error: one is not drawn: it hangs\n")
    (ran.root / "results/figures/one.svg").unlink()
    assert ran.says("figures --check").startswith("0 files, 0 differ"), "as there is none to compare with"


def test_a_figure_of_what_the_study_leaves_out_says_so(ran):
    ran.edit("stages/picture/drawn.py", 'inputs=("bounce",)', 'inputs=("bounce", "extremes")')
    code, out, errors = ran.command("figures", "one", "two", "--set", "picture.extra=true")
    assert code == 3 and out.endswith("this is two\n") and "extremes out of what stage picture reads" in errors
    ran.edit("stages/picture/drawn.py", '"extremes")', '"extremes"), without=("extremes",)')
    assert ran.says("figures one").endswith("this is one\n")


def test_figures_of_another_processor_are_compared_within_a_tolerance(toy_with_commands):
    toy = toy_with_commands
    toy.says("run-all", environment={"NPY_DISABLE_CPU_FEATURES": "NONE_SUCH"})  # as good as another: said, not hidden
    (toy.root / "results/figures/one.svg").write_text("by hand")
    (code, out, _), exact = toy.answers("figures --check", "figures --check --exact").values()
    assert code == 0 and "0.25 of 255 rms, as they were made by" in out and "NPY_DISABLE_CPU_FEATURES=NONE_SUCH" in out
    assert "NONE_SUCH" not in out.partition(", and here is ")[2] and exact[0] == 1
    (toy.root / "results/picture.h5").unlink()
    toy.says("figures --check", "is not there to show")


def test_the_command_draws_from_the_artefacts_that_lie_there(ran):
    toy, before, figure = ran, ran.results(), ran.root / "results/figures/one.svg"
    check = "figures --check", "figures --check --json", "figures --check --tolerance 0.25"
    drawn, told, same = toy.shows("figures", "figures --json", check[0])
    assert drawn == "results/figures/one.svg\n" and json.loads(told) == {"files": ["results/figures/one.svg"]}
    assert same.startswith("1 files, 0 differ, 0 of them beyond what is allowed: byte by byte, ")
    figure.write_text("by hand")
    text, plain, pixels = toy.answers(*check).values()
    assert text[0] == 1 and text[1].startswith("one.svg has other bytes"), "made here, so every byte counts"
    told = json.loads(plain[1])
    assert plain[0] == told["files"] == 1 and "byte by byte" in told["compared"]
    assert told["differ"] == [{"name": "one.svg", "what": "has other bytes", "fails": True, "picture": None}]
    assert pixels[0] == 0, "only pixels decide"
    figure.write_bytes(before["figures/one.svg"])
    assert toy.results() == before
    (toy.root / "results/bounce.h5").unlink()
    missing, elsewhere = toy.answers(check[0], "figures --results elsewhere").values()
    assert (missing[0], elsewhere[0]) == (2, 2)
    assert missing[2].startswith("note: not current: bounce (results/bounce.h5 is missing)")
    assert missing[2].endswith("error: results/bounce.h5 is not there yet; make it with: bipedstudy run-all\n")


def test_current_figures_are_not_drawn_anew_to_compare_them_with_others(ran):
    shutil.copytree(ran.root / "results/figures", ran.root / "others")
    undrawn = "from pipeline.report import figures; figures.draw = None; "
    check = "figures --check --against others"
    assert ran.says(check, before=undrawn).startswith("1 files, 0 differ")
    (ran.root / "others/two.svg").write_text("another")
    assert ran.says(check, before=undrawn, code=1).startswith("two.svg is no longer drawn")
    (ran.root / "results/figures/one.svg").write_text("by hand")
    code, _, errors = ran.command(*check.split(), before=undrawn)
    assert code == 1 and "unexpected TypeError" in errors, "as they are not current"
