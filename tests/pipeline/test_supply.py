"""What is installed and run by others' hands is named exactly; what no machine has is said before it is tried."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys

import pytest
import yaml

from pipeline import graph, wheels
from pipeline.cache import fingerprint
from pipeline.study import locate
from stages.about import ATTRIBUTES
from tests.pipeline import documented
from tests.pipeline.toy import HOME, git, put_on_path


def test_actions_are_named_by_commit(repository):
    for path in (repository / ".github/workflows").glob("*.yml"):
        for line in path.read_text().splitlines():
            if "uses:" in line:
                assert re.search(r"uses: [\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+$", line), f"{path.name}: {line}"


def test_every_install_is_by_hash_but_that_of_the_lowest_versions(repository):
    files = [repository / "Makefile", repository / ".ci/run", *(repository / ".github/workflows").glob("*.yml")]
    lines = [line.strip() for path in files for line in path.read_text().splitlines()]
    installs = [line for line in lines if re.search(r"(pip\b|PIP\)) (.* )?install ", f"{line} ")]
    exact = ("--require-hashes", "--no-deps --no-build-isolation")  # the second installs this checkout itself
    loose = [line for line in installs if not any(words in line for words in exact)]
    assert len(installs) == 10 and [line for line in loose if not line.startswith("$(FLOOR)")] == []


def test_keys_have_only_packages_that_every_installation_has(repository):
    """An extra that is installed later, as by `make test`, leaves results current."""
    needed = re.search(r"\ndependencies = \[\n(.*?)\n\]", (repository / "pyproject.toml").read_text(), flags=re.S)
    names = {*re.findall(r'^    "([a-z0-9-]+)', needed[1], flags=re.M)}
    study = locate(start=repository)
    for stage in graph.read(repository).stages.values():
        closure = study.sources.closure(fingerprint.entry_modules(stage, study.package))
        direct = {fingerprint._NAME_OF_MODULE.get(each, each) for each in closure.foreign} - {*sys.stdlib_module_names}
        assert direct <= names, stage.name


@pytest.fixture(scope="module")
def cited(repository):
    """What CITATION.cff and codemeta.json say."""
    citation, meta = (repository / name for name in ("CITATION.cff", "codemeta.json"))
    return yaml.safe_load(citation.read_text()), json.loads(meta.read_text())


def test_what_was_released_has_a_date(repository, cited):
    """In the changelog, the newest released version's in the citation and for programs too."""
    released = re.findall(r"^## (\d\S*) \((.*)\)$", (repository / "CHANGELOG.md").read_text(), flags=re.M)
    assert [version for version, day in released if not re.fullmatch(r"\d{4}-\d\d-\d\d", day)] == []
    citation, meta = cited
    assert f'\nversion = "{citation["version"]}"\n' in (repository / "pyproject.toml").read_text()
    assert (citation["version"], citation["date-released"]) == released[0]
    assert meta["datePublished"] == released[0][1]


def test_codemeta_says_what_the_citation_says(cited):
    citation, meta = cited
    paper, published = citation["preferred-citation"], meta["referencePublication"]
    assert meta["license"].endswith(f"/{citation['license']}")
    assert [author["name"] for author in meta["author"]] == [author["name"] for author in citation["authors"]]
    assert [meta[key] for key in ("name", "version", "keywords", "description")] == [
        citation[key] for key in ("title", "version", "keywords", "abstract")]  # fmt: skip
    assert (published["name"], published["datePublished"]) == (paper["title"], str(paper["year"]))
    assert published["isPartOf"]["name"] == paper["journal"]
    names = [(author["familyName"], author["givenName"]) for author in published["author"]]
    assert names == [(author["family-names"], author["given-names"]) for author in paper["authors"]]


def test_results_say_what_is_cited_and_licensed(repository, cited):
    citation, _ = cited
    paper = citation["preferred-citation"]
    assert (ATTRIBUTES["title"], ATTRIBUTES["license"]) == (citation["title"], citation["license"])
    for part in (*(author["family-names"] for author in paper["authors"]), paper["title"], paper["journal"]):
        assert part in ATTRIBUTES["references"]
    assert ATTRIBUTES["references"].endswith(str(paper["year"]))
    assert (repository / "LICENSE").read_text().startswith("BSD 3-Clause")


def test_the_container_has_an_exact_python_and_the_libraries_that_the_workflows_install(repository):
    text = (repository / "Dockerfile").read_text()
    assert re.search(r"^FROM python:\d+\.\d+\.\d+-\S+ AS tools$", text, flags=re.M)
    nightly = (repository / ".github/workflows/nightly.yml").read_text()
    needed = re.search(r"--no-install-recommends (.*)", nightly)[1].split()
    installed = re.search(r"--no-install-recommends (.*) \\", text)[1].split()
    assert needed and set(needed) <= set(installed)
    container = json.loads((repository / ".devcontainer/devcontainer.json").read_text())
    assert container["build"]["target"] == "tools" and "make study" in text


@pytest.mark.parametrize(
    ("system", "machine", "version", "python", "said"),
    [
        ("linux", "x86_64", ("glibc", "2.27"), (3, 11, 2), ""),
        ("linux", "aarch64", ("glibc", "2.41"), (3, 10, 0), ""),
        ("linux", "x86_64", ("glibc", "2.17"), (3, 11, 2), "has glibc 2.17, and Exudyn needs 2.27 or newer"),
        ("linux", "x86_64", ("", ""), (3, 11, 2), "there is no Exudyn for Linux without glibc"),
        ("linux", "riscv64", ("glibc", "2.41"), (3, 11, 2), "on riscv64: only on x86_64 and aarch64"),
        ("win32", "ARM64", ("", ""), (3, 11, 2), "on ARM64: only on AMD64"),
        ("darwin", "arm64", ("14.1", ""), (3, 14, 0), ""),
        ("darwin", "arm64", ("10.15.7", ""), (3, 11, 2), "this is macOS 10.15.7, and Exudyn needs 11 or newer"),
        ("darwin", "arm64", ("14.1", ""), (3, 9, 1), "only for 3.10 to 3.14"),
        ("darwin", "arm64", ("14.1", ""), (3, 15, 0), "only for 3.10 to 3.14"),
        ("freebsd14", "amd64", ("", ""), (3, 11, 2), "there is no Exudyn for freebsd14"),
    ],
)
def test_a_machine_or_python_without_wheels_is_told(monkeypatch, system, machine, version, python, said):
    monkeypatch.setattr(wheels.sys, "platform", system)
    monkeypatch.setattr(wheels.sys, "version_info", python)
    monkeypatch.setattr(wheels.platform, "machine", lambda: machine)
    for name in ("libc_ver", "mac_ver"):
        monkeypatch.setattr(wheels.platform, name, lambda: version)
    found = wheels.missing()
    assert said in found and bool(found) == bool(said)


def test_an_audit_that_could_not_ask_is_no_success(repository):
    """Without --strict, pip-audit ends with 0 when the index does not answer for any package."""
    lines = [line for line in (repository / "Makefile").read_text().splitlines() if "pip-audit " in line]
    assert lines and all("--strict" in line for line in lines)


def test_pages_put_no_copy_of_the_code_into_the_environment_of_a_checkout(repository):
    pages = "".join(page.read_text(encoding="utf-8") for page in sorted((repository / "docs").glob("*.md")))
    assert re.findall(r"pip\s+install\s+(\S*)\s?'\.\[", pages) == ["--editable"]


def test_make_works_in_a_folder_whose_name_has_a_space(repository, tmp_path):
    """The folder of machine code is one word, and the environment of a folder beside it is none of this one's, nor is
    one into which pip put a copy of the code.
    """
    folder = tmp_path / "my lab"
    (folder / ".venv/bin").mkdir(parents=True)
    (folder / "requirements").mkdir()
    shutil.copy(repository / "Makefile", folder)
    for name in ("pyproject.toml", "requirements/study.txt", ".venv/bin/python", ".venv/installed-study"):
        (folder / name).touch()
    link = folder / ".venv/lib/python3.11/site-packages/__editable__.bipedstudy-0.2.0.pth"
    link.parent.mkdir(parents=True)
    link.touch()
    printed = [subprocess.run(["make", "-n", "wheel"], cwd=folder, text=True, capture_output=True).stdout]
    for place in (folder, tmp_path / "my other", folder):
        if len(printed) == 3:
            link.unlink()
        (folder / ".venv/installed-study").write_text(f"{place}\n")
        printed.append(subprocess.run(["make", "-n", "wheel"], cwd=folder, text=True, capture_output=True).stdout)
    assert all(f"NUMBA_CACHE_DIR={folder}/build/code" in shlex.split(text, comments=True) for text in printed)
    assert ["--editable" in text for text in printed] == [True, False, True, True]


# --- Figures in CI: the script of docs/ci.md does what the page says, in a fresh clone with results that were kept.


#: What has the toy's stage draw a picture in PNG, whose grey follows from a setting.
PICTURE = """\
    from io import BytesIO
    from PIL import Image
    Image.new("L", (20, 10), 20 * len(title)).save(file := BytesIO(), format="png")
    files["figures/one.png"] = file.getvalue()
"""


@pytest.fixture
def hosted(ran, tmp_path_factory):
    """A repository with a study, what was kept of its results, and the commands that a runner has."""
    host = tmp_path_factory.mktemp("host")
    ran.edit("PACKAGE/picture/run.py", "    if parameters", PICTURE + "    if parameters")
    assert ran.command("run-all")[0] == 0
    (ran.root / ".gitignore").write_text("results/\nexpected/\n__pycache__/\n")
    shutil.copytree(ran.root / "results", host / "kept/results")
    git(ran.root, "init", "-q", "-b", "main")
    put_on_path(host / "bin", f"$PWD:{HOME}", "--trust")
    return ran, host


def checked(toy, host, name):
    """What the script of the page says and ends with in a shallow clone called `name` of what the study is now."""
    git(toy.root, "add", "-A")
    git(toy.root, "commit", "-q", "--allow-empty", "-m", name)
    git(host, "clone", "-q", "--depth", "1", toy.root.as_uri(), name)
    (script,) = (block for block in documented.blocks(HOME / "docs/ci.md", "sh") if "--check" in block)
    environment = {**os.environ, "PATH": f"{host / 'bin'}:{os.environ['PATH']}", "KEPT": str(host / "kept"),
                   "COLUMNS": "200"}  # fmt: skip
    done = subprocess.run(["bash", "-c", script], cwd=host / name, env=environment, text=True, capture_output=True)
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("cache", [pytest.param("with", marks=pytest.mark.slow), "without"])
def test_in_a_fresh_clone_only_what_an_edit_touches_is_computed(hosted, cache):
    toy, host = hosted
    if cache == "without":
        shutil.rmtree(host / "kept/results/.cache")
    code, out, errors = checked(toy, host, "same")
    assert code == 0, out + errors
    assert out.count(" current ") == 4 and "0 differ" in out and not (host / "same/results/differences").exists()
    toy.edit("params/picture.yaml", "title: fall", "title: falling")
    code, out, errors = checked(toy, host, "edited")
    assert code == 1, out + errors
    assert out.count(" current ") == 3 and out.count(" computed ") == 1
    assert "beyond what is allowed" in out
    assert [*(host / "edited/results/differences").glob("*.png")]
