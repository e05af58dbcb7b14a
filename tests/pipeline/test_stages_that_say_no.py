"""A stage that says no is a result: kept, told by every command, and what can do without it is computed."""

from pipeline.execution import executor


def can_do_without(toy):
    """The toy's picture goes on without the bounce."""
    toy.edit("PACKAGE/picture/run.py", "    bounce: Bounce\n    side: Path\n",
             "    bounce: Bounce\n    side: Path\n    missing: dict[str, str] = field(default_factory=dict)\n")
    toy.edit("PACKAGE/picture/run.py", "import dataclass\n", "import dataclass, field\nimport json\n")
    toy.edit("PACKAGE/picture/run.py", "(CLAIM % inputs.bounce.force)",
             "(CLAIM % (inputs.bounce.force if inputs.bounce else 0.0)).replace("
             "'it is another toy', json.dumps(inputs.missing.get('bounce')))")
    return toy


def test_it_is_kept_its_files_go_and_what_needs_it_says_so(done, monkeypatch):
    toy = can_do_without(done)
    no = toy.fails("fall.behaviour=answer")
    assert no.exit_code == 3 and no.sentences == ("stage fall: nothing falls upwards",)
    told = {one.stage: (one.how, one.summary) for one in no.outcomes}
    assert told == {"fall": ("refused", "nothing falls upwards"),
                    "bounce": ("refused", "there is no fall: nothing falls upwards"),
                    "side": ("current", told["side"][1]), "picture": ("computed", "2 figures")}
    assert not toy.results().keys() & {"fall.h5", "bounce.h5"}, "nothing of them is left to be mixed in"
    assert b"there is no fall: nothing falls upwards" in toy.results()["claims.yaml"]
    kept = {name: found.entry.refused for name, found in toy.survey("fall.behaviour=answer").items()}
    assert kept == {"fall": True, "bounce": True, "side": False, "picture": False}
    monkeypatch.setattr(executor._Run, "_start", None)  # whatever is computed now fails
    assert toy.fails("fall.behaviour=answer").sentences == no.sentences
    monkeypatch.undo()
    assert toy.run() == {"fall": "restored", "bounce": "restored", "side": "current", "picture": "computed"}


def test_of_a_long_reason_the_first_clause_is_passed_on(done):
    long = f"nothing falls upwards: of {', '.join(map(str, range(60)))} tries none did"
    can_do_without(done).edit("PACKAGE/fall/run.py", "nothing falls upwards", long)
    no = done.fails("fall.behaviour=answer")
    told = {one.stage: one.summary for one in no.outcomes}
    assert told["fall"] == long and told["bounce"] == "there is no fall: nothing falls upwards"


def test_another_reason_is_another_key(done):
    """What a stage does without something follows from the reason."""
    toy, keys = can_do_without(done), []
    for words in ("nothing falls upwards", "it is held"):
        no = toy.fails("fall.behaviour=answer")
        keys.append({one.stage: one.key for one in no.outcomes}["picture"])
        toy.edit("PACKAGE/fall/run.py", "nothing falls upwards", "it is held") if len(keys) == 1 else None
        assert words.encode() in toy.results()["claims.yaml"]
    assert keys[0] != keys[1]


def test_a_failure_is_not_kept_and_takes_no_earlier_result(done):
    toy, before = can_do_without(done), done.results()
    failure = toy.fails("fall.behaviour=raise")
    assert failure.exit_code == 1
    assert {one.stage: one.how for one in failure.outcomes} == {
        "fall": "failed", "bounce": "failed", "side": "current", "picture": "computed"}
    after = toy.results()
    assert {name for name in before if after.get(name) != before[name]} == {"claims.yaml", "picture.h5"}
    assert toy.run()["fall"] == "current"


def test_a_stage_that_went_wrong_in_part_is_kept_with_its_account_and_ends_with_one(done, monkeypatch):
    toy = can_do_without(done)
    toy.edit("PACKAGE/picture/run.py", "    return Result(",
             "    files['figures/two.log'] = b'Traceback'\n    return Result(")
    for behaviour, more in (("well", ()), ("answer", ("stage fall: nothing falls upwards",))):
        failed = toy.fails(f"fall.behaviour={behaviour}")
        said = "stage picture: 3 figures; the full account is in " + failed.sentences[-1].rpartition(" in ")[2]
        assert failed.exit_code == 1 and failed.sentences == (*more, said) and said.endswith("two.log")
        assert {"figures/one.svg", "figures/two.log"} <= toy.results().keys()
    monkeypatch.setattr(executor._Run, "_start", None)  # whatever is computed now fails
    assert toy.fails("fall.behaviour=answer").sentences == failed.sentences


def test_every_command_tells_the_reason_and_the_report_is_written(toy_with_commands):
    toy, answer = can_do_without(toy_with_commands), "--set fall.behaviour=answer"
    code, out, errors = toy.command("run-all", *answer.split())
    assert code == 3 and out.splitlines()[-1].split() == ["report", "written", "results/report.html"]
    assert errors.splitlines()[-1] == "error: stage fall: nothing falls upwards"
    page = (toy.root / "results/report.html").read_text(encoding="utf-8")
    assert "<li>fall: nothing falls upwards</li>" in page and "<li>bounce: there is no fall" in page
    show, run, status = toy.answers("show fall", f"run bounce {answer}", f"status {answer}").values()
    for code, _, errors in (show, run):
        assert code == 3 and errors.endswith("error: stage fall: nothing falls upwards\n")
    assert "refused  nothing falls upwards" in status[1]
    toy.says("run-all --set fall.behaviour=raise", "the full account is in results/log/fall.log", code=1)
    page = (toy.root / "results/report.html").read_text(encoding="utf-8")
    assert "<li>fall: ZeroDivisionError" in page and "it is a toy" in page


def test_claims_of_a_stage_that_said_no_are_not_asked_for_again(toy_with_commands):
    toy = toy_with_commands
    assert toy.command("run-all", "--set", "fall.behaviour=answer")[0] == 3
    code, _, errors = toy.command("claims")
    assert code == 3 and "there is no fall: nothing falls upwards" in errors and "make it with" not in errors


def test_a_frozen_stage_runs_when_it_is_named_and_what_does_not_list_it_goes_on(toy_with_commands):
    toy = can_do_without(toy_with_commands)
    toy.edit("dvc.yaml", "    cmd: bipedstudy run bounce\n", "    cmd: bipedstudy run bounce\n    frozen: true\n")
    toy.edit("dvc.yaml", "      - results/bounce.h5\n", "")
    assert toy.study().graph.usual == ("fall", "side", "picture")
    toy.says("run-all")
    assert b"leaves it out of what stage picture reads" in toy.results()["claims.yaml"]
    assert "bounce.h5" not in toy.results()
    assert toy.says("status", "bounce frozen runs when it is named").count("current") == 3
    toy.says("run bounce")
    assert toy.says("status").count("current") == 4
