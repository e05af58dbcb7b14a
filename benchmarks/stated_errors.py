"""Whether numbers lie within the errors that their artefacts state: bipeds drawn around Table 1, stage by stage.

    python -m benchmarks.stated_errors [--designs N] [--level LEVEL] [--stages NAME ...] [--rigid] [--seed SEED]

Every design is computed at the level, and again at a hundredth of all its tolerances, whose numbers count as true.
Masses, lengths, stiffness, damping and slope lie within 15 % of Table 1's, drawn by a seed. A design that does not walk
at one of both is counted and left out. Printed is by stage: numbers, those with an error, the share of these that is
covered, and the share of fields whose median stated error is at most `FIVE` times the root mean square of the true
ones, where these are above round-off.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from pipeline.cache.artefact import CLOSER
from pipeline.cache.differences import closer, differences, is_of_floats
from pipeline.study import Study
from stages.biped.accuracy.tolerances import LEVELS

ROOT = Path(__file__).resolve().parent.parent
SEED, WITHIN, FIVE = 35, 0.15, 5.0
DRAWN = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
         "ground.slope_deg", "biped.stiffness", "biped.damping")  # fmt: skip
OF_SPRINGS = 2
STAGES = ("analytic", "multibody", "twin")


def settings(study: Study, rng: np.random.Generator, rigid: bool = False) -> list[str]:
    """A drawn design, as texts for `--set`."""
    given = study.parameters(("analytic",))["analytic"]
    sections = {"biped": given.biped, "ground": given.slope}
    names = DRAWN[: len(DRAWN) - OF_SPRINGS * rigid]
    values = {name: getattr(sections[name.partition(".")[0]], name.partition(".")[2]) for name in names}
    legs = ["biped.legs=rigid"] * rigid
    return legs + [f"{name}={value * (1 + WITHIN * rng.uniform(-1, 1)):.6g}" for name, value in values.items()]


def tighter(study: Study, stages: tuple[str, ...]) -> list[str]:
    """The settings of the stages' solvers, closer twice over, as texts for `--set`."""
    texts = []
    for given in study.parameters(stages).values():
        near = closer(closer(given))
        texts += [f"{one.FILE}.{key}={value:g}" for name, one in vars(near).items() for key, value in vars(one).items()
                  if isinstance(value, float) and value != getattr(getattr(given, name), key)]  # fmt: skip
    return list(dict.fromkeys(texts))


def run(results: Path, level: str, stages: tuple[str, ...], texts: list[str]) -> bool:
    """Whether the stages were computed."""
    words = ["run", *stages, "--accuracy", level, "--results", str(results), *(f"--set={text}" for text in texts)]
    command = [sys.executable, "-m", "pipeline.cli", *words]
    return subprocess.run(command, cwd=ROOT, check=False, capture_output=True).returncode == 0


def judged(one: Path, other: Path) -> Iterator[tuple[str, float, float, float]]:
    """Path, stated error (NaN: none), true error and round-off of each number of an artefact."""
    with h5py.File(one) as here, h5py.File(other) as there:
        true, names = dict(differences(here, there)), list[str]()
        here.visititems(lambda name, item: names.append(name) if is_of_floats(item) else None)
        for name in names:
            if name in true and not name.startswith(f"{CLOSER}/"):
                stated = float(here[name].attrs.get("numerical_error", np.nan))
                yield name, stated, *true[name]


def main() -> None:
    """Compute and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--designs", type=int, default=20)
    parser.add_argument("--level", choices=LEVELS, default="draft")
    parser.add_argument("--stages", nargs="+", default=STAGES)
    parser.add_argument("--rigid", action="store_true", help="rigid legs")
    parser.add_argument("--seed", type=int, default=SEED)
    asked = parser.parse_args()
    study = Study(ROOT, ROOT / "params", ROOT / "results", requested=(("accuracy", asked.level),))
    rng, left_out, stages = np.random.default_rng(asked.seed), 0, tuple(asked.stages)
    rows: dict[str, list[tuple[str, float, float, float]]] = {name: [] for name in stages}
    for _ in range(asked.designs):
        texts = settings(study, rng, asked.rigid)
        with tempfile.TemporaryDirectory() as folder:
            one, other = Path(folder, "one"), Path(folder, "other")
            if run(one, asked.level, stages, texts) and run(other, asked.level, stages, texts + tighter(study, stages)):
                for name in stages:
                    rows[name] += judged(one / f"{name}.h5", other / f"{name}.h5")
            else:
                left_out += 1
    print(f"{asked.designs} designs at {asked.level}, seed {asked.seed}, {left_out} left out")
    print("| stage | numbers | with an error | covered | fields | within five times |\n|---|---|---|---|---|---|")
    for name, found in rows.items():
        known = [row for row in found if np.isfinite(row[1])]
        covered = np.mean([true <= max(stated, spacing) for _, stated, true, spacing in known]) if known else np.nan
        fields: dict[str, list[tuple[float, float]]] = {}
        for path, stated, true, spacing in known:
            if true > spacing:
                fields.setdefault(path, []).append((stated, true))
        pairs = [np.array(each).T for each in fields.values()]
        near = [np.median(stated) <= FIVE * np.sqrt(np.mean(true**2)) for stated, true in pairs]
        print(f"| {name} | {len(found)} | {len(known)} | {covered:.3f} | {len(near)} | {np.mean(near):.2f} |")
    missed: dict[str, list[float]] = {}
    for name, found in rows.items():
        for path, stated, true, spacing in found:
            if true > max(stated, spacing):
                missed.setdefault(f"{name}/{path}", []).append(true / stated)
    print(json.dumps({path: [len(by), round(max(by), 1)] for path, by in sorted(
        missed.items(), key=lambda each: -len(each[1]))[:25]}, indent=1))  # fmt: skip


if __name__ == "__main__":
    main()
