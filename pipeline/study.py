"""A study on disk: its root with dvc.yaml, its parameters, its results, and the package of stages it runs."""

import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path, PurePath
from types import ModuleType
from typing import Any

from pipeline import graph, trust
from pipeline.cache import disk
from pipeline.cache.sources import Sources, beside
from pipeline.cache.store import Store
from pipeline.errors import Declined, StudyError
from pipeline.graph import Graph, Stage
from pipeline.home import (
    DISTRIBUTION,
    check_one_program,
    face,
    home,
    home_of,
    importable,
    result_class,
    stage_module,
    study_attributes,
)
from pipeline.parameters import loading
from pipeline.parameters.value import declared


@dataclass(frozen=True)
class Study:
    """Where everything is. `settings` are the texts given to `--set`, `requested` those given to requests, by name.

    `cache` is one of another results folder, which is read as well. A `borrowed` study is not the user's: it was taken
    because there is none around the working folder. One that was `found` there has its code run once that is agreed
    to. Parameters name files from its root, or from `recordings`.
    """

    root: Path
    params: Path
    results: Path
    settings: tuple[str, ...] = ()
    package: str = "stages"
    requested: tuple[tuple[str, str], ...] = ()
    borrowed: bool = False
    cache: Path | None = None
    found: bool = False
    recordings: Path | None = None

    @cached_property
    def graph(self) -> Graph:
        """The stages, read from dvc.yaml."""
        return graph.read(self.root)

    @cached_property
    def store(self) -> Store:
        """The cache of the results folder. Raises `StudyError` if a link stands where this program writes."""
        return Store(self.results, {stage.name: stage.outs for stage in self.graph.stages.values()}, self.cache)

    @cached_property
    def code_root(self) -> Path:
        """The folder that holds the package of stages: the study's own if dvc.yaml lists code of it, else installed.

        A folder that only has the same name, beside a study laid out by `init`, is not taken for it. Raises
        `StudyError` for code of a study that nobody agreed to.
        """
        listed = {PurePath(path).parts[0] for stage in self.graph.stages.values() for path in stage.code}
        home = home_of(self.package, self.root if self.package in listed else None)
        if self.found and trust.check(self.root, self.package, home == self.root):
            from pipeline.room import confine

            confine.enter_alone(self.root, self.results, self.package)
        return home

    @cached_property
    def sources(self) -> Sources:
        """The source files of the stages."""
        return Sources(self.code_root, self.package, beside(self.code_root / self.package))

    @cached_property
    def about(self) -> dict[str, str]:
        """What every file of the study says of itself, the program that made it among that."""
        return study_attributes(self.package, self.code_root)

    def parameters(self, names: Iterable[str]) -> dict[str, Any]:
        """Checked parameters of these stages. Raises `StudyError` with a sentence for each error."""
        known, names = self.parameters_classes(), tuple(names)
        for name in names:
            if name not in known:
                raise StudyError(f"stage {name}: there is no module {self.package}.{name}.parameters")
        wanted = {name: known[name] for name in names}
        problems = [text for name, cls in wanted.items() for text in _undeclared(self.graph.stages[name], cls)]
        if problems and self.code_root != self.root:  # dvc.yaml is not the user's own work
            changed = "; ".join((face() / "changed.txt").read_text(encoding="utf-8").splitlines())
            problems.append(f"dvc.yaml was laid out by another version of this program: {changed}; write it anew with: "
                            f"{DISTRIBUTION} init {shown(self.root)} --update")  # fmt: skip
        if problems:
            raise StudyError(problems)
        return loading.load(self.params, self.settings, wanted, list(known.values()), shown(self.params),
                            self.requests, dict(self.requested), _remark)  # fmt: skip

    def parameters_classes(self) -> dict[str, type]:
        """The `Parameters` class of each stage that has one, by name. Raises `StudyError` for a module without it."""
        found = {}
        for name in self.graph.stages:
            module = self.module(name, "parameters")
            if module is not None and not hasattr(module, "Parameters"):
                raise StudyError(f"stage {name}: {module.__name__} has no class Parameters")
            if module is not None:
                found[name] = module.Parameters
        return found

    @cached_property
    def requests(self) -> tuple[ModuleType, ...]:
        """What may be asked of several stages, declared in their modules `request`; see `pipeline.commands.options`."""
        return self.offered("request")

    def offered(self, name: str) -> tuple[ModuleType, ...]:
        """The modules called `name` of all stages that have one, in the graph's order."""
        found = (self.module(stage, name) for stage in self.graph.stages)
        return tuple(module for module in found if module is not None)

    def warnings(self, values: Mapping[str, Any]) -> list[str]:
        """What the stages' modules `warnings` say of parameters (stage -> parameters) before a run."""
        return [sentence for module in self.offered("warnings") for sentence in module.warnings(values)]

    def there(self, path: str, made_by: str = "") -> Path:
        """Where the result `path` lies, a regular file of sensible size.

        Raises `StudyError` if there is none, with the command it is `made_by`, or with why its stage said no.
        """
        place, stage = self.store.place(path), self.graph.maker(path)
        if not place.exists():
            entry = self.store.current(stage)
            if entry is not None and entry.refused:
                raise Declined(f"stage {stage}: {entry.summary}")
            command = f"{DISTRIBUTION} {made_by or f'run {stage}'}"
            raise StudyError(f"{shown(place)} is not there yet; make it with: {command}")
        disk.check(place, shown(place), disk.ARTEFACT)
        return place

    def result(self, stage: str, made_by: str = "") -> Any:
        """The result of a stage as it lies there, whatever made it. Raises `StudyError` as `there` does."""
        from pipeline.cache import artefact  # with h5py, which takes its time
        from pipeline.room import reading

        place = self.there(self.graph.stage(stage).artefact, made_by)
        importable(self.package, self.code_root)
        return artefact.decode(reading.vetted(place, shown(place)), result_class(self.package, stage), str(place))

    def provenance(self, place: Path) -> dict[str, str]:
        """What the artefact at `place` says of its making. Raises `StudyError` for what is none."""
        from pipeline.cache import artefact  # with h5py, which takes its time

        return artefact.provenance(disk.content(place, shown(place)), shown(place))

    def named_files(self, values: Any) -> dict[str, tuple[str, str]]:
        """Files that a stage's parameters name: key -> (file, its SHA-256). Raises `StudyError` for a missing one."""
        found = {}
        for key, (section, name) in loading.files(values).items():
            path = (self.recordings or self.root) / name
            where = f"{shown(self.params)}/{section}.yaml: {key} = {json.dumps(name)}"
            found[key] = str(path), disk.checked_digest(path, where)
        return found

    def module(self, stage: str, name: str) -> ModuleType | None:
        """The module `name` of a stage, or None if it has none. Raises `StudyError` if it cannot be imported."""
        full = f"{self.package}.{stage}.{name}"
        if self.sources.file(full) is None:
            return None
        importable(self.package, self.code_root)
        try:
            return stage_module(self.package, stage, name)
        except (ImportError, AttributeError, SyntaxError, NameError, TypeError) as error:
            raise StudyError(f"stage {stage}: {full} cannot be used: {error}") from None


def locate(
    params: str | None = None,
    results: str | None = None,
    settings: Iterable[str] = (),
    start: Path | None = None,
) -> Study:
    """The study around the folder `start` (default: the working folder), else the one this program comes with.

    That one is *borrowed*: unless a results folder is given, nothing may be written for it. Raises `StudyError` if the
    study is a checkout of this program other than the one that runs, or somebody else's, or `params` or the
    working folder is no folder.
    """
    if params and not Path(params).is_dir():
        raise StudyError(f"--params {params}: there is no such folder")
    try:
        here = (start or Path.cwd()).resolve()
    except FileNotFoundError:
        raise StudyError("the working folder is no longer there; change to another") from None
    around = next((folder for folder in (here, *here.parents) if (folder / graph.FILE_NAME).is_file()), None)
    root = around or home()
    check_one_program(root)
    found = Study(
        root,
        Path(params).absolute() if params else root / "params",
        Path(results).absolute() if results else root / "results",
        tuple(settings),
        borrowed=around is None and results is None,
        found=around is not None,
    )
    if around:
        trust.check(root, found.package, False)
    return found


def shown(path: Path) -> str:
    """A path as messages show it: relative to the working folder where it lies inside."""
    relative = os.path.relpath(path)
    return str(path) if relative.startswith("..") else Path(relative).as_posix()


@cache
def _remark(sentence: str) -> None:
    """Say it on standard error, once."""
    print(f"note: {sentence}", file=sys.stderr)


def _undeclared(stage: Stage, cls: type) -> Iterator[str]:
    """dvc.yaml and the stage's parameter classes must agree, or a change of a parameter would go unseen."""
    read = {file: [key for kind in kinds for key in declared(kind)] for file, kinds in loading.sections([cls]).items()}
    said = f"dvc.yaml: stage {stage.name}"
    for file in {**read, **stage.parameters}:
        listed, used = stage.parameters.get(file, ()), read.get(file, ())
        if listed is not None:
            yield from (f"{said} reads {key} of {file}.yaml, which its params do not list" for key in used
                        if key not in listed)  # fmt: skip
        yield from (f"{said} lists {key} of {file}.yaml, which it does not read" for key in listed or ()
                    if key not in used)  # fmt: skip
        if listed is None and file not in read:
            yield f"{said} lists {file}.yaml, which it does not read"
