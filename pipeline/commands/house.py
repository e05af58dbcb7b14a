"""Housekeeping: `bipedstudy init` lays out a study, `doctor` looks at the machine, `clean` removes what is old."""

import contextlib
import functools
import importlib
import os
import platform
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import click

from pipeline import layout, wheels
from pipeline.cache import bounds, disk, processor
from pipeline.cache.bounds import in_units, size_of
from pipeline.cache.fingerprint import installed
from pipeline.cache.store import QUESTIONS, SWEEPS
from pipeline.commands import options
from pipeline.errors import FAILED, StudyError
from pipeline.graph import FILE_NAME
from pipeline.home import face, home
from pipeline.parameters import loading
from pipeline.parameters.overrides import renewed
from pipeline.parameters.yaml_text import text_of
from pipeline.study import Study, locate, shown

#: Earlier results of this size are worth a word [bytes].
WORTH_A_WORD = 2_000_000_000
GOOD, WARNING, BAD = "good", "warning", "bad"
_LEAST_FREE_MB, _WISHED_FREE_MB = 100, 1000
_SHOWN_DIFFERENCES = 5
#: What the lock has to install a checkout with; later Pythons bring it no more, and no command needs it.
_INSTALLER = "setuptools"
#: Where a host of git repositories looks for what it is to run, and the file of the face that stands there.
_WORKFLOWS = {".github/workflows/figures.yml": "workflow_github.yml", ".gitlab-ci.yml": "workflow_gitlab.yml"}
#: How dvc.yaml marks a stage that measures the program.
_OF_PROGRAM = "    meta: {measures: program}\n"


@click.command("init", epilog=options.examples("init"))
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--update", is_flag=True, help="DIR is a study laid out by an earlier version: renew its graph.")
@click.option("--no-workflow", is_flag=True, help="Leave out the files that check figures on GitHub and GitLab.")
@options.answers_without_rows
def init(folder: Path, update: bool, no_workflow: bool, form: options.Form) -> None:
    """Lay out a new study in DIR: parameters to edit, the graph of stages, a README, and checks for GitHub and GitLab.

    DIR must not exist yet, or be empty. The parameters are those of the study this program comes with. With --update
    dvc.yaml is renewed, missing parameter files, entries and checks are added, and entries move to the file that has
    them now; old files stay beside.
    """
    checks = {} if no_workflow else {place: (face() / name).read_bytes() for place, name in _WORKFLOWS.items()}
    if update:
        form.give(*_update(folder, checks))
        return
    if os.path.lexists(folder) and (not folder.is_dir() or any(folder.iterdir())):  # a link may lead nowhere
        raise StudyError(f"{shown(folder)}: is there already and not an empty folder; choose another")
    target = folder.absolute()
    if str(target).encode(errors="replace").decode() != str(target):
        raise StudyError(f"{str(folder)!a}: is no name in UTF-8, as that of a study's folder must be")
    readme = (face() / "new_study.md").read_text(encoding="utf-8").format(name=target.name)
    files = {**_given(), **checks, "README.md": readme.encode(), ".gitignore": b"results/\n"}
    files[FILE_NAME] = files.pop(FILE_NAME)  # without it, the last, a folder is no study
    # An empty folder may be where the user stands, or a mounted one: it stays the same folder.
    with contextlib.nullcontext(target) if target.exists() else disk.whole(target) as place:
        for name, content in files.items():
            disk.write(place / name, content)
    form.give([f"a new study is in {shown(target)}; next: cd {shown(target)}, and see its README.md"],
              {"study": shown(target)})


def _update(folder: Path, checks: Mapping[str, bytes]) -> tuple[list[str], dict[str, str]]:
    """Bring a study that runs the installed stages to this version; what was done, in lines and by file.

    Raises `StudyError` if it has stages of its own.
    """
    study = locate(start=folder)
    if study.borrowed or study.code_root == study.root:
        raise StudyError(f"{shown(folder)}: is not a study that `init` laid out")
    done: dict[str, str] = {}
    given, classes = _given(), loading.sections(locate(start=home()).parameters_classes().values())
    stems = {Path(name).stem: name for name in given if name != FILE_NAME}
    there = {stem: text_of(study.root / name, name) for stem, name in stems.items() if (study.root / name).exists()}
    entries = renewed(there, {stem: given[name].decode() for stem, name in stems.items()}, loading.keys(classes),
                      loading.needed(classes))  # fmt: skip
    files = {**given, **checks, **{stems[stem]: text.encode() for stem, text in entries.items()}}
    for name, new in files.items():
        path = study.root / name
        old = disk.read(path)
        if old and new != old and (name == FILE_NAME or Path(name).stem in entries):
            done[shown(path)] = f"written anew; the old one is {_put_aside(path, old)}"
            disk.write(path, new)
        elif not path.exists():
            disk.write(path, new)
            done[shown(path)] = "added"
    return [f"{path}: {what}" for path, what in done.items()], done


def _put_aside(path: Path, old: bytes) -> str:
    """Write what a file held beside it, and nothing over; the name there."""
    places = (path.with_name(f"{path.name}.old{number}") for number in ("", *range(2, 1000)))
    kept = next(place for place in places if not place.exists())
    disk.write(kept, old)
    return kept.name


def _given() -> dict[str, bytes]:
    """The parameter files that this program comes with, and its dvc.yaml without the stages' code.

    That lies with the installed package and not in a new study. Stages that measure the program and not a robot run
    there when they are named, and no other stage reads them.
    """
    text = (home() / FILE_NAME).read_text(encoding="utf-8")
    for name in re.findall(rf"^  (\w+):\n    cmd: .*\n{_OF_PROGRAM}", text, flags=re.MULTILINE):
        text = re.sub(rf"(?<!outs:\n)      - results/{name}\.h5\n", "", text)
    text = text.replace(_OF_PROGRAM, "    frozen: true  # measures the program: it runs when it is named\n")
    kept = "".join(line for line in text.splitlines(keepends=True) if not line.strip().startswith("- stages/"))
    graph = re.sub(r"^ *deps:\n(?! *- )", "", kept, flags=re.MULTILINE)
    files = sorted((home() / "params").glob("*.yaml"))
    return {FILE_NAME: graph.encode(), **{f"params/{file.name}": file.read_bytes() for file in files}}


#: One thing looked at; whether it is good, a warning (it runs, but see the text), or bad (it cannot run); and a text.
Finding = tuple[str, str, str]


@click.command("doctor", epilog=options.examples("doctor"))
@options.study
@options.answers_without_rows
def doctor(study: Study, form: options.Form) -> None:
    """Look at what the study needs: Exudyn, versions, folders, compiled code, disk, cores.

    Ends with 1 if something is bad; a warning is no failure.
    """
    findings = list(examine(study))
    form.give((layout.beside(f"{state:<8} {what:<17} ", text) for what, state, text in findings),
              [dict(zip(("what", "state", "text"), found)) for found in findings])
    if any(state == BAD for _, state, _ in findings):
        sys.exit(FAILED)


def examine(study: Study) -> Iterator[Finding]:
    """Look at everything, in the order in which trouble is most likely."""
    lacking = wheels.missing()
    yield "machine", BAD if lacking else GOOD, lacking or f"{platform.system()} on {platform.machine()}"
    yield exudyn()
    yield versions(home() / "requirements/study.txt")
    if not study.borrowed:
        yield writable("results folder", study.results)
    yield writable("temporary folder", Path(tempfile.gettempdir()))
    yield from compiled(study)
    yield free_space(Path.cwd() if study.borrowed else study.results)
    yield from confined()
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    yield "cores", GOOD, f"{count}"
    yield "processor", GOOD, processor.words()


def confined() -> Iterator[Finding]:
    """What keeps a file from outside to itself while it is read, and a stage to its inputs: a process tries it."""
    from pipeline.room import confine, reading

    with tempfile.TemporaryDirectory() as folder:
        for name in ("read", "beside"):
            Path(folder, name).touch()
        (held,) = reading.read(confine.tried, Path(folder, "read"))
    lacking = {confine.FILES: "not confined", confine.SOCKETS: "not confined",
               confine.MEMORY: "bounded by the size of the answer alone", confine.TIME: "ended by the clock"}
    for room, parts in (("reading room", [*lacking]), ("stages", [confine.FILES, confine.SOCKETS])):
        state = GOOD if held.keys() >= {*parts} else WARNING
        yield room, state, "; ".join(f"{what}: {held.get(what, lacking[what])}" for what in parts)


def exudyn() -> Finding:
    """Whether Exudyn's compiled library loads; it needs libGL and libX11 of the system."""
    try:
        importlib.import_module("exudyn").SystemContainer()
        (version,) = installed(["exudyn"])
    except Exception as error:
        hint = "; on Debian: apt-get install libgl1 libx11-6" if "lib" in str(error) else ""
        return "exudyn", BAD, f"does not load: {error}{hint}"
    return "exudyn", GOOD, f"{version}, its library loads"


def versions(lock: Path) -> Finding:
    """Installed packages against the lock file."""
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    if not lock.is_file():
        return "versions", WARNING, f"{python}; there is no lock at {lock} to compare with"
    from packaging.requirements import Requirement  # comes with matplotlib

    wanted = [Requirement(line.rstrip("\\ ")) for line in lock.read_text(encoding="utf-8").splitlines()
              if line[:1].isalnum()]  # fmt: skip
    pinned = {each.name: str(each.specifier).removeprefix("==") for each in wanted
              if each.name != _INSTALLER and (each.marker is None or each.marker.evaluate())}  # fmt: skip
    found = {name: "".join(installed([name])) for name in pinned}
    missing = [name for name, version in found.items() if not version]
    other = [f"{name} {version} instead of {pinned[name]}" for name, version in found.items()
             if version != pinned[name]]  # fmt: skip
    if missing:
        return "versions", BAD, f"{python}; not installed: {', '.join(missing)}; make install"
    if other:
        more = f" and {len(other) - _SHOWN_DIFFERENCES} more" if len(other) > _SHOWN_DIFFERENCES else ""
        return "versions", WARNING, f"{python}; {', '.join(other[:_SHOWN_DIFFERENCES])}{more}"
    return "versions", GOOD, f"{python}; all as in {lock.name}"


def writable(what: str, folder: Path) -> Finding:
    """Whether a file can be made in the folder, or, where it is not there yet, in what is above it."""
    try:
        with tempfile.TemporaryFile(dir=_there(folder)):
            return what, GOOD, f"{shown(folder)} can be written"
    except OSError as error:
        return what, BAD, f"{shown(folder)} cannot be written: {error.strerror}"


def compiled(study: Study) -> Iterator[Finding]:
    """Whether the machine code of stages that compile (those with a module `compiled`) is on disk already."""
    for module in {id(each.CODE): each for each in reversed(study.offered("compiled"))}.values():
        code, stage = module.CODE, module.__name__.split(".")[1]
        if code.refusal:
            text = f"none: {code.refusal}, so every process compiles stage {stage} anew; NUMBA_CACHE_DIR names another"
            yield "compile cache", WARNING, text
        elif code.is_cold():
            yield "compile cache", WARNING, f"cold: the first use of stage {stage} compiles it"
        else:
            yield "compile cache", GOOD, f"warm: stage {stage} in {code.folder}"


def free_space(folder: Path) -> Finding:
    """Free disk space where the results go."""
    free = shutil.disk_usage(_there(folder)).free // 1_000_000
    state = BAD if free < _LEAST_FREE_MB else WARNING if free < _WISHED_FREE_MB else GOOD
    return "free disk", state, f"{free} MB"


def _there(folder: Path) -> Path:
    """The folder, or what is above it where it is not there yet."""
    return next(path for path in (folder, *folder.parents) if path.exists())


@click.command("clean", epilog=options.examples("clean"))
@options.own_study
@click.option("--dry-run", is_flag=True, help="Say what would be removed; remove nothing.")
@click.option("--keep", metavar="N", type=click.IntRange(min=1), help="Keep the N newest results of each stage.")
@click.option("--older-than", metavar="TIME", help="Only what is older: 30d, 12h.")
@click.option("--max-size", metavar="SIZE", help="Only the oldest, until all results take no more: 500MB, 2GB.")
@click.option("--journals", is_flag=True, help="Also stored answers of questions and sweeps; they compute anew.")
@click.option("--machine-code", is_flag=True, help="Also machine code of earlier sources, if only this checkout, on "
              "this branch and in this environment, used it.")  # fmt: skip
@click.option("--wait", is_flag=True, help="Wait for another run in the same results folder.")
@options.answers_without_rows
def clean(
    study: Study, dry_run: bool, keep: int | None, older_than: str | None, max_size: str | None, journals: bool,
    machine_code: bool, wait: bool, form: options.Form,
) -> None:  # fmt: skip
    """Remove earlier results from the cache: all, or those beyond the bounds given; the current results stay.

    After this an undone edit is computed again. A file cache.yaml beside dvc.yaml, with lines as max_size: 500MB,
    older_than: 30d, keep: 3, holds these bounds after every run. What questions and sweeps keep and machine code
    stay, unless named here; --older-than bounds them too.
    """
    try:
        limits = bounds.bounds_of({"keep": keep, "older_than": older_than, "max_size": max_size})
    except ValueError as refused:
        raise StudyError("--" + str(refused).replace("_", "-", 1)) from None
    with contextlib.ExitStack() as locks:
        for folder in (study.results, *([study.results / SWEEPS] if (study.results / SWEEPS).is_dir() else [])):
            said = functools.partial(click.echo, err=True)
            locks.enter_context(disk.locked(folder, shown(folder), "bipedstudy clean", wait, said))
        if not dry_run:
            study.store.sweep()
        found = [(one.folder, one.what, one.size) for one in bounds.beyond(study.store, limits)]
        found += [(place, what, size_of(place)) for place, what in _beside(study, journals, machine_code)
                  if limits.older_than is None or time.time() - place.stat().st_mtime > limits.older_than]  # fmt: skip
        for place, what, size in found:
            if not dry_run:
                disk.remove(place)
            if form.is_text:
                click.echo(layout.beside(f"{in_units(size):>9}  ", f"{what}: {shown(place)}"))
    plain = [{"folder": shown(folder), "what": what, "bytes": size} for folder, what, size in found]
    total, how = in_units(sum(size for _, _, size in found)), "would be removed" if dry_run else "removed"
    form.give([f"{total:>9}  in {len(found)} places {how}"], {"removed": not dry_run, "folders": plain})


def _beside(study: Study, journals: bool, machine_code: bool) -> Iterator[tuple[Path, str]]:
    """Every folder and file beside results that can go, and what it is; no link is followed."""
    store = study.store
    if machine_code:
        folders = {folder for module in study.offered("compiled") for folder in module.CODE.old(1, own=True)}
        beside = (study.code_root / study.package).rglob("__pycache__/numba-*")  # where 0.1.0 kept it
        yield from ((folder, "machine code of earlier sources") for folder in sorted({*folders, *beside}))
    kept = {store.folder / QUESTIONS: "what a question keeps", study.results / SWEEPS / ".cache": "what sweeps keep"}
    for folder, what in kept.items() if journals else ():
        if folder.is_dir() and not (folder.is_symlink() or folder.parent.is_symlink()):
            yield from ((path, what) for path in sorted(folder.glob("*.jsonl"))
                        if not path.is_symlink() and path.is_file())  # fmt: skip
