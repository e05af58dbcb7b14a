"""The whole study of similar robots: the same choices and verdicts, numbers that differ by their units."""

import h5py
import numpy as np
import pytest
import yaml

from tests.commands import run
from tests.similar import factor

#: Exponent of the ground's law in the parameter files.
EXPONENT = 2.2
#: Largest relative difference: what rounding moves; what the one tolerance for metres and radians of Exudyn moves.
EXACT, EXUDYN = 1e-9, 2e-3
#: Whose numbers are compared, the largest difference of each.
COMPARED = {
    "analytic": {"": EXACT}, "stability": {"": EXACT},
    "contact_study": {"limit/chosen/law": EXACT, "limit/chosen/period": 1e-3, "limit/chosen/hip_position": 1e-3},
    "multibody": {"cycle/period_s": 1e-6, "cycle/step_length_m": 1e-6, "cycle/peak_normal_force": EXUDYN},
    "twin": {"settling/period_s": 1e-5, "settling/step_length_m": 1e-5},
}  # fmt: skip


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


@pytest.mark.slow
@pytest.mark.parametrize("scale", [(8.0, 4.0, 2.0), (0.125, 0.25, 0.5), (1.0, 1.0, 2.0)], ids=["large", "small", "g/4"])
def test_a_similar_robots_study_is_the_same(tmp_path_factory, tmp_path, repository, scale):
    base = tmp_path_factory.getbasetemp() / "similar-base"
    if not base.exists():
        run("init", base, cwd=tmp_path)
        assert run("run-all", "--accuracy", "draft", cwd=base).returncode == 0
    run("init", tmp_path / "other", cwd=tmp_path)
    similar_files(repository / "params", tmp_path / "other" / "params", scale)
    run("run-all", "--accuracy", "draft", cwd=tmp_path / "other")
    for stage, wanted in COMPARED.items():
        one, other = (numbers(where / "results" / f"{stage}.h5") for where in (base, tmp_path / "other"))
        for name, (value, unit) in one.items():
            allowed = next((most for start, most in wanted.items() if name.startswith(start)), None)
            if allowed is None or unit in ("-", "1/inch", "m, rad, m/s, rad/s"):
                continue
            expected = value * factor(unit, scale, EXPONENT)
            most = allowed * np.nanmax(np.abs(expected), initial=1e-300)
            assert other[name][0] == pytest.approx(expected, rel=0, abs=most, nan_ok=True), f"{stage}: {name}"
    both = base / "results", tmp_path / "other" / "results"
    assert [bool(h5py.File(where / "contact_study.h5")["ground_is_choice"][()]) for where in both] == [True, True]
    claims = [yaml.safe_load((where / "claims.yaml").read_text(encoding="utf-8"))["claims"] for where in both]
    verdicts = [{claim["id"]: claim["verdict"] for claim in each} for each in claims]
    judged = {name: verdict for name, verdict in verdicts[1].items() if verdict != "does not apply"}
    assert len(judged) >= 4 and judged == {name: verdicts[0][name] for name in judged}
