"""Every command in the documents: it is one that the program knows, and it works as it stands there."""

import os
import re
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from pipeline import reference
from pipeline.cli import cli
from pipeline.parameters import yaml_text
from pipeline.study import locate
from stages.figures.drawn import NAMES, figure
from tests import commands
from tests.figures.made_up_results import given
from tests.imu.stand_in import make_database, make_run
from tests.pipeline import documented, toy

HOME = Path(__file__).resolve().parents[2]
DOCUMENTS = [HOME / "README.md", *sorted((HOME / "docs").glob("*.md")), HOME / "benchmarks/README.md"]
NOT_RUN = {
    "make study": "installs an environment; .ci/run and the workflows call make, and every stage it runs is run here",
    "make test": "is what runs this test",
    "bipedstudy sweep slopes.yaml --cluster tls://scheduler:8786 --tls-ca-file cluster.pem --tls-cert cluster.pem "
    "--tls-key cluster.key": "needs a cluster: tests/pipeline/test_sweep_cluster",
    "bipedstudy sweep slopes.yaml --cluster tcp://scheduler:8786": "needs a cluster, as the one above",
    "bipedstudy follow lab.sqlite --as robot": "needs a robot, for which what is measured here is too short: test_lab",
    "bipedstudy same lab.sqlite --as robot": "likewise: tests/calibration/test_change",
    "bipedstudy ingest env:LAB": "needs a server: tests/imu/test_source_sql",
    "bipedstudy ingest env:LAB --store measurements/lab.sqlite": "needs a server; a file is stored in docs/own_biped",
}
AT_ONCE = (
    "bipedstudy status",
    "bipedstudy sweep slopes.yaml --dry-run",
    "bipedstudy ingest recordings --map columns.yaml",
)


def understood(words: list[str]) -> None:
    """Parse the words of a command without running it. Raises `click.UsageError` or `StudyError`."""
    outer = click.Context(cli, info_name="bipedstudy")
    own = {option for parameter in cli.params for option in parameter.opts}
    name, command, rest = cli.resolve_command(outer, words[words[0] in own :])
    command.make_context(name, list(rest), parent=outer)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_every_command_is_one_that_the_program_knows(path, repository, bench, monkeypatch):
    monkeypatch.chdir(bench)
    targets = set(re.findall(r"^([a-z-]+):", (repository / "Makefile").read_text(), flags=re.M))
    for command in [*documented.commands(path), *documented.mentioned(path)]:
        program, *words = [word for word in command.words if word != ">"]
        if program == "bipedstudy" and not command.environment:
            try:
                understood(words)
            except click.MissingParameter:  # within a sentence a command may be shortened
                assert command in documented.mentioned(path), command.text
        elif program == "make":
            assert words[0] in targets, command.text
        elif program == "python":
            script = words[1].replace(".", "/") + ".py" if words[0] == "-m" else words[0]
            assert (repository / script).is_file(), command.text


def test_what_is_not_run_is_still_documented():
    written = {command.text for path in DOCUMENTS for command in documented.commands(path)}
    assert NOT_RUN.keys() | AT_ONCE <= written


@pytest.fixture(scope="session")
def bench(tmp_path_factory, repository) -> Path:
    """A new study with the files that the documents speak of: sweeps, a recording in SQLite, one in CSV, a citation."""
    root = tmp_path_factory.mktemp("documented") / "study"
    assert commands.afresh("init", "study", cwd=root.parent).returncode == 0
    text = documented.blocks(repository / "docs/sweeps.md", "yaml")[0]
    assert "count: 2000 " in text
    for name in ("slopes", "designs"):
        (root / f"{name}.yaml").write_text(text.replace("count: 2000 ", "count: 3 "))
    shutil.copy(repository / "CITATION.cff", root)
    for name in ("results/steeper", "results/better", "../theirs/results"):
        (root / name).mkdir(parents=True)
    (root / "expected").mkdir()
    box = documented.blocks(repository / "docs/sweeps.md", "yaml")[1]
    assert "count: 100000" in box
    (root / "box.yaml").write_text(box.replace("count: 100000", "count: 4"))
    (root / "lab.sqlite").write_bytes(make_database([make_run(seed, steps=9, rest_s=1.5) for seed in (1, 2)]))
    (root / "measurements").mkdir()
    shutil.copyfile(root / "lab.sqlite", root / "measurements/lab.sqlite")
    (root / "columns.yaml").write_text(documented.blocks(repository / "docs/measurements.md", "yaml")[0])
    (root / "recordings").mkdir()
    (root / "recordings/walk_1_hip.csv").write_text(as_csv(root / "lab.sqlite"))
    return root


def as_csv(database: Path) -> str:
    """The first run's hip sensor in the columns and units of docs/measurements.md: a count, g and deg/s."""
    with sqlite3.connect(database) as connection:
        rows = connection.execute(
            "SELECT packet * batch_size + position, ax, ay, az, gx, gy, gz,"
            " accelerometer_range_g, gyroscope_range_deg_s FROM sample JOIN device USING (device_id)"
            " WHERE place = 'hip' AND experiment_id = 1 ORDER BY sample_id"
        ).fetchall()
    lines = ["Counter,AccX,AccY,AccZ,GyrX,GyrY,GyrZ"]
    for count, *values, force, rate in rows:
        scales = [force / 2**15] * 3 + [rate / 2**15] * 3
        lines.append(",".join([str(count), *(f"{value * scale:.6f}" for value, scale in zip(values, scales))]))
    return "\n".join(lines)


def works(folder: Path, command: documented.Command) -> None:
    """Run a documented command; it must end well, and leave every file it names."""
    assert command.words[0] == "bipedstudy" and not command.environment, command.text
    for option, value in zip(command.words, command.words[1:]):
        if option == "--propose":  # a map that is there is not replaced
            (folder / value).rename(folder / f"corrected {value}")
    done = commands.afresh(*command.words[1:], cwd=folder, timeout=3600.0)
    # 3: something changed; two runs of few strides, as are measured here, are too short for a robot to be fitted
    ends = (0, 3) if command.words[1] == "compare" or "imu.database" in command.text else (0,)
    assert done.returncode in ends, f"{command.text}\n{done.stdout[-2000:]}{done.stderr}"
    assert "Traceback" not in done.stderr
    for option, value in zip(command.words, command.words[1:]):
        if option in ("--figure", "--store", "--into", "--out", "--page", "--propose"):
            assert (folder / value).stat().st_size > 0, command.text
        if option == "--propose":
            (folder / f"corrected {value}").replace(folder / value)


def test_commands_that_need_no_results_work(bench):
    for text in AT_ONCE:
        works(bench, documented.Command(tuple(text.split())))


@pytest.fixture(scope="module")
def study(bench, repository) -> Path:
    """The bench after `make study`: results are taken from the checkout where it has them."""
    for name in ("results/.cache", "results"):
        if (repository / name).is_dir():
            shutil.copytree(repository / name, bench / name, dirs_exist_ok=True)
    return bench


@pytest.mark.slow
@pytest.mark.parametrize("name", ["docs/commands.md", "docs/measurements.md", "docs/sweeps.md"])
def test_every_command_works_after_make_study(name, study, repository):
    (study / "map.h5").unlink(missing_ok=True)  # two documents make it, and it is never replaced
    for command in documented.commands(repository / name):
        if command.text not in NOT_RUN:
            done = commands.afresh("run-all", cwd=study, timeout=3600.0)
            assert done.returncode == 0, done.stderr
            works(study, command)
    for block in documented.blocks(repository / name, "python"):
        subprocess.run([sys.executable, "-c", block], cwd=study, check=True)


@pytest.mark.slow
def test_the_tutorial_works_as_it_is_written(repository, tmp_path):
    script = "\n".join(documented.blocks(repository / "docs/own_biped.md", "sh"))
    assert script.count("bipedstudy") >= 12
    tools = toy.put_on_path(tmp_path / "bin", str(repository)).parent
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "COLUMNS": "200"}
    done = subprocess.run(["bash", "-euxc", script], cwd=tmp_path, env=environment, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
    folder = tmp_path / "my_biped"
    assert (folder / "results/multibody.h5").exists() and (folder / "lab.sqlite").exists()
    assert "complete" in (folder / "bipedstudy-completion.sh").read_text()
    # models and (synthetic) recording agree on the heavier biped within a percent, as the tutorial says
    found = dict(re.findall(r"^(analytic|multibody|imu) .*?(\d\.\d+) (?:Hz|\+-)", done.stdout, flags=re.M))
    frequencies = [float(word) for word in found.values()]
    assert len(frequencies) == 3 and max(frequencies) / min(frequencies) < 1.01, found


# --- The reference is complete and current.


def test_the_reference_is_current(repository):
    written = (repository / "docs/reference.md").read_text()
    assert written == reference.text(locate(start=repository)), "run: python -m pipeline.reference"


def test_the_reference_names_every_parameter_of_every_file(repository):
    text = (repository / "docs/reference.md").read_text()
    for path in (repository / "params").glob("*.yaml"):
        for key, entry in yaml_text.read(path, path.name).value.items():
            assert f"- `{path.stem}.{key}` (" in text
            for row in entry.value["rows"].value if "rows" in entry.value else ():
                assert all(f"- `{column}` (" in text for column in row.value)


def test_the_reference_names_every_command_and_option(repository):
    text = (repository / "docs/reference.md").read_text()
    parts = re.split(r"^### bipedstudy ", text, flags=re.M)[1:]
    sections = {part.split()[0]: part for part in parts}
    context = click.Context(cli)
    assert set(cli.list_commands(context)) == set(sections)
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command.help, name
        for option in command.params:
            if isinstance(option, click.Option) and option.opts[0] not in ("--params", "--results", "--set", "--json"):
                assert option.help, f"{name} {option.opts[0]} has no help"
                assert all(f"`{word}`" in sections[name] for word in option.opts), f"{name} {option.opts}"


def test_the_site_has_every_page_and_the_page_of_stages_every_stage(repository):
    index = (repository / "docs/index.md").read_text().splitlines()
    assert {path.stem for path in (repository / "docs").glob("*.md")} - set(index) == {"index"}
    stages = (repository / "docs/stages.md").read_text()
    assert [name for name in locate(start=repository).graph.stages if f"| `{name}` |" not in stages] == []


def test_the_pages_name_files_that_are_there(repository):
    """A Python file in backquotes is one of the checkout, by its whole path or the end of it."""
    tops = ("pipeline", "stages", "tests", "benchmarks", "docs")
    there = [f"/{path.relative_to(repository).as_posix()}" for top in tops for path in (repository / top).rglob("*.py")]
    for page in (*(repository / "docs").glob("*.md"), repository / "README.md"):
        named = re.findall(r"`((?:\w+/)*\w+\.py)`", page.read_text(encoding="utf-8"))
        assert [name for name in named if not any(path.endswith(f"/{name}") for path in there)] == [], page.name


# --- Sentences of the pages, the help, the claims and the captions are short enough to be read once.


PAGES = [HOME / "README.md", *sorted((HOME / "docs").glob("*.md"))]
MOST = 35
PRIVATE = re.compile(
    r"\b(foret\w+|yardsticks?|unsaid|rungs?|g[ai]ves? way|by turns|once weighed|felt|feels?|leaves? open)\b"
)
_NOT_PROSE = re.compile(
    r"^```.*?^```|^\$\$.*?\$\$|<!--.*?-->|^\|.*?$|^## Parameters\n\nBy file.*|^#.*?$|^!\[.*?$"
    r"|^- \*(?:says|rests on|shown in)\*.*?$",
    re.MULTILINE | re.DOTALL,
)


def too_long(text: str) -> list[str]:
    """The sentences of a text in Markdown that have too many words or semicolons."""
    return [sentence for sentence in sentences(text) if sentence.count(";") > 1 or longest(sentence) > MOST]


def sentences(text: str) -> Iterator[str]:
    """The sentences of the paragraphs and of the items of lists."""
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.) )", _NOT_PROSE.sub("\n\n", text)):
        words = re.sub(r"`[^`]*`|\$[^$]*\$", "code", " ".join(block.split()))
        words = re.sub(r"\]\([^)]*\)", "]", words)
        yield from filter(None, re.split(r"(?<=[.!?])[\"')*_\]]*\s+", words))


def longest(sentence: str) -> int:
    """The words of a sentence's longer part, where a semicolon divides it."""
    return max(sum(any(map(str.isalnum, word)) for word in part.split()) for part in sentence.split(";"))


def test_the_count_finds_what_is_too_long():
    assert too_long("one " * 35 + "end.") and not too_long("one " * 34 + "end.")
    assert too_long("a; b; c.") and not too_long("a; " + "b " * 35)
    assert not too_long("| " + "one " * 40 + "|\n\n```\n" + "one " * 40 + "\n```\n")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_sentences_of_a_page_are_short_and_have_no_words_with_a_private_meaning(page):
    text = page.read_text(encoding="utf-8")
    assert (too_long(text), PRIVATE.findall(re.sub(r"`[^`]*`", "", _NOT_PROSE.sub("", text)))) == ([], [])


def test_sentences_of_the_help_are_short():
    context = click.Context(cli)
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        options = [item.help or "" for item in command.params if isinstance(item, click.Option)]
        assert too_long("\n\n".join([command.help or "", command.short_help or "", *options])) == [], name


def test_sentences_of_captions_are_short():
    assert [sentence for name in NAMES for sentence in too_long(figure(name).caption(given(name)))] == []


def test_the_pages_are_no_longer_than_a_newcomer_reads():
    assert sum(len(page.read_text(encoding="utf-8").split()) for page in PAGES if page.parent.name == "docs") <= 40_000
