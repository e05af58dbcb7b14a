"""Machine code on disk is the user's own, and of the sources as they are: two users, moves, edits, planted code."""

import json
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import time
from importlib import metadata
from pathlib import Path

import pytest

from pipeline.cache.sources import Sources, beside
from stages.analytic.model import made
from stages.biped import machine_code
from tests import commands

unix = pytest.mark.skipif(os.name != "posix", reason="looks at owners and modes")
root = pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="gives files to somebody else")
SOMEBODY_ELSE = 12345
HERE = """
import os
from pathlib import Path
from stages.biped.machine_code import MachineCode
SHIPPED = os.environ.get("SHIPPED")
CODE = MachineCode("toy", Path(__file__).parent, shipped=Path(SHIPPED) if SHIPPED else None)
compiled = CODE.compiled
"""
USED = """
import json
from toy.other import factor
from toy.here import CODE, compiled
@compiled
def times(x):
    return factor() * x
answer = times(7.0)
hits = sum(times.stats.cache_hits.values())
print(json.dumps({"answer": answer, "hits": hits, "folder": str(CODE.folder), "refusal": CODE.refusal}))
"""
AS_USER = """
import email.parser, os, runpy, sys
sys.dont_write_bytecode = True
import numba
if {user} is not None:
    numba.njit(lambda x: 2.0 * x)(1.0)  # loads what that user may not be able to read: this Python's own library
    os.setgroups([])
    os.setgid({user})
    os.setuid({user})
runpy.run_module("toy.used", run_name="__main__")
"""
OTHER = "from toy.here import compiled\n@compiled\ndef factor():\n    return 2.0\n"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package of two compiled functions, one of which calls the other."""
    folder = tmp_path / "installed/toy"
    folder.mkdir(parents=True)
    for name, text in {"here": HERE, "used": USED, "other": OTHER, "__init__": ""}.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def used(package: Path, repository: Path, user: int | None = None, **environment: object) -> dict[str, object]:
    """What a new process, of this user or another, finds: the answer, how many functions were loaded, from where."""
    search = os.pathsep.join([str(package.parent), str(repository)])
    clean = {name: value for name, value in os.environ.items() if name not in ("XDG_CACHE_HOME", "NUMBA_CACHE_DIR")}
    environment = {name: str(value) for name, value in environment.items()}
    done = commands.python(AS_USER.format(user=user), cwd=package.parent,
                           env={**clean, "PYTHONPATH": search, **environment})  # fmt: skip
    assert done.returncode == 0, done.stderr
    found: dict[str, object] = json.loads(done.stdout)
    return found


def edit(package: Path) -> None:
    (package / "other.py").write_text(OTHER.replace("2.0", "3.0"))


@pytest.mark.slow
def test_a_copy_of_the_sources_with_other_times_finds_the_code(package: Path, repository: Path, tmp_path: Path) -> None:
    assert used(package, repository, NUMBA_CACHE_DIR=tmp_path / "cache")["hits"] == 0
    copy = tmp_path / "elsewhere/toy"
    shutil.copytree(package, copy)
    for path in copy.iterdir():
        os.utime(path, (0, 0))
    there = used(copy, repository, NUMBA_CACHE_DIR=tmp_path / "cache")
    assert (there["answer"], there["hits"]) == (14.0, 1)
    assert Path(str(there["folder"])).parent == tmp_path / "cache/bipedstudy"


class Planted:
    """A pickle of it leaves a mark where it is loaded."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> object:
        return Path.touch, (self.mark,)


def plant(folder: Path, mark: Path) -> None:
    """Put code of our own in place of all machine code."""
    for path in folder.rglob("*.nbc"):
        path.write_bytes(pickle.dumps(Planted(mark)))


@root
@pytest.mark.parametrize("place", ["cache", "cache/bipedstudy", "cache/bipedstudy/FOLDER"])
def test_whose_folder_it_is_is_seen_in_each_above_it(tmp_path: Path, place: str) -> None:
    folder = tmp_path / "cache/bipedstudy/FOLDER"
    folder.mkdir(parents=True)
    os.chown(tmp_path / place, SOMEBODY_ELSE, SOMEBODY_ELSE)
    assert machine_code.refusal(folder) == f"{tmp_path / place} belongs to somebody else"


@root
@pytest.mark.slow
@pytest.mark.parametrize("place", ["cache", "cache/bipedstudy", "cache/bipedstudy/FOLDER"])
def test_a_folder_of_somebody_else_is_refused(package: Path, repository: Path, tmp_path: Path, place: str) -> None:
    """Who owns it, or one above it, could put his own code there; with our own folders it would run."""
    cache, mark = tmp_path / "cache", tmp_path / "ran"
    folder = Path(str(used(package, repository, NUMBA_CACHE_DIR=cache)["folder"]))
    plant(folder, mark)
    theirs = tmp_path / place.replace("FOLDER", folder.name)
    os.chown(theirs, SOMEBODY_ELSE, SOMEBODY_ELSE)
    found = used(package, repository, NUMBA_CACHE_DIR=cache)
    assert (found["answer"], found["hits"], found["refusal"]) == (14.0, 0, f"{theirs} belongs to somebody else")
    assert not mark.exists()
    edit(package)
    assert used(package, repository, NUMBA_CACHE_DIR=cache)["answer"] == 21.0


@root
@pytest.mark.slow
def test_two_real_users_of_one_installation_that_both_can_only_read(package: Path, repository: Path) -> None:
    """Neither may read, write or be given the other's code, nor change the installation's."""
    with tempfile.TemporaryDirectory() as name:  # pytest's own folders are closed to others
        folder = Path(name)
        folder.chmod(0o755)
        shutil.copytree(package.parent, folder / "installed")
        homes = {user: folder / str(user) for user in (SOMEBODY_ELSE, SOMEBODY_ELSE + 1)}
        for user, place in homes.items():
            place.mkdir()
            os.chown(place, user, user)
        own = {}
        for answer in (14.0, 21.0):
            for user, place in homes.items():
                for hits in (0, 1):
                    found = used(folder / "installed/toy", repository, user=user, HOME=place)
                    assert (found["answer"], found["hits"], found["refusal"]) == (answer, hits, "")
                own[user] = Path(str(found["folder"]))
                assert own[user].is_relative_to(place) and own[user].stat().st_uid == user
            edit(folder / "installed/toy")
        one, other = homes
        plant(own[other], homes[other] / "ran")
        theirs = {"HOME": homes[one], "XDG_CACHE_HOME": homes[other] / ".cache"}
        found = used(folder / "installed/toy", repository, user=one, **theirs)
        assert found["hits"] == 0 and found["refusal"] and not (homes[other] / "ran").exists()
        assert not [path for path in (folder / "installed").rglob("*") if path.stat().st_uid != os.geteuid()]


@unix
@pytest.mark.parametrize(("place", "mode", "refused"), [
    ("cache", 0o777, True), ("cache", 0o770, True), ("cache/bipedstudy", 0o702, True), ("cache", 0o1777, False),
    ("cache/bipedstudy", 0o1777, True), ("cache", 0o755, False),
])  # fmt: skip
def test_a_folder_that_others_may_write_is_refused(
    tmp_path: Path, place: str, mode: int, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine_code, "_is_alone", lambda found: False)
    (tmp_path / "cache/bipedstudy").mkdir(parents=True)
    (tmp_path / place).chmod(mode)
    said = machine_code.refusal(tmp_path / "cache/bipedstudy")
    assert said == (f"others may write in {tmp_path / place}" if refused else "")


@unix
def test_a_link_is_followed_before_it_is_judged(tmp_path: Path) -> None:
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    (tmp_path / "cache").symlink_to(tmp_path / "open")
    assert machine_code.refusal(tmp_path / "cache/bipedstudy") == f"others may write in {tmp_path / 'open'}"


@pytest.mark.parametrize("variable", ["HOME", "XDG_CACHE_HOME"])
@unix
def test_without_any_folder_nothing_is_kept(
    package: Path, repository: Path, tmp_path: Path, variable: str
) -> None:
    (tmp_path / "file").touch()
    found = used(package, repository, **{variable: tmp_path / "file"})
    assert (found["answer"], found["hits"]) == (14.0, 0) and "cannot be written" in str(found["refusal"])
    assert not list(package.parent.rglob("*.nbc"))


@pytest.mark.slow
def test_shipped_code_is_read_and_never_written(package: Path, repository: Path, tmp_path: Path) -> None:
    """What a wheel brings: used where the user has no folder, and left as it is."""
    folder = Path(str(used(package, repository, NUMBA_CACHE_DIR=tmp_path / "cache")["folder"]))
    shipped = shutil.copytree(folder, tmp_path / "shipped")
    (tmp_path / "file").touch()
    before = {path: path.read_bytes() for path in shipped.iterdir()}
    assert used(package, repository, NUMBA_CACHE_DIR=tmp_path / "file", SHIPPED=shipped)["hits"] == 1
    edit(package)
    found = used(package, repository, NUMBA_CACHE_DIR=tmp_path / "new", SHIPPED=shipped)
    assert (found["answer"], found["hits"]) == (21.0, 0)
    assert used(package, repository, NUMBA_CACHE_DIR=tmp_path / "new", SHIPPED=shipped)["hits"] == 1
    assert {path: path.read_bytes() for path in shipped.iterdir()} == before


@pytest.mark.slow
def test_code_for_any_processor_serves_this_one(package: Path, repository: Path, tmp_path: Path) -> None:
    """What `make wheel` compiles."""
    generic = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    made = used(package, repository, NUMBA_CACHE_DIR=tmp_path / "cache", **generic)
    shipped = shutil.copytree(Path(str(made["folder"])), tmp_path / "shipped")
    found = used(package, repository, NUMBA_CACHE_DIR=tmp_path / "new", SHIPPED=shipped)
    assert (found["answer"], found["hits"]) == (made["answer"], 1)


@pytest.mark.slow
def test_damaged_code_is_compiled_again(package: Path, repository: Path, tmp_path: Path) -> None:
    """A flipped bit of machine code is another number or a crash."""
    cache = tmp_path / "cache"
    folder = Path(str(used(package, repository, NUMBA_CACHE_DIR=cache)["folder"]))
    (path,) = folder.glob("*times*.nbc")
    content = bytearray(path.read_bytes())
    content[2 * len(content) // 3] ^= 8
    for damaged in (bytes(content), bytes(content)[:100], b""):
        path.write_bytes(damaged)
        found = used(package, repository, NUMBA_CACHE_DIR=cache)
        assert (found["answer"], found["hits"]) == (14.0, 0)
    assert used(package, repository, NUMBA_CACHE_DIR=cache)["hits"] == 1


def test_old_code_is_removed_but_the_last_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    sources = tmp_path / "sources"
    sources.mkdir()
    kept = []
    for number in range(7):
        (sources / "one.py").write_text(str(number))
        code = machine_code.MachineCode("toy", sources)
        code.begin()
        os.utime(code.folder, (number, number))
        kept.append(code.folder)
    mine = tmp_path / "cache/bipedstudy/mine"
    mine.mkdir()
    assert [path.exists() for path in kept] == [False] * 3 + [True] * machine_code.KEPT and mine.exists()
    assert set(code.old(1)) == set(kept[3:6])


def test_code_of_another_python_is_none_of_this_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was called warm, and a command compiled for half a minute without a word."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    code = machine_code.MachineCode("toy", tmp_path)
    code.leave("one.nbc", b"")
    assert not machine_code.MachineCode("toy", tmp_path).is_cold()
    monkeypatch.setattr(sys.implementation, "cache_tag", "cpython-399")
    assert machine_code.MachineCode("toy", tmp_path).is_cold()


def test_old_code_that_others_use_is_not_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another checkout, another branch, another environment: each is told from the others by its own file."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "checkout/.git").mkdir(parents=True)
    monkeypatch.setattr(machine_code, "__file__", str(tmp_path / "checkout/stages/biped/machine_code/__init__.py"))
    sources = tmp_path / "sources"
    sources.mkdir()

    now = time.time() - 100.0

    def used_by(number: int, branch: str, prefix: str = "/env") -> Path:
        (tmp_path / "checkout/.git/HEAD").write_text(f"ref: refs/heads/{branch}\n")
        monkeypatch.setattr(sys, "prefix", prefix)
        machine_code._user.cache_clear()
        (sources / "one.py").write_text(str(number))
        code = machine_code.MachineCode("toy", sources)
        code.begin()
        os.utime(code.folder, (now + number, now + number))
        return code.folder

    first, second, shared = used_by(1, "main"), used_by(2, "main"), used_by(3, "main")
    used_by(4, "other"), used_by(5, "main", "/env-2"), used_by(3, "other")
    used_by(2, "main")
    used_by(6, "main")
    code = machine_code.MachineCode("toy", sources)
    assert set(code.old(1, own=True)) == {first, second} and shared in code.old(1)
    machine_code._user.cache_clear()


def test_code_that_another_checkout_may_be_using_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    for number in range(machine_code.KEPT + 3):
        (tmp_path / "one.py").write_text(str(number))
        machine_code.MachineCode("toy", tmp_path).begin()
    assert len(list((tmp_path / "cache/bipedstudy").iterdir())) == machine_code.KEPT + 3


@pytest.mark.parametrize(("stage", "mark"), [("analytic", "stages.analytic.compiled"), ("twin", "kept_with_ground")])
def test_every_source_of_compiled_code_is_in_its_digest(repository: Path, stage: str, mark: str) -> None:
    """The import closure of all modules that compile lies in the folders whose digest names the machine code."""
    from stages.analytic import compiled as analytic
    from stages.ground import compiled as ground

    folders = {"analytic": analytic.SOURCES, "twin": ground.sources(repository / "stages/twin/machine")}[stage]
    modules = [path.relative_to(repository).with_suffix("").as_posix().replace("/", ".")
               for path in (repository / "stages" / stage).rglob("*.py") if mark in path.read_text()]  # fmt: skip
    memo = beside(repository / "stages")  # parsing takes seconds, once
    files = Sources(repository, "stages", memo).closure(modules).files
    memo.save()
    inside = [folder.relative_to(repository) for folder in folders]
    outside = [file for file in files if not any(Path(file).is_relative_to(folder) for folder in inside)]
    assert modules and [file for file in outside if not file.endswith("__init__.py")] == []


def test_what_equations_are_derived_from_and_by_is_in_the_keys(repository: Path) -> None:
    """A key names the derivation and sympy's version, and so the text: by one version it is the same everywhere."""
    memo = beside(repository / "stages")
    closure = Sources(repository, "stages", memo).closure(["stages.analytic.run"])
    memo.save()
    assert "sympy" in closure.foreign and "stages/analytic/model/derivation.py" in closure.files
    assert made.EQUATIONS.folder.name.startswith(f"equations-{metadata.version('sympy')}-")


def made_in(folder: Path) -> list[Path]:
    """All files below a folder but the empty ones that name who uses it."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    return [path for path in files if not path.name.startswith(machine_code._USER) or path.stat().st_size]


def test_a_text_is_made_once_and_again_where_it_is_damaged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is left whole, for who made it alone, and belongs to the sources; what is brought serves reads only."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    made: list[str] = []

    def make() -> str:
        made.append("made")
        return "a = 1\n"

    def kept(by: str = "", shipped: Path | None = None) -> machine_code.Kept:
        return machine_code.Kept("texts", tmp_path / "sources", by=by, shipped=shipped)

    text = kept().text("a.txt", make)
    path = kept().folder / "a.txt"
    assert text == path.read_text() == machine_code.sealed("a = 1\n") == kept().text("a.txt", make)
    assert len(made) == 1 and made_in(kept().folder) == [path] and (os.name != "posix" or not
                                                                         path.parent.stat().st_mode & 0o77)  # fmt: skip
    content = path.read_bytes()
    for damaged in (content.replace(b"1", b"2", 1), content[:-30], b"", b"\xff\xfe"):
        path.write_bytes(damaged)
        assert kept().text("a.txt", make) == text == path.read_text()
    assert len(made) == 5
    (tmp_path / "sources").mkdir()
    (tmp_path / "sources/one.py").write_text("1")
    assert len({path.parent, kept().folder, kept("other").folder}) == 3
    assert kept(shipped=path.parent).text("a.txt", make) == text and len(made) == 5 and not kept().folder.exists()


def test_a_text_serves_where_none_can_be_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a folder of one's own it is made each time, and with a full disk too."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    kept = machine_code.Kept("texts", tmp_path, by="")
    monkeypatch.setattr(kept, "_leave", lambda *_: (_ for _ in ()).throw(OSError("full")))
    assert kept.text("a.txt", str) == machine_code.sealed("")
    kept.refusal = "others may write"
    assert kept.text("a.txt", str) == machine_code.sealed("") and not kept.folder.exists()


@unix
@pytest.mark.slow
def test_code_serves_where_the_disk_is_full(package: Path, repository: Path, tmp_path: Path) -> None:
    """A home that is full keeps nobody from computing, and nothing half-written is left."""
    (package.parent / "sitecustomize.py").write_text("import resource as r; r.setrlimit(r.RLIMIT_FSIZE, (0, 0))\n")
    for _ in range(2):
        found = used(package, repository, HOME=tmp_path / "full")
        assert (found["answer"], found["hits"], found["refusal"]) == (14.0, 0, "")
    assert not made_in(tmp_path / "full")


#: Python runs it when it starts: there is no sympy, which says so in its own way.
NO_SYMPY = "import sys\nsys.modules['sympy'] = None\n"


@pytest.mark.parametrize("place", ["cache", None])
@pytest.mark.slow
def test_without_sympy_what_is_there_serves_or_one_sentence_says_so(repository: Path, tmp_path: Path, place: str | None,
                                                                    ) -> None:
    """Where the equations have been derived it is not even looked for; else nothing is left behind."""
    made.derived(made.EQUATIONS, "plain_terms", made.by_sympy)
    (tmp_path / "sitecustomize.py").write_text(NO_SYMPY)
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / place)} if place else {}
    path = os.pathsep.join([str(tmp_path), str(repository)])
    done = commands.afresh("gait", "--json", cwd=repository, PYTHONPATH=path, **cache)
    if not place:
        assert done.returncode == 0 and '"period_s"' in done.stdout and "deriving" not in done.stderr, done.stderr
        return
    assert done.returncode == 3 and "Traceback" not in done.stderr and "deriving" not in done.stderr
    assert "cannot be derived without sympy" in json.loads(done.stdout)["reason"]
    assert not [*(tmp_path / place).rglob("*.txt"), *(tmp_path / place).rglob("*.tmp")]


#: Makes a text, or is killed while it does.
MAKES = """
import sys, time
from pathlib import Path
from stages.biped.machine_code import Kept

def make():
    print("making", flush=True)
    time.sleep(float(sys.argv[2]))
    return "a = 1\\n"

print(Kept("texts", Path(sys.argv[1]), by="").text("a.txt", make), end="")
"""


@pytest.mark.slow
def test_processes_that_make_a_text_at_once_leave_one_and_a_killed_one_leaves_none(
    repository: Path, tmp_path: Path
) -> None:
    environment = {**os.environ, "PYTHONPATH": str(repository), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def maker(seconds: float) -> subprocess.Popen[str]:
        return subprocess.Popen([sys.executable, "-c", MAKES, str(tmp_path), str(seconds)], env=environment, text=True,
                                stdout=subprocess.PIPE)  # fmt: skip

    killed = maker(600.0)
    assert killed.stdout is not None and killed.stdout.readline() == "making\n"
    killed.kill()
    killed.communicate()
    assert not [path for path in (tmp_path / "cache").rglob("*") if path.is_file()]
    found = [process.communicate(timeout=300)[0] for process in [maker(1.0), maker(1.0)]]
    sealed = machine_code.sealed("a = 1\n")
    assert all(each.endswith(sealed) for each in found)
    (left,) = made_in(tmp_path / "cache")
    assert (left.name, left.read_text()) == ("a.txt", sealed)
