"""Results that are not those of the parameters and code at hand are not shown without a word."""

import json
import shutil

from pipeline.commands.status import Standing, together
from pipeline.execution.executor import CURRENT, STALE, WAITING
from pipeline.report.figures import draw

HEIGHT = "fall.yaml: height 2 -> 2.5"


def said(toy, *names, settings=()):
    return Standing(toy.study(*settings), names).sentence(names)


def edit_height(toy):
    toy.edit("params/fall.yaml", "{value: 2.0,", "{value: 2.5,")


def test_what_changed_is_named_with_the_command_that_mends_it(done):
    edit_height(done)
    assert said(done, "bounce") == f"not current: bounce ({HEIGHT}); make it current with: bipedstudy run bounce"
    assert said(done, "fall", "bounce", "side") == (
        f"not current: fall, bounce ({HEIGHT}); make them current with: bipedstudy run bounce")
    done.edit("params/ground.yaml", "value: 1e5", "value: 2e5")
    stiffness = "ground.yaml: contact_stiffness 1e5 -> 2e5"
    assert f"bounce ({stiffness}; {HEIGHT});" in said(done, "bounce"), "its own and above"
    assert "contact_stiffness" not in said(done, "fall")
    found = survey(done, "fall.height=2")
    assert (found["fall"], found["bounce"]) == ((CURRENT, ()), (STALE, (stiffness,)))
    assert found["picture"] == (WAITING, ("input bounce will be computed first",))


def test_the_command_repeats_how_the_study_was_asked_for(done):
    told = said(done, "bounce", settings=("fall.height=2.5",))
    assert HEIGHT in told and told.endswith("bipedstudy run bounce --set fall.height=2.5")


def test_edited_code_and_files_without_a_history_are_said(done):
    done.edit("PACKAGE/bounce/run.py", "contact_stiffness)", "contact_stiffness * 1.02)")
    assert f"bounce ({done.package}/bounce/run.py changed)" in said(done, "bounce")
    shutil.rmtree(done.root / "results/.cache")
    assert said(done, "fall") == "" and together(done.study(), ["fall"]), "it says that itself"
    with open(done.root / "results/fall.h5", "ab") as file:
        file.write(b"x")
    assert "results/fall.h5 is there, but nothing says how it was made" in said(done, "fall")
    assert not together(done.study(), ["fall"])


def test_what_cannot_be_told_is_said_and_ends_nothing(done):
    done.edit("params/fall.yaml", "height:", "weight:")
    assert said(done, "bounce").startswith("whether these results are current cannot be told: ")
    assert 'no parameter "weight"' in said(done, "bounce")


def test_results_of_one_run_belong_together_until_one_is_computed_anew(done):
    edit_height(done)
    assert together(done.study(), ["fall", "bounce"]), "an edit alone leaves them as they were"
    done.run(names=("fall",))
    assert said(done, "fall") == "" and "bounce (input fall changed)" in said(done, "bounce")
    assert not together(done.study(), ["fall", "bounce"]) and together(done.study(), ["bounce"])


def test_a_null_that_one_stage_keeps_and_another_fills_tells_nothing_apart(toy):
    """Of every robot's comparison: figure 8 alone had no caption, though all was current."""
    toy.edit("params/ground.yaml", "{value: 9.81,", "{value: null,")
    for name in ("fall", "bounce"):
        toy.edit(f"PACKAGE/{name}/parameters.py", "gravity: float =", "gravity: float | None =")
    toy.edit("PACKAGE/fall/parameters.py", "    gravity: Gravity\n    settings: Settings\n",
             "    gravity: Gravity\n    settings: Settings\n\n    def __post_init__(self):\n"
             "        object.__setattr__(self, 'gravity', Gravity(self.gravity.gravity or 9.81))\n")
    toy.run()
    assert together(toy.study(), ["fall", "bounce"])
    toy.edit("params/ground.yaml", "{value: null,", "{value: 1.6,")
    toy.run(names=("fall",))
    assert not together(toy.study(), ["fall", "bounce"])


def test_a_figure_has_the_parameters_of_its_results_and_says_what_they_are_not(toy):
    """Gravity is a parameter of the figure and of the result that it shows."""
    toy.edit("dvc.yaml", "- params/picture.yaml:", "- params/picture.yaml:\n      - params/ground.yaml: [gravity]")
    toy.edit("PACKAGE/picture/parameters.py", "    settings: Settings",
              "    settings: Settings\n    ground: Ground")
    toy.edit("PACKAGE/picture/parameters.py", "@dataclass(frozen=True)\nclass Parameters",
              "@dataclass(frozen=True)\nclass Ground:\n    FILE: ClassVar[str] = 'ground'\n"
              "    gravity: float = parameter('m/s^2', 'gravity')\n\n\n@dataclass(frozen=True)\nclass Parameters")
    toy.edit("PACKAGE/picture/drawn.py", "{name}\"", "{name} at {parameters.ground.gravity:g}\"")
    toy.edit("PACKAGE/picture/drawn.py", "(\"side\",)", "(\"bounce\", \"side\")")
    toy.run()
    toy.edit("params/ground.yaml", "9.81", "1.6")
    toy.edit("params/picture.yaml", "title: fall", "title: mine")
    folder = toy.root / "drawn"
    ((_, caption, told),) = draw(toy.study(), ["one"], folder)
    assert caption == "this is one at 9.81", "not that of now"
    assert "bounce (ground.yaml: gravity 9.81 -> 1.6)" in told
    assert (folder / "one.svg").read_bytes() == b"mine" + told.encode()
    ((_, _, told),) = draw(toy.study(), ["one"], folder, marked=False)
    assert (folder / "one.svg").read_bytes() == b"mine" and told == ""
    toy.run(names=("fall",))
    ((_, caption, _),) = draw(toy.study("picture.extra=true"), ["two"], folder)
    assert caption.startswith("No caption: what is drawn was not computed together")


def test_the_note_stands_on_standard_error_beside_json(ran):
    edit_height(ran)
    for code, out, errors in ran.answers("show bounce --json", "claims --json").values():
        assert code == 0 and json.loads(out) and errors.startswith("note: not current: ") and HEIGHT in errors


# --- `status` says why a stage is stale.


def survey(toy, *settings):
    return {name: (found.state, found.reasons) for name, found in toy.survey(*settings).items()}
