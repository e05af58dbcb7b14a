"""What a point computes: the swept stage, and of the stages above it those that a varied parameter touches.

The others are brought up to date once, like for `bipedstudy run`, and their results are handed to every worker.
"""

import dataclasses
import json
import os
from collections.abc import Mapping
from typing import Any

from pipeline.cache import bounds, disk, fingerprint
from pipeline.errors import StudyError
from pipeline.execution.display import Display
from pipeline.execution.executor import bring_up_to_date
from pipeline.execution.job import Job, engine_code
from pipeline.graph import beneath
from pipeline.parameters import loading
from pipeline.parameters.overrides import Override, applied, parsed
from pipeline.parameters.value import Refused, broken_rules, checked, declared, plain_value, without
from pipeline.parameters.yaml_text import Node
from pipeline.study import Study, shown
from pipeline.sweep.spec import Range, Spec


class Chain:
    """The stages that every point computes, and their parameters at a point."""

    def __init__(self, study: Study, spec: Spec) -> None:
        self.study, self.spec = study, spec
        study.graph.stage(spec.stage)
        self.names = study.graph.needed_for((spec.stage,))
        self.base = study.parameters(self.names)
        known = loading.keys(loading.sections(study.parameters_classes().values()))
        self._overrides = {name: self._parsed(name, known) for name in spec.names}
        self.touched = self._touched()
        self._check()
        #: What all points share: code, versions and inputs of the touched stages. Known once the job is made.
        self.ground: dict[str, Any] = {}

    def parameters(self, point: Mapping[str, Any]) -> dict[str, Any]:
        """Parameters of the touched stages at a point. Raises `StudyError` naming the value that is not allowed."""
        return {name: self._varied(self.base[name], point) for name in self.touched}

    def key(self, values: Mapping[str, Any]) -> str:
        """What the result of a point is known by: code, versions, inputs and every parameter of the touched stages."""
        plain = {name: loading.as_plain(value) for name, value in values.items()}
        named = {name: {key: sha for key, (_, sha) in self.study.named_files(value).items()}
                 for name, value in values.items() if loading.files(value)}  # fmt: skip
        text = json.dumps([plain, named], sort_keys=True, separators=(",", ":"))
        return disk.digest(text.encode())[:32]

    def job(self, display: Display) -> Job:
        """The job of this chain, after the stages that no point changes have been brought up to date.

        The code is read here, once: what the workers really import is held against it.
        """
        study, code, versions = self.study, {}, {}
        read = {maker for name in self.touched for maker in study.graph.upstream(name)}
        fixed, contents = self._made(tuple(name for name in self.names if name in read - {*self.touched}), display)
        stages = tuple(study.graph.stages[name] for name in self.touched)
        for stage in stages:
            inputs = {path: contents[path] for name in stage.inputs for path in beneath(name, contents)}
            parts = self.ground[stage.name] = fingerprint.ingredients(stage, study.sources, {}, inputs)
            code.update(parts["code"])
            versions.update(parts["versions"])
        study.sources.memo.save()
        return Job(study.package, str(study.code_root), str(study.root), stages, code, contents=fixed,
                   versions=versions, engine=engine_code(), time_limit_s=self.spec.time_limit_s,
                   start_limit_s=self.spec.start_limit_s)  # fmt: skip

    def _made(self, above: tuple[str, ...], display: Display) -> tuple[dict[str, bytes], dict[str, str]]:
        """Path -> content of what the stages `above` made, and its hash."""
        fixed, contents, study = {}, {}, self.study
        if above:
            values = {name: self.base[name] for name in study.graph.needed_for(above)}
            with disk.locked(study.results, shown(study.results), "bipedstudy sweep", True, display.note):
                bring_up_to_date(study, values, display, jobs=os.cpu_count() or 1)
                bounds.hold(study.store, bounds.read(study.root), display.note)
                for name in above:
                    entry = study.store.current(name)
                    assert entry is not None
                    for path, made in entry.outs.items():
                        fixed[path] = disk.read(study.store.place(path)) or b""
                        contents[path] = made.content
        return fixed, contents

    def fixed(self) -> dict[str, Any]:
        """Every parameter of the touched stages as the files and `--set` have it, by name."""
        return {
            f"{file}.{key}": value
            for name in self.touched
            for file, values in loading.as_plain(self.base[name]).items()
            for key, value in values.items()
        }

    def usual(self) -> dict[str, Any]:
        """Of a list the varied parameters as the files and `--set` have them, which a point need not give."""
        fixed = self.fixed() if self.spec.points else {}
        return {name: fixed[name] for name in self.spec.names if fixed.get(name) is not None}

    def unit(self, name: str) -> str:
        """Unit of a varied parameter; empty for a word and for an entry of a table."""
        override = self._overrides[name]
        fields = {key: field for section in self._sections(override.file)
                  for key, (field, _) in declared(section.__class__).items()}  # fmt: skip
        unit = "-" if override.inner else str(fields[override.key].metadata["unit"])
        return "" if unit == "-" else unit

    def _parsed(self, name: str, keys: Mapping[str, list[str]]) -> Override:
        try:
            return parsed(f"{name}=0", keys)
        except StudyError as error:
            said = f"--set {name}=0"
            raise StudyError(f"{self.spec.file}: {text.replace(said, name)}" for text in error.sentences) from None

    def _sections(self, file: str) -> list[Any]:
        return [section for name in self.names for section in vars(self.base[name]).values() if file == section.FILE]

    def _touched(self) -> tuple[str, ...]:
        idle, touched = set(self.spec.names), set[str]()
        for name in self.names:
            reads = {(section.FILE, key) for section in vars(self.base[name]).values() for key in vars(section)}
            varied = {each for each, override in self._overrides.items() if (override.file, override.key) in reads}
            idle -= varied
            if varied or touched.intersection(self.study.graph.upstream(name)):
                touched.add(name)
        if idle:
            raise StudyError(f"{self.spec.file}: {name}: stage {self.spec.stage} does not depend on this parameter"
                             for name in self.spec.names if name in idle)  # fmt: skip
        return tuple(name for name in self.names if name in touched)

    def _check(self) -> None:
        """Every limit and option of each axis must be legal by itself; rules between values are each point's matter."""
        limits = [(name, value) for name, axis in self.spec.axes.items()
                  for value in ([axis.low, axis.high] if isinstance(axis, Range) else axis.values())]  # fmt: skip
        problems = []
        for name, value in [*limits, *(pair for point in self.spec.points for pair in point.items())]:
            for section in self._sections(self._overrides[name].file):
                try:
                    self._with(section, name, value)
                except StudyError as error:
                    problems += [f"{self.spec.file}: {sentence}" for sentence in error.sentences]
        if problems:
            raise StudyError(dict.fromkeys(problems))

    def _varied(self, values: Any, point: Mapping[str, Any]) -> Any:
        changed = {}
        for field, section in vars(values).items():
            own = {name: value for name, value in point.items() if self._overrides[name].file == section.FILE}
            new = without(section, {self._overrides[name].key for name in own})
            for name, value in own.items():
                new = self._with(new, name, value)
            if new != section:
                changed[field] = new
                _keep_rules(new)
        whole = dataclasses.replace(values, **changed) if changed else values
        _keep_rules(whole)
        return whole

    def _with(self, section: Any, name: str, value: Any) -> Any:
        """A section with this value of a parameter, which may reach into a table; as it is, if it has no such one."""
        override = dataclasses.replace(self._overrides[name], value=Node.of(value))
        if override.key not in declared(section.__class__):
            return section
        field, kind = declared(section.__class__)[override.key]
        entry = Node.of(plain_value(getattr(section, override.key)))
        try:
            return dataclasses.replace(section, **{override.key: checked(applied(override, entry), field, kind)})
        except Refused as refused:
            raise StudyError(refused.of(name)) from None


def _keep_rules(instance: Any) -> None:
    for _, sentence in broken_rules(instance):
        raise StudyError(sentence)
