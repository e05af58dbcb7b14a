"""A package holds all that results follow from, is the same bytes twice, and is computed again wherever it lies."""

import hashlib
import io
import json
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from pipeline.errors import StudyError
from pipeline.package import command
from tests.pipeline.test_stages_that_say_no import can_do_without
from tests.pipeline.toy import copied

CONTEXT = Path(__file__).with_name("ro_crate_context.json")
NAME = "ro-crate-metadata.json"


def packed(toy, name="results.zip", *more):
    """What the command says of a new package."""
    return json.loads(toy.says(" ".join(["package", name, *more, "--json"])))


def described(path):
    """The entities of a package by their names in it, and the contents of its files."""
    with zipfile.ZipFile(path) as package:
        contents = {name: package.read(name) for name in package.namelist()}
    return {entity["@id"]: entity for entity in json.loads(contents[NAME])["@graph"]}, contents


@pytest.fixture(scope="module")
def whole(finished_with_commands, tmp_path_factory):
    """A study with the package of its results, and what the command said of it; tests change neither."""
    toy = copied(finished_with_commands, tmp_path_factory.mktemp("packed"))
    return toy, packed(toy, "results.zip", "--date", "2031-05-06")


def addresses(entities):
    return {each["@id"] for each in (entities if isinstance(entities, list) else [entities])}


def test_every_file_of_the_package_is_described_with_its_digest_and_what_made_it(whole):
    ran, told = whole
    found, contents = described(ran.root / "results.zip")
    assert contents.keys() == {*addresses(found["./"]["hasPart"]), NAME} and len(contents) == told["files"]
    for name in contents.keys() - {NAME}:
        assert found[name]["sha256"] == hashlib.sha256(contents[name]).hexdigest()
        assert int(found[name]["contentSize"]) == len(contents[name])
    assert {"results/fall.h5", "results/claims.yaml", "params/ground.yaml", "dvc.yaml", "LICENSE"} < contents.keys()
    bounce = found["#run-bounce"]
    assert addresses(bounce["object"]) == {"params/ground.yaml", "results/fall.h5"}
    assert addresses(bounce["result"]) == {"results/bounce.h5"}
    assert found["results/bounce.h5"]["wasGeneratedBy"] == "#run-bounce"
    program = found[bounce["instrument"]["@id"]]
    version = ran.command("--version")[1].partition(", ")[2]
    code = re.search(r"code (\w+)", program["description"])[1]
    assert program["name"] == "bipedstudy" and code in program["@id"] and program["softwareVersion"] in version
    versions = {found[each]["name"] for each in addresses(program["softwareRequirements"])}
    assert {"h5py", "numpy", "python"} <= versions
    assert found["#processor-0"]["value"] and addresses(bounce["environment"]) == {"#processor-0"}
    # the citation has authors, year, program and digest
    digest = hashlib.sha256((ran.root / "results.zip").read_bytes()).hexdigest()
    assert told["sha256"] == digest and told["published"] == found["./"]["datePublished"] == "2031-05-06"
    said = rf"bipedstudy authors \(2031\): Results of .*\. bipedstudy .*, code \w+\. RO-Crate, sha256 {digest}"
    assert re.fullmatch(said, told["citation"])
    assert addresses(found["./"]["license"]) == {"https://spdx.org/licenses/BSD-3-Clause"}


def test_the_same_results_give_the_same_bytes_also_after_they_were_restored_and_moved(ran, tmp_path_factory):
    dated = {"SOURCE_DATE_EPOCH": "86400"}
    ran.says("package one.zip", "dated 1970-01-02", "cite it as: bipedstudy authors (1970)", environment=dated)
    (ran.root / "results/fall.h5").unlink()
    ran.says("run-all", "fall restored")
    ran.says("package other.zip", environment=dated)
    unpacked = tmp_path_factory.mktemp("elsewhere")
    with zipfile.ZipFile(ran.root / "one.zip") as package:
        package.extractall(unpacked)
    shutil.copytree(ran.root / "stages", unpacked / "stages")
    moved = type(ran)(unpacked, ran.package)
    moved.says("--trust status")
    moved.says("package third.zip", environment=dated)
    packages = ran.root / "one.zip", ran.root / "other.zip", unpacked / "third.zip"
    assert len({path.read_bytes() for path in packages}) == 1


def test_it_is_computed_again_unpacked_elsewhere(whole, tmp_path_factory):
    (ran, _), unpacked = whole, tmp_path_factory.mktemp("elsewhere") / "a folder"
    with zipfile.ZipFile(ran.root / "results.zip") as package:
        package.extractall(unpacked)
    claims = unpacked / "results/claims.yaml"
    claims.write_text(claims.read_text() + "# edited\n")
    found = json.loads(ran.says(f"recompute '{unpacked}' --json", code=3))
    assert [(each["stage"], bool(each["differences"])) for each in found["stages"]] == [
        ("fall", False), ("bounce", False), ("side", False), ("picture", True)]  # fmt: skip


def test_a_stage_that_said_no_is_an_action_that_failed_with_its_reason(ran):
    setting = "--set fall.behaviour=answer"
    ran.says(f"run-all {setting}", code=3)
    told = packed(ran, "results.zip", setting)
    found, _ = described(ran.root / "results.zip")
    assert told["refused"]["fall"] == "nothing falls upwards" and {"bounce", "picture"} < told["refused"].keys()
    failed = found["#run-fall"]
    assert failed["error"] == "nothing falls upwards" and failed["actionStatus"].endswith("/FailedActionStatus")
    assert "result" not in failed and "results/fall.h5" not in found and "results/side.h5" in found
    assert "side" not in told["refused"] and "error" not in found["#run-side"]


def test_tables_that_no_stage_made_stay_out_by_name(ran):
    (ran.root / "results/sweeps").mkdir(exist_ok=True)
    for name in ("results/sweeps/slopes.h5", "results/map.h5"):
        shutil.copy(ran.root / "results/fall.h5", ran.root / name)
    said = " ".join(ran.says("package results.zip").split())
    assert "without results/map.h5, which no stage made without results/sweeps/slopes.h5, which no stage made" in said
    assert said.count("which no stage made") == 2 and "results/map.h5" not in described(ran.root / "results.zip")[1]


def test_a_frozen_stage_is_packed_once_it_ran_and_without_it_the_package_is_a_study(toy_with_commands, tmp_path):
    toy = can_do_without(toy_with_commands)
    toy.edit("dvc.yaml", "    cmd: bipedstudy run side\n", "    cmd: bipedstudy run side\n    frozen: true\n")
    toy.edit("dvc.yaml", "      - results/side.bin\n", "")
    toy.edit("PACKAGE/picture/run.py", "    side: Path\n", "")
    toy.says("run-all")
    toy.says("package part.zip")
    with zipfile.ZipFile(toy.root / "part.zip") as package:
        package.extractall(tmp_path / "part")
    shutil.copytree(toy.root / toy.package, tmp_path / "part" / toy.package)
    moved = type(toy)(tmp_path / "part", toy.package)
    moved.says("--trust status", "side frozen runs when it is named")
    toy.says("run side")
    toy.says("package whole.zip")
    assert "results/side.bin" in described(toy.root / "whole.zip")[1]
    assert "side" in [each["stage"] for each in json.loads(toy.says("recompute whole.zip --json"))["stages"]]


def test_what_a_command_left_beside_the_parameters_goes_with_it(ran):
    """As calibrate --into leaves robot.json."""
    for name in ("robot.json", ".hidden.json", "notes.txt"):
        (ran.root / "params" / name).write_text("{}")
    packed(ran, "results.zip")
    found, _ = described(ran.root / "results.zip")
    assert found["params/robot.json"]["contentSize"] == "2"
    assert not {"params/.hidden.json", "params/notes.txt"} & found.keys()
    ran.says("recompute results.zip --json")


def test_a_recording_goes_with_it(ran):
    (ran.root / "lab.txt").write_text("41")
    setting = "--set side.table=lab.txt"
    ran.says(f"run-all {setting}")
    packed(ran, "results.zip", setting)
    found, _ = described(ran.root / "results.zip")
    assert "lab.txt" in addresses(found["#run-side"]["object"]) and found["lab.txt"]["contentSize"] == "2"
    assert found["#run-side"]["description"] == "bipedstudy run side --set side.table=lab.txt"
    assert len(json.loads(ran.says("recompute results.zip --json"))["stages"]) == 4


@pytest.mark.parametrize(("name", "text", "said"), [
    ("results", None, "never run"), ("results/claims.yaml", None, "results/claims.yaml is missing"),
    ("params/side.yaml", "seed: 4\nwait: 0.0\n", "seed 3 -> 4"),
    ("CITATION.cff", None, "CITATION.cff: is missing; a package needs its title, license"),
    ("CITATION.cff", "title: mine\n", "a package needs its title, authors and"),
    ("CITATION.cff", "title: t\nlicense: MIT\nauthors: [{name: me}]\n", "--date"),
])  # fmt: skip
def test_what_cannot_be_packed_is_said_in_a_sentence(done, name, text, said):
    place = done.root / name
    if text is not None:
        place.write_text(text)
    else:
        shutil.rmtree(place) if place.is_dir() else place.unlink()
    with pytest.raises(StudyError, match=said):
        runs, places, _ = command.gathered(done.study())
        command.described(done.study(), runs, None, places)


def test_a_recording_from_outside_is_refused(done, tmp_path):
    (tmp_path / "lab.txt").write_text("41")
    setting = f"side.table={tmp_path / 'lab.txt'}"
    done.run(setting)
    with pytest.raises(StudyError, match=r"table = .* lies outside of the study"):
        command.gathered(done.study(setting))


def test_a_study_s_own_authors_and_licences_are_named(ran):
    (ran.root / "CITATION.cff").write_text(
        "title: my walker\nlicense: [MIT, CC-BY-4.0]\ndate-released: 2030-01-02\nauthors:\n"
        "  - {family-names: Doe, given-names: Jo, orcid: 'https://orcid.org/0000-0002-1825-0097', affiliation: Lab}\n"
        "preferred-citation: {title: It walks, doi: 10.1/walk, authors: [{name: Lab}, {family-names: Roe}]}\n"
    )
    told = packed(ran)
    assert told["citation"].startswith("Doe, Jo (2030): Results of my walker. ")
    found, _ = described(ran.root / "results.zip")
    person = found["https://orcid.org/0000-0002-1825-0097"]
    assert person["@type"] == "Person" and found[person["affiliation"]["@id"]]["name"] == "Lab"
    assert len(found["./"]["license"]) == 2
    paper = found[found["./"]["citation"]["@id"]]
    assert paper["@id"] == "https://doi.org/10.1/walk"
    assert {found[each]["name"] for each in addresses(paper["author"])} == {"Lab", "Roe"}


def test_a_file_that_changes_while_it_is_packed_leaves_no_package(ran, tmp_path):
    place = ran.root / "dvc.yaml"
    with pytest.raises(Exception, match="changed while it was packed"):
        command._zipped(tmp_path / "a.zip", {}, {"dvc.yaml": place}, {"dvc.yaml": {"sha256": "0" * 64, "size": 3}})
    assert not [*tmp_path.glob("*.zip*"), *tmp_path.glob(".*")]


def strange(*entries):
    """A ZIP with these names and contents."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as package:
        for name, content in entries:
            package.writestr(name, content)
    return out.getvalue()


def test_a_stranger_s_file_that_is_no_package_is_refused_and_a_name_that_is_none(ran):
    contents = (
        (b"no zip", "is no package that can be read"),
        (strange(("../outside.h5", b"x")), "would lie outside"),
        (strange(("/outside.h5", b"x")), "would lie outside"),
        (strange(("results/a", b"x"), ("results/a/b.h5", b"x")), "is no package that can be read"),
        (strange(("readme.txt", b"x")), "there are no results there"),
    )
    said = {"package results.tar": "must end in .zip", "package file/results.zip": "not a folder",
            "package 0.zip": "is there already, and is not replaced"}  # fmt: skip
    (ran.root / "file").write_text("")
    for number, (content, why) in enumerate(contents):
        (ran.root / f"{number}.zip").write_bytes(content)
        said[f"recompute {number}.zip"] = why
    for words, (code, _, errors) in ran.answers(*said).items():
        assert code == 2 and said[words] in " ".join(errors.split()).lower(), errors
    assert not (ran.root.parent / "outside.h5").exists()


#: Puts RO-Crate's context into the validator's cache, then asks it offline: what each severity finds.
VALIDATE = """
import json, sys
import requests
from requests_cache import CachedRequest, CachedResponse, CachedSession
from rocrate_validator import services
from rocrate_validator.models import Severity, ValidationSettings

crate, context, cache = sys.argv[1:]
request = requests.Request("GET", "https://w3id.org/ro/crate/1.1/context").prepare()
response = CachedResponse(url=request.url, status_code=200, headers={"Content-Type": "application/ld+json"},
                          content=open(context, "rb").read(),
                          request=CachedRequest.from_request(request))
session = CachedSession(cache, backend="sqlite", expire_after=-1)
session.cache.save_response(response, session.cache.create_key(request))
session.close()
found = {}
for severity in (Severity.REQUIRED, Severity.RECOMMENDED):
    settings = ValidationSettings(rocrate_uri=crate, profile_identifier="process-run-crate-0.5", offline=True,
                                  requirement_severity=severity, cache_path=cache)
    found[severity.name] = sorted({issue.message for issue in services.validate(settings).get_issues()})
print(json.dumps(found))
"""
#: What is recommended and not said, as results know neither when nor by whom they were computed, nor an address.
UNSAID = {"endTime", "agent", "publisher", "absolute URI", "url", "URL", "PRONOM", "Web Site", "affiliation"}


def validated(path, folder):
    """What the validator finds, by severity."""
    program = shutil.which("rocrate-validator")
    if program is None:
        pytest.skip("rocrate-validator is not in the path: make test-package")
    done = subprocess.run([Path(program).with_name("python"), "-c", VALIDATE, path, CONTEXT, folder / "cache"],
                          capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.slow
def test_rocrate_validator_finds_nothing_that_the_profile_requires(whole, tmp_path):
    """Without network: the terms of RO-Crate's context that packages use lie beside this test."""
    found = validated(whole[0].root / "results.zip", tmp_path)
    assert found["REQUIRED"] == []
    assert [message for message in found["RECOMMENDED"] if not any(word in message for word in UNSAID)] == []


@pytest.mark.slow
def test_rocrate_validator_does_find_what_is_missing(whole, tmp_path):
    with zipfile.ZipFile(tmp_path / "spoilt.zip", "w") as spoilt:
        for name, content in described(whole[0].root / "results.zip")[1].items():
            spoilt.writestr(name, content.replace(b'"instrument"', b'"about"'))
    assert any("instrument" in message for message in validated(tmp_path / "spoilt.zip", tmp_path)["REQUIRED"])
