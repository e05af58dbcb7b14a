"""`bipedstudy doctor`: what a machine must have for the study to run, looked at one by one."""

from __future__ import annotations

import dataclasses
import importlib
import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click

from pipeline import layout, wheels
from pipeline.cache import processor
from pipeline.cache.fingerprint import installed
from pipeline.commands import options
from pipeline.errors import FAILED
from pipeline.home import home
from pipeline.study import Study, shown

GOOD, WARNING, BAD = "good", "warning", "bad"
_LEAST_FREE_MB, _WISHED_FREE_MB = 100, 1000
_SHOWN_DIFFERENCES = 5


@dataclass(frozen=True)
class Finding:
    """One thing looked at: good, a warning (it runs, but see the text), or bad (it cannot run)."""

    what: str
    state: str
    text: str


@click.command("doctor", epilog=options.examples("doctor"))
@options.study
@options.answers_without_rows
def doctor(study: Study, form: options.Form) -> None:
    """Look at what the study needs: Exudyn, versions, folders, compiled code, disk, cores.

    Ends with 1 if something is bad; a warning is no failure.
    """
    findings = list(examine(study))
    form.give((layout.beside(f"{found.state:<8} {found.what:<17} ", found.text) for found in findings),
              [dataclasses.asdict(found) for found in findings])  # fmt: skip
    if any(found.state == BAD for found in findings):
        sys.exit(FAILED)


def examine(study: Study) -> Iterator[Finding]:
    """Look at everything, in the order in which trouble is most likely."""
    lacking = wheels.missing()
    yield Finding("machine", BAD if lacking else GOOD, lacking or f"{platform.system()} on {platform.machine()}")
    yield exudyn()
    yield versions(home() / "requirements/study.txt")
    if not study.borrowed:
        yield writable("results folder", study.results)
    yield writable("temporary folder", Path(tempfile.gettempdir()))
    yield from compiled(study)
    yield free_space(Path.cwd() if study.borrowed else study.results)
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    yield Finding("cores", GOOD, f"{count}")
    yield Finding("processor", GOOD, processor.words())


def exudyn() -> Finding:
    """Whether Exudyn's compiled library loads; it needs libGL and libX11 of the system."""
    try:
        importlib.import_module("exudyn").SystemContainer()
        (version,) = installed(["exudyn"])
    except Exception as error:
        hint = "; on Debian: apt-get install libgl1 libx11-6" if "lib" in str(error) else ""
        return Finding("exudyn", BAD, f"does not load: {error}{hint}")
    return Finding("exudyn", GOOD, f"{version}, its library loads")


def versions(lock: Path) -> Finding:
    """Installed packages against the lock file."""
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}"
    if not lock.is_file():
        return Finding("versions", WARNING, f"{python}; there is no lock at {lock} to compare with")
    from packaging.requirements import Requirement  # comes with matplotlib

    wanted = [Requirement(line.rstrip("\\ ")) for line in lock.read_text(encoding="utf-8").splitlines()
              if line[:1].isalnum()]  # fmt: skip
    pinned = {each.name: str(each.specifier).removeprefix("==") for each in wanted
              if each.marker is None or each.marker.evaluate()}  # fmt: skip
    found = {name: "".join(installed([name])) for name in pinned}
    missing = [name for name, version in found.items() if not version]
    other = [f"{name} {version} instead of {pinned[name]}" for name, version in found.items()
             if version != pinned[name]]  # fmt: skip
    if missing:
        return Finding("versions", BAD, f"{python}; not installed: {', '.join(missing)}; make install")
    if other:
        more = f" and {len(other) - _SHOWN_DIFFERENCES} more" if len(other) > _SHOWN_DIFFERENCES else ""
        return Finding("versions", WARNING, f"{python}; {', '.join(other[:_SHOWN_DIFFERENCES])}{more}")
    return Finding("versions", GOOD, f"{python}; all as in {lock.name}")


def writable(what: str, folder: Path) -> Finding:
    """Whether a file can be made in the folder, or, where it is not there yet, in what is above it."""
    try:
        with tempfile.TemporaryFile(dir=_there(folder)):
            return Finding(what, GOOD, f"{shown(folder)} can be written")
    except OSError as error:
        return Finding(what, BAD, f"{shown(folder)} cannot be written: {error.strerror}")


def compiled(study: Study) -> Iterator[Finding]:
    """Whether the machine code of stages that compile (those with a module `compiled`) is on disk already."""
    for module in study.offered("compiled"):
        code, stage = module.CODE, module.__name__.split(".")[1]
        if code.refusal:
            text = f"none: {code.refusal}, so every process compiles stage {stage} anew; NUMBA_CACHE_DIR names another"
            yield Finding("compile cache", WARNING, text)
        elif code.is_cold():
            yield Finding("compile cache", WARNING, f"cold: the first use of stage {stage} compiles it")
        else:
            yield Finding("compile cache", GOOD, f"warm: stage {stage} in {code.folder}")


def free_space(folder: Path) -> Finding:
    """Free disk space where the results go."""
    free = shutil.disk_usage(_there(folder)).free // 1_000_000
    state = BAD if free < _LEAST_FREE_MB else WARNING if free < _WISHED_FREE_MB else GOOD
    return Finding("free disk", state, f"{free} MB")


def _there(folder: Path) -> Path:
    """The folder, or what is above it where it is not there yet."""
    return next(path for path in (folder, *folder.parents) if path.exists())
