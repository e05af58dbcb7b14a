"""The graph of the study, read from dvc.yaml: the one register of stages, their inputs, parameters and outputs."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from pipeline.errors import StudyError, nearest
from pipeline.parameters import yaml_text

FILE_NAME = "dvc.yaml"
#: Letters that a stage's name may have: files are called by it, and file systems have limits.
LONGEST_NAME = 100
_KEYS = ("cmd", "meta", "frozen", "deps", "params", "outs", "metrics", "plots")
#: What only DVC reads: which of the results it compares, as numbers and as curves.
_SHOWN = ("metrics", "plots")
_RESULTS = "results"
_FORBIDDEN = '\\:*?"<>|\0'
#: What this program itself reads of the results, where a stage makes it, and the page it writes there.
CLAIMS, CAPTIONS, FIGURES = "results/claims.yaml", "results/captions.yaml", "results/figures"
REPORT, PROOF = "report.html", "proof.json"
#: Files and folders in results/ that no stage makes.
OWN = ("differences", "drawn", "log", "log.jsonl", PROOF, REPORT, "sweeps", "README.md")


@dataclass(frozen=True)
class Stage:
    """One stage: what it reads and what it makes, as dvc.yaml declares it. Paths are relative to the study's root.

    A `frozen` one runs only when it is named, as in DVC.
    """

    name: str
    code: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: Mapping[str, tuple[str, ...] | None]
    outs: tuple[str, ...]
    frozen: bool = False

    @property
    def artefact(self) -> str:
        """The HDF5 file of the stage's result: results/<name>.h5."""
        return f"{_RESULTS}/{self.name}.h5"


@dataclass(frozen=True)
class Graph:
    """All stages in an order in which each comes after those it depends on."""

    stages: Mapping[str, Stage]

    @property
    def usual(self) -> tuple[str, ...]:
        """Names of the stages that run without being named, in order."""
        return tuple(name for name, stage in self.stages.items() if not stage.frozen)

    def maker(self, path: str) -> str:
        """Name of the stage that makes the result `path`. Raises `StudyError` where none does."""
        for stage in self.stages.values():
            if path in stage.outs:
                return stage.name
        raise StudyError(f"dvc.yaml has no stage that makes {path}")

    def upstream(self, name: str) -> tuple[str, ...]:
        """Names of the stages whose results stage `name` reads."""
        return tuple(dict.fromkeys(self.maker(path) for path in self.stages[name].inputs))

    def needed_for(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """`names` and everything upstream of them, in order."""
        wanted = set(names)
        for name in reversed(list(self.stages)):
            if name in wanted:
                wanted.update(self.upstream(name))
        return tuple(name for name in self.stages if name in wanted)

    def stage(self, name: str) -> Stage:
        """The stage called `name`; raises `StudyError` with the nearest name if there is none."""
        if name not in self.stages:
            known = ", ".join(self.stages)
            raise StudyError(f'there is no stage "{name}" (stages: {known}){nearest(name, self.stages)}')
        return self.stages[name]


def read(root: Path) -> Graph:
    """Read `root`/dvc.yaml; raises `StudyError` naming every line this pipeline does not understand."""
    tree, problems = yaml_text.read(root / FILE_NAME, FILE_NAME), list[str]()
    top = tree.value if isinstance(tree.value, dict) else {}
    if {*top} - {*_SHOWN} != {"stages"} or not isinstance(top["stages"].value, dict) or not top["stages"].value:
        raise StudyError(f'{root / FILE_NAME}: expected the key "stages" with the stages under it, and beside it only '
                         f"{' and '.join(_SHOWN)}")  # fmt: skip
    stages = [_stage(name, node, problems) for name, node in top["stages"].value.items()]
    if problems:
        raise StudyError(problems)
    _check_paths(stages)
    return Graph({stage.name: stage for stage in _sorted(stages)})


def _stage(name: str, node: yaml_text.Node, problems: list[str]) -> Stage:
    entry = node.value if isinstance(node.value, dict) else {}
    for key in entry:
        if key not in _KEYS:
            problems.append(
                f'{FILE_NAME}:{entry[key].line}: stage {name}: the key "{key}" is not understood here '
                f"(only {', '.join(_KEYS)}){nearest(key, _KEYS)}"
            )
    command = entry["cmd"].plain() if "cmd" in entry else None
    if command != f"bipedstudy run {name}":
        problems.append(f'{FILE_NAME}:{node.line}: stage {name}: cmd must be "bipedstudy run {name}", not {command!r}')
    if len(name) > LONGEST_NAME:
        problems.append(
            f"{FILE_NAME}:{node.line}: stage {name}: a name of {len(name)} letters; allowed: {LONGEST_NAME}")
    frozen = entry["frozen"].value if "frozen" in entry else False
    if not isinstance(frozen, bool):
        line = entry["frozen"].line
        problems.append(f"{FILE_NAME}:{line}: stage {name}: frozen must be true or false, not {frozen!r}")
    deps = _paths(name, "deps", entry, problems)
    outs = tuple(path for key in ("outs", *_SHOWN) for path in _paths(name, key, entry, problems))
    if f"{_RESULTS}/{name}.h5" not in outs:
        problems.append(f"{FILE_NAME}:{node.line}: stage {name}: outs must list {_RESULTS}/{name}.h5")
    return Stage(
        name,
        code=tuple(path for path in deps if not _is_result(path)),
        inputs=tuple(path for path in deps if _is_result(path)),
        parameters=_parameters(name, entry, problems),
        outs=outs,
        frozen=frozen is True,
    )


def _paths(name: str, key: str, entry: dict[str, yaml_text.Node], problems: list[str]) -> tuple[str, ...]:
    items = entry[key].value if key in entry else []
    paths: list[str] = []
    for item in items if isinstance(items, list) else [entry[key]]:
        if key in _SHOWN and isinstance(item.value, dict) and len(item.value) == 1:  # the path, and how DVC shows it
            item = yaml_text.Node(next(iter(item.value)), item.line)
        paths.append(PurePosixPath(item.value).as_posix() if isinstance(item.value, str) else "")
        said = f"{FILE_NAME}:{item.line}: stage {name}: {key}"
        if not isinstance(item.value, str):
            problems.append(f"{said} must be a list of plain paths")
        elif not is_inside(paths[-1]) or (key != "deps" and not _is_result(paths[-1])):
            problems.append(f"{said}: {item.value} lies outside the study")
        elif key != "deps" and _is_own(paths[-1]):
            problems.append(f"{said}: {item.value} is this program's own place")
    return tuple(paths)


def _parameters(
    name: str, entry: dict[str, yaml_text.Node], problems: list[str]
) -> dict[str, tuple[str, ...] | None]:
    """File stem -> keys, or None for every key of the file. Entries look like `params/ground.yaml: [gravity]`."""
    files: dict[str, tuple[str, ...] | None] = {}
    listed = entry["params"].value if "params" in entry else []
    if not isinstance(listed, list):
        problems.append(f"{FILE_NAME}:{entry['params'].line}: stage {name}: params must be a list")
        return {}
    for item in listed:
        pairs: dict[str, Any] = item.plain() if isinstance(item.value, dict) else {str(item.value): None}
        for file, keys in pairs.items():
            path = PurePosixPath(file)
            if path.suffix != ".yaml" or path.parent.as_posix() != "params" or not isinstance(keys, (list, type(None))):
                problems.append(
                    f"{FILE_NAME}:{item.line}: stage {name}: params must be lines like "
                    f'"params/ground.yaml: [gravity]" or "params/ground.yaml:" for the whole file'
                )
            else:
                files[path.stem] = None if keys is None else tuple(str(key) for key in keys)
    return files


def _is_result(path: str) -> bool:
    return path.startswith(_RESULTS + "/")


def is_inside(path: str) -> bool:
    """Whether a path stays inside the study and means one place on every platform.

    No root, drive or step up, no sign that some platform forbids, no part that ends in a dot or blank, which Windows
    drops, and no second spelling of the same path.
    """
    whole = all(part and part == part.rstrip(". ") for part in path.split("/"))
    return whole and not any(sign in path for sign in _FORBIDDEN)


def beneath(name: str, paths: Iterable[str]) -> list[str]:
    """Those of `paths` that are the file `name`, or lie in the folder `name`."""
    return [path for path in paths if path == name or path.startswith(f"{name}/")]


def _is_own(path: str) -> bool:
    """Whether a path in results/ is kept for what this program itself writes there."""
    first = path.removeprefix(_RESULTS + "/").partition("/")[0]
    return first.startswith(".") or first in OWN


def _check_paths(stages: list[Stage]) -> None:
    maker: dict[str, str] = {}
    problems = []
    for stage in stages:
        for out in stage.outs:
            if out in maker:
                both = f"both {maker[out]} and {stage.name}" if maker[out] != stage.name else f"{stage.name} twice"
                problems.append(f"{FILE_NAME}: {out} is made by {both}")
            problems += [
                f"{FILE_NAME}: {out} of stage {stage.name} and {other} of stage {maker[other]} lie in each other"
                for other in maker
                if other.startswith(f"{out}/") or out.startswith(f"{other}/")
            ]
            maker[out] = stage.name
    problems += [
        f"{FILE_NAME}: stage {stage.name} reads {path}, which no stage makes{nearest(path, maker)}"
        for stage in stages
        for path in stage.inputs
        if path not in maker
    ]
    frozen = {stage.name for stage in stages if stage.frozen}
    problems += [
        f"{FILE_NAME}: stage {stage.name} reads {path}, but stage {maker[path]} is frozen and runs only when it is "
        "named; leave one of both out"
        for stage in stages
        for path in stage.inputs
        if maker.get(path) in frozen and stage.name not in frozen
    ]
    if problems:
        raise StudyError(problems)


def _sorted(stages: list[Stage]) -> Iterator[Stage]:
    """Kahn's order, keeping the file's order among stages that do not depend on each other."""
    waiting, made = list(stages), set[str]()
    while waiting:
        ready = next((stage for stage in waiting if made.issuperset(stage.inputs)), None)
        if ready is None:
            raise StudyError(f"{FILE_NAME}: these stages wait for each other: {', '.join(s.name for s in waiting)}")
        waiting.remove(ready)
        made.update(ready.outs)
        yield ready
