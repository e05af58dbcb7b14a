"""The whole study of similar robots: the same choices and verdicts, numbers that differ by their units."""

import h5py
import numpy as np
import pytest
import yaml

from tests.commands import run
from tests.similar import factor

#: Exponent of the ground's law in the parameter files.
EXPONENT = 2.2
#: Largest relative difference that rounding makes.
EXACT = 1e-9
#: What solvers are asked for at draft, in SI units where it is Exudyn's: `tolerance` of multibody.yaml and twin.yaml.
PENALTY, TWIN = 1e-6, 1e-5
#: A cycle carries a step's error so many times as much, by the largest multiplier of the design.
CYCLE = PENALTY / (1.0 - 0.64)
#: What creep and impact leave of a difference D is 2 (C + I) - 3 D, with half of either: three cycles, three errors.
PARTS = CYCLE * 17.0**0.5
#: Whose numbers are compared, with the largest difference: relative; of `SMALL` in those scales. Exudyn's one tolerance
#: for metres and radians means another error for each size of robot, and a force that of a depth, times its stiffness.
COMPARED = {
    "analytic": {"": EXACT}, "stability": {"": EXACT},
    "contact_study": {"limit/chosen/law": EXACT, "limit/chosen/period_parts": PARTS, "limit/chosen/period": CYCLE,
                      "limit/chosen/hip_position": PENALTY},
    "multibody": {"cycle/period_s": PENALTY, "cycle/step_length_m": PENALTY, "cycle/peak_normal_force": 1e2 * PENALTY},
    "twin": {"settling/period_s": TWIN, "settling/step_length_m": TWIN},
}  # fmt: skip
#: Differences of two walks, whose errors are those of the walks: in Table 1's pendulum time [s] and leg length [m].
SMALL = {"contact_study/limit/chosen/period": 0.184, "contact_study/limit/chosen/period_parts": 0.184,
         "contact_study/limit/chosen/hip_position": 0.333}  # fmt: skip


def similar_files(source, target, scale):
    """Parameter files of the similar robot."""
    for path in sorted(source.glob("*.yaml")):
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        for entry in content.values():
            by = factor(str(entry.get("unit", "1")), scale, EXPONENT)
            for key in {"value", "levels", "uncertainty"} & {*entry}:
                entry[key] = grown(entry[key], by)
            if "printed" in entry and by != 1.0:
                entry["uncertainty"] = 0.5 * 10.0 ** -len(entry.pop("printed").partition(".")[2]) * by
            for part in entry.get("rows", []):
                for key, unit in (("density", "kg/m^3"), ("mass", "kg"), ("size", "m"), ("position", "m")):
                    if key in part:
                        part[key] = grown(part[key], factor(unit, scale))
        (target / path.name).write_text(yaml.safe_dump(content, allow_unicode=True, width=200), encoding="utf-8")


def grown(value, by):
    if isinstance(value, list):
        return [grown(one, by) for one in value]
    if isinstance(value, str):  # YAML 1.1 reads 1e-7 as a word
        try:
            value = float(value)
        except ValueError:
            return value
    return value if value is None or isinstance(value, bool) or by == 1.0 else value * by


def numbers(path):
    """Every number of an artefact with its unit."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, at: found.update({name: (np.asarray(at[()]), str(at.attrs.get("units", "-")))})
                        if isinstance(at, h5py.Dataset) and at.shape is not None and at.dtype.kind in "fi" else None)
    return found


def judged(folder):
    """What a study says: the chosen contact set is the ground's, claims that apply, verdicts and remarks on runs."""
    claims = yaml.safe_load((folder / "claims.yaml").read_text(encoding="utf-8"))["claims"]
    with h5py.File(folder / "contact_study.h5") as contact, h5py.File(folder / "imu.h5") as imu:
        runs = [imu[f"runs/{number}/report"] for number in range(len(imu["runs/row"]))] if (
            "report" not in imu["runs"]) else [imu["runs/report"]]  # no table where one run has more remarks
        return {
            "claims": {claim["id"]: claim["verdict"] for claim in claims},
            "ground is choice": bool(contact["ground_is_choice"][()]),
            "runs": [{name: np.asarray(run[name][()]).tolist() for name in ("verdict", "reason", "remarks")}
                     for run in runs],
            "known": [{name: np.isfinite(run["times"][name][()]).tolist() for name in run["times"]} for run in runs],
        }


@pytest.mark.slow
@pytest.mark.parametrize("scale", [(8.0, 4.0, 2.0), (0.125, 0.25, 0.5), (1.0, 1.0, 2.0)], ids=["large", "small", "g/4"])
def test_a_similar_robots_study_is_the_same(tmp_path_factory, tmp_path, repository, scale):
    base = tmp_path_factory.getbasetemp() / "similar-base"
    if not base.exists():
        run("init", base, cwd=tmp_path)
        assert run("run-all", "--accuracy", "draft", cwd=base).returncode == 0
    run("init", tmp_path / "other", cwd=tmp_path)
    similar_files(repository / "params", tmp_path / "other" / "params", scale)
    assert run("run-all", "--accuracy", "draft", cwd=tmp_path / "other").returncode == 0
    both = base / "results", tmp_path / "other" / "results"
    failed = {}
    for path in (path for where in both for path in where.glob("*.h5")):
        with h5py.File(path) as file:
            failed[str(path)] = str(file.attrs.get("without_errors", ""))
    assert {path: why for path, why in failed.items() if why.startswith("at closer settings")} == {}
    off = {}
    for stage, wanted in COMPARED.items():
        one, other = (numbers(where / f"{stage}.h5") for where in both)
        for name, (value, unit) in one.items():
            allowed = next((most for start, most in wanted.items() if name.startswith(start)), None)
            if allowed is None or unit in ("-", "1/inch", "m, rad, m/s, rad/s"):
                continue
            size = factor(unit, scale, EXPONENT)
            expected, found = value * size, other[name][0]
            assert found.shape == expected.shape and (np.isnan(found) == np.isnan(expected)).all(), f"{stage}: {name}"
            known = ~np.isnan(expected) & (found != expected)
            own = size * SMALL[f"{stage}/{name}"] if f"{stage}/{name}" in SMALL else np.abs(expected).max(
                where=known, initial=1e-300)
            apart = np.abs(found - expected).max(where=known, initial=0.0) / own
            if not apart <= allowed:
                off[f"{stage}: {name}"] = apart
    assert off == {}
    first, second = (judged(where) for where in both)
    # What solvers leave of a number that noise has made is not similar: it may leave a verdict open in one of both.
    undecided = {name for one in (first, second) for name, verdict in one["claims"].items()
                 if verdict == "not decided at this accuracy"}  # fmt: skip
    applies = {name: verdict for name, verdict in second["claims"].items() if verdict != "does not apply"}
    judged_by_both = {name: verdict for name, verdict in applies.items() if name not in undecided}
    assert len(applies) >= 4 and len(judged_by_both) >= 3
    assert judged_by_both == {name: first["claims"][name] for name in judged_by_both}
    assert first["ground is choice"] and second["ground is choice"]
    assert (first["runs"], first["known"]) == (second["runs"], second["known"])
