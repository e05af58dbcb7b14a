"""A flipped bit in any file of results and cache is never believed, costs no dead end, and is never unexplained."""

import contextlib
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pipeline.cache import disk
from pipeline.errors import StudyError
from pipeline.execution.executor import CURRENT
from pipeline.graph import REPORT
from pipeline.questions.asking import Asked
from pipeline.report import page
from pipeline.report.page import entries
from pipeline.sweep.pool import Journal
from tests.pipeline.counts import Count
from tests.pipeline.toy import Toy


def flipped(toy, flips, seed):
    study, chance, count = Flipped(toy), random.Random(seed), Count()
    for _ in range(flips):
        study.flip(chance, count)
    print(f"{count.tried} flips, survived {count.survived}, problems {count.problems}, {dict(count.hit.most_common())}")
    assert count.problems == [] and count.survived == flips and {*count.hit} == {*study.files(), "computed again"}


@pytest.mark.parametrize(("flips", "seed"), [(18, 1), pytest.param(1000, 2, marks=pytest.mark.slow)])
def test_flips(done, flips, seed):
    flipped(done, flips, seed)


def test_every_flip_of_the_kept_syntax_is_seen(done):
    path = done.kept_syntax()
    content, chance = path.read_bytes(), random.Random(3)
    whole = disk.read_sealed(path)
    assert whole
    for _ in range(200):
        at = chance.randrange(8 * len(content))
        damaged = bytearray(content)
        damaged[at // 8] ^= 1 << at % 8
        path.write_bytes(damaged)
        assert disk.read_sealed(path) in (None, whole)


# --- Bits flipped in the files of a study's results and cache, and what the study makes of them.


VARIANTS = (("ground.gravity=5",), ("picture.extra=true",), ())
_GRID = "stage: bounce\nkind: grid\nvary: {fall.steps: [2, 5, 9]}\n"


class Flipped:
    """A toy study with results of several designs, a kept question, a sweep and a report, all known to be right."""

    def __init__(self, toy: Toy) -> None:
        self.toy, self.results = toy, toy.root / "results"
        self.right: dict[tuple[str, ...], dict[str, bytes]] = {}
        for variant in VARIANTS:
            toy.run(*variant)
            self.right[variant] = toy.results()
        toy.sweep(_GRID).run(toy.root / "table.h5", 1)
        study = toy.study()
        parameters = study.parameters(("side",))["side"]
        tally = study.module("side", "questions.tally")
        with Asked(study, "side", tally.QUESTION, parameters, 1) as asked:
            assert len(list(asked.each(tally.number_of, [1, 2, 3], 0, ""))) == 3
        page.refresh(study)
        self.believed = dict(self.beliefs())
        assert {kind for kind, *_ in self.believed} == {"entry", "row", "syntax"}

    def beliefs(self) -> Iterator[tuple[tuple[str, ...], Any]]:
        """All that is believed of what the cache holds; a belief that is gone is no harm, another one is wrong."""
        study = self.toy.study()
        for path in study.store.folder.iterdir():
            entry = study.store.entry(path.name) if path.is_dir() else None
            if entry:
                yield ("entry", path.name), (entry.outs, entry.summary)
        for path in [*self.results.glob(".cache/questions/*.jsonl"), *self.results.glob("sweeps/.cache/*.jsonl")]:
            with contextlib.closing(Journal(path)) as journal:
                yield from ((("row", path.stem, key), journal.row(key)) for key in list(journal._places))
        for name in study.graph.stages:
            yield ("syntax", name), study.sources.closure([f"{self.toy.package}.{name}.run"])

    def files(self) -> dict[str, list[Path]]:
        """Every file that can be hit, by its kind."""
        found: dict[str, list[Path]] = {}
        for path in sorted(self.results.rglob("*")):
            if path.is_file() and path.stat().st_size:
                found.setdefault(_kind(path.relative_to(self.results).as_posix()), []).append(path)
        return dict(sorted(found.items()))

    def flip(self, chance: random.Random, count: Count) -> None:
        """Flip a bit of a file of each kind in turn, ask the study what it believes, and bring a variant up to date."""
        files = self.files()
        kind = [*files][count.tried % len(files)]
        path, variant = chance.choice(files[kind]), chance.choice(VARIANTS)
        content = bytearray(path.read_bytes())
        at = chance.randrange(8 * len(content))
        content[at // 8] ^= 1 << at % 8
        path.write_bytes(content)
        name = path.relative_to(self.results).as_posix()
        told = f"flip {count.tried}: bit {at} of {name}"
        count.tried += 1
        count.hit[kind] += 1
        try:
            count.wrong += [f"{told}: {belief}" for belief, said in self.beliefs()
                            if self.believed.get(belief, said) != said]  # fmt: skip
            count.wrong += [f"{told}: {file} is called current" for file in self.current_and_wrong(variant)]
            hows = self.toy.run(*variant)
            count.hit["computed again"] += "computed" in hows.values()
            made = {name: found for name, found in self.toy.results().items() if not name.startswith("sweeps/")}
            if made != self.right[variant]:
                count.wrong.append(f"{told}: a run that ended well left something else than the right results")
            study = self.toy.study(*variant)
            page.refresh(study)
            if (self.results / REPORT).read_bytes() != page.render(study, entries(study), True, {}):
                count.wrong.append(f"{told}: the report is not what the results make")
        except StudyError as error:
            count.lost.append(f"{told}: {error}")
        except Exception as error:
            count.told.append(f"{told}: {type(error).__name__}: {error}")
        else:
            count.survived += 1

    def current_and_wrong(self, variant: tuple[str, ...]) -> list[str]:
        """Files of stages that are called current, and are not what an undisturbed run makes."""
        current = [item.entry for item in self.toy.survey(*variant).values() if item.state == CURRENT]
        names = [path.removeprefix("results/") for entry in current if entry for path in entry.outs]
        return [name for name in names if disk.read(self.results / name) != self.right[variant].get(name)]


def _kind(name: str) -> str:
    """Files of one kind under one name."""
    first, _, rest = name.partition("/")
    if first != ".cache":
        return "sweeps" if first == "sweeps" else "log.jsonl" if first == "log.jsonl" else "results"
    inner, _, last = rest.partition("/")
    return inner if not last or inner in ("current", "questions") else "manifest" if "manifest" in last else "stored"
