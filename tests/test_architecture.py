"""The house's rules: who may import whom, and that dvc.yaml declares what the code really uses."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline import graph
from pipeline.cache import fingerprint
from pipeline.cache.sources import Sources, beside
from pipeline.execution.fork_server import foreign
from pipeline.execution.inputs import disagreements
from pipeline.home import stage_module
from pipeline.parameters import loading, yaml_text
from pipeline.parameters.value import declared
from pipeline.study import Study
from stages.figures.drawn import NAMES
from tests.pipeline.toy import written

ROOT = Path(__file__).resolve().parent.parent
STAGES = graph.read(ROOT).stages
SOURCES = Sources(ROOT, "stages", beside(ROOT / "stages"))


def test_imports_keep_to_the_contracts():
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"]
    done = subprocess.run([*command, "--no-cache"], cwd=ROOT, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("name", STAGES)
def test_declared_code_is_the_code_that_is_imported(name):
    """dvc.yaml's deps cover every file of the stage's import closure, and none of them is idle."""
    stage = STAGES[name]
    files = SOURCES.closure(fingerprint.entry_modules(stage, "stages")).files
    reached = [file for file in files if not file.endswith("__init__.py")]
    idle = [dep for dep in stage.code if not any(_covers(dep, file) for file in reached)]
    missing = sorted({str(Path(file).parent) for file in reached if not any(_covers(dep, file) for dep in stage.code)})
    assert (idle, missing) == ([], [])


def _covers(dep, file):
    return file == dep or file.startswith(dep + "/")


@pytest.mark.parametrize("name", STAGES)
def test_who_reads_a_result_loads_nothing_that_computes(name):
    files = SOURCES.closure([f"stages.{name}.result"]).files
    heads = {file: SOURCES.memo.meaning((ROOT / file).read_bytes()).heads for file in files if file.endswith(".py")}
    loaded = {module.partition(".")[0] for module, _ in foreign("stages", [f"stages.{name}.result"], heads)}
    assert "dataclasses" in loaded
    assert not loaded & {"exudyn", "matplotlib", "numba", "scipy", "sympy"}


@pytest.mark.parametrize("name", STAGES)
def test_declared_inputs_are_those_that_the_stage_names(name):
    wanted = getattr(stage_module("stages", name, "run"), "Inputs", None)
    parameters = stage_module("stages", name, "parameters").Parameters
    assert list(disagreements("stages", STAGES[name], wanted, parameters)) == []


def test_declared_parameters_are_those_the_stages_read():
    study = Study(ROOT, ROOT / "params", ROOT / "results")
    values = study.parameters(tuple(STAGES))  # raises if dvc.yaml and the classes disagree
    assert set(values) == set(STAGES)


def test_every_parameter_is_read_by_some_code():
    """As an attribute, or by its name as a string, in its own room or beside an import of its class; the other leg's
    `other_mass` as `mass`. A rule between settings reads none: an idle setting is a broken promise."""
    read = {path.relative_to(ROOT).with_suffix("").as_posix().replace("/", "."): names_read(path)
            for path in (ROOT / "stages").rglob("*.py")}
    sections = loading.sections([stage_module("stages", name, "parameters").Parameters for name in STAGES])
    declares = [(cls, key) for classes in sections.values() for cls in classes for key in declared(cls)]
    idle = [f"{cls.__module__}.{cls.__qualname__}.{key}" for cls, key in declares if not any(
        key.removeprefix("other_") in names for module, (names, imported) in read.items()
        if module.split(".")[:2] == cls.__module__.split(".")[:2] or cls.__module__ in imported
        or module in read[cls.__module__][1])]  # fmt: skip
    assert len(declares) > 300 and idle == []


def names_read(path):
    """Attributes and names in strings that a file uses outside of rules, and the modules from which it imports."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    rules = {part for node in ast.walk(tree) if getattr(node, "name", "") == "broken_rules" for part in ast.walk(node)}
    nodes = [node for node in ast.walk(tree) if node not in rules]
    names = {node.attr for node in nodes if isinstance(node, ast.Attribute)}
    names |= {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    return names, {node.module for node in nodes if isinstance(node, ast.ImportFrom)}


@pytest.mark.parametrize("path", sorted((ROOT / "params").glob("*.yaml")), ids=lambda path: path.name)
def test_every_value_has_a_unit_and_a_source(path):
    for key, entry in yaml_text.read(path, path.name).value.items():
        assert isinstance(entry.value, dict), f"{path.name}:{entry.line}: {key} has neither unit nor source"
        assert str(entry.value["source"].value).strip(), f"{path.name}:{entry.line}: {key} has an empty source"
        assert "rows" in entry.value or "unit" in entry.value, f"{path.name}:{entry.line}: {key} has no unit"


@pytest.mark.parametrize("path", sorted((ROOT / "requirements").glob("*.txt")), ids=lambda path: path.name)
def test_a_lock_pins_versions_and_hashes_and_holds_no_address(path):
    text = path.read_text()
    assert "://" not in text and "file:" not in text
    blocks = [block for block in re.split(r"\n(?=\S)", text.strip()) if block]
    assert blocks
    for block in blocks:
        assert re.match(r"[A-Za-z0-9._-]+(\[[a-z,]+\])?==[^ ]+", block), block.splitlines()[0]
        assert "--hash=sha256:" in block


def test_the_locks_agree():
    pins = [set(re.findall(r"^\S+==[^\\\n]+", (ROOT / "requirements" / lock).read_text(), re.M)) for lock in
            ("study.txt", "test.txt")]  # fmt: skip
    assert pins[0] <= pins[1]


#: Words of walking in the engine that mean something else there, or name this program.
EXCUSED = re.compile(r"isinstance|\binstances?\b|\bdistance|(ast|os)\.walk\b|\bwheels?\b|WHEELS|bipedstudy|BIPEDSTUDY")
OF_WALKING = re.compile(r"gait|hips?\b|heel|stance|foot|penalty|twin|walk|biped", re.IGNORECASE)


def test_the_engine_knows_nothing_of_walking():
    listed = subprocess.run(["git", "ls-files", "pipeline"], cwd=ROOT, text=True, capture_output=True).stdout.split()
    files = [ROOT / name for name in listed] or [*(ROOT / "pipeline").rglob("*.py")]  # a release has no git
    files = [path for path in files if path.is_file() and ROOT / "pipeline/face" not in path.parents]
    assert len(files) > 50
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in files
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if OF_WALKING.search(EXCUSED.sub("", line))
    ]
    assert found == []


def test_no_folder_holds_more_files_than_one_takes_in_at_a_glance():
    """About a dozen of one rank. A register, to which a figure is added as a file, may hold as many as there are."""
    crowded = {}
    for folder in [path for top in ("pipeline", "stages") for path in (ROOT / top).rglob("*") if path.is_dir()]:
        count = sum(path.suffix == ".py" and path.name != "__init__.py" for path in folder.iterdir())
        if count > 14 and folder.name != "drawn":
            crowded[folder.relative_to(ROOT).as_posix()] = count
    assert crowded == {}


def test_the_toy_study_runs_where_stages_cannot_be_imported(tmp_path):
    """The engine's second user: every process of it, workers too, meets a package `stages` that cannot be imported."""
    guard = "import sys\n\nclass No:\n    def find_spec(self, name, path=None, target=None):\n" \
            "        if name.split('.')[0] == 'stages':\n            raise ImportError('stages was imported')\n\n" \
            "sys.meta_path.insert(0, No())\n"  # fmt: skip
    (tmp_path / "guard").mkdir()
    (tmp_path / "guard/sitecustomize.py").write_text(guard)
    toy = written(tmp_path / "study", "toyalone")
    code = (
        "from pathlib import Path; from pipeline.study import Study; from pipeline.execution.display import Display; "
        "from pipeline.execution.executor import bring_up_to_date; "
        f"root = Path({str(toy.root)!r}); study = Study(root, root / 'params', root / 'results', (), 'toyalone'); "
        "done = bring_up_to_date(study, study.parameters(tuple(study.graph.stages)), Display()); "
        "print([outcome.how for outcome in done])"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path / "guard"), str(ROOT)])}
    done = subprocess.run([sys.executable, "-c", code], env=environment, text=True, capture_output=True)
    assert done.stdout.strip() == str(["computed"] * 4), done.stderr
    blocked = subprocess.run([sys.executable, "-c", "import stages"], env=environment, text=True, capture_output=True)
    assert "stages was imported" in blocked.stderr


def test_the_page_on_results_names_every_artefact_and_figure():
    page = (ROOT / "results/README.md").read_text(encoding="utf-8")
    outs = [out.removeprefix("results/") for stage in STAGES.values() for out in stage.outs]
    assert [name for name in [*outs, *NAMES] if f"`{name}" not in page] == []
    named = re.findall(r"^\| `([a-z_0-9.]+)`", page, re.M)
    assert [name for name in named if name not in {*outs, *NAMES, "proof.json", "report.html"}] == []


#: The one file that may use what numba does not promise: what its caches are made of.
OF_CACHES = "stages/biped/machine_code/numba_cache.py"
#: Parts of numba that its next release may change.
PRIVATE = re.compile(r"\b(numba\.(core|np|cpython|misc|_(?!_)\w*)|llvmlite)\b")


def private_parts(path):
    """What a file imports, or reaches for by a name or in `sys.modules`, of numba's private parts and llvmlite."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{each.name}" for each in node.names]
        elif isinstance(node, (ast.Attribute, ast.Subscript, ast.Call)):
            names = [text for text in [ast.unparse(node)] if text.startswith(("numba.", "sys.modules"))]
        yield from filter(PRIVATE.search, names)


@pytest.mark.slow
def test_numba_is_used_by_its_public_parts():
    """And nothing takes the place of its compiler or its dispatchers, which would be of private parts."""
    files = [path for top in ("pipeline", "stages", "tests", "benchmarks") for path in (ROOT / top).rglob("*.py")]
    found = {path.relative_to(ROOT).as_posix(): names for path in files if (names := [*private_parts(path)])}
    assert found == {OF_CACHES: ["numba.core.caching"]}
