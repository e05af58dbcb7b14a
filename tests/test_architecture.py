"""The house's rules: who may import whom, and that dvc.yaml declares what the code really uses."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline import graph
from pipeline.cache import fingerprint
from pipeline.cache.closure import Sources
from pipeline.cache.syntax import SyntaxMemo
from pipeline.execution.inputs import disagreements
from pipeline.parameters import yaml_text
from pipeline.stage_modules import stage_module
from pipeline.study import Study

ROOT = Path(__file__).resolve().parent.parent
STAGES = graph.read(ROOT).stages


def test_imports_keep_to_the_contracts():
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"]
    done = subprocess.run([*command, "--no-cache"], cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("name", STAGES)
def test_declared_code_is_the_code_that_is_imported(name):
    """dvc.yaml's deps cover every file of the stage's import closure, and none of them is idle."""
    stage = STAGES[name]
    sources = Sources(ROOT, "stages", SyntaxMemo(None))
    files = sources.closure(fingerprint.entry_modules(stage, "stages")).files
    reached = [file for file in files if not file.endswith("__init__.py")]
    idle = [dep for dep in stage.code if not any(_covers(dep, file) for file in reached)]
    missing = sorted({str(Path(file).parent) for file in reached if not any(_covers(dep, file) for dep in stage.code)})
    assert (idle, missing) == ([], [])


def _covers(dep, file):
    return file == dep or file.startswith(dep + "/")


@pytest.mark.parametrize("name", STAGES)
def test_declared_inputs_are_those_that_the_stage_names(name):
    wanted = getattr(stage_module("stages", name, "run"), "Inputs", None)
    parameters = stage_module("stages", name, "parameters").Parameters
    assert list(disagreements("stages", STAGES[name], wanted, parameters)) == []


def test_declared_parameters_are_those_the_stages_read():
    study = Study(ROOT, ROOT / "params", ROOT / "results")
    values = study.parameters(tuple(STAGES))  # raises if dvc.yaml and the classes disagree
    assert set(values) == set(STAGES)


@pytest.mark.parametrize("path", sorted((ROOT / "params").glob("*.yaml")), ids=lambda path: path.name)
def test_every_value_has_a_unit_and_a_source(path):
    for key, entry in yaml_text.read(path, path.name).value.items():
        assert isinstance(entry.value, dict), f"{path.name}:{entry.line}: {key} has neither unit nor source"
        assert str(entry.value["source"].value).strip(), f"{path.name}:{entry.line}: {key} has an empty source"
        assert "rows" in entry.value or "unit" in entry.value, f"{path.name}:{entry.line}: {key} has no unit"


@pytest.mark.parametrize("lock", ["study.txt", "test.txt"])
def test_the_lock_pins_versions_and_hashes_and_holds_no_address(lock):
    text = (ROOT / "requirements" / lock).read_text()
    assert "://" not in text and "file:" not in text
    blocks = [block for block in re.split(r"\n(?=\S)", text.strip()) if block]
    assert len(blocks) > 20
    for block in blocks:
        assert re.match(r"[A-Za-z0-9._-]+(\[[a-z,]+\])?==[^ ]+", block), block.splitlines()[0]
        assert "--hash=sha256:" in block


def test_the_locks_agree():
    pins = [set(re.findall(r"^\S+==[^\\\n]+", (ROOT / "requirements" / lock).read_text(), re.M)) for lock in
            ("study.txt", "test.txt")]  # fmt: skip
    assert pins[0] <= pins[1]
