"""The wheel works in any folder, whatever lies beside it."""

import os
import re
import shutil
import subprocess
import sys
import zipfile

import pytest

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def installed(repository, tmp_path_factory):
    """A folder to which a wheel of this checkout was installed; its dependencies are those of this environment."""
    folder = tmp_path_factory.mktemp("wheel")
    ignored = shutil.ignore_patterns(".*", "results", "build", "*.egg-info", "__pycache__", "tests")
    shutil.copytree(repository, folder / "source", ignore=ignored)
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    subprocess.run([*pip, "wheel", "--no-deps", "--no-build-isolation", "-w", folder, folder / "source"], check=True)
    (wheel,) = folder.glob("*.whl")
    packages = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist() if "dist-info" not in name}
    assert packages == {"bipedstudy", "pipeline", "stages", f"{wheel.name.rsplit('-', 3)[0]}.data"}
    subprocess.run([*pip, "install", "--no-deps", "--target", folder / "site", wheel], check=True)
    shutil.rmtree(folder / "source")
    return folder / "site"


def python(installed, folder, *arguments, **environment):
    environment = {**os.environ, "PYTHONPATH": str(installed), **environment}
    done = subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, text=True, capture_output=True)
    return done.returncode, done.stdout, done.stderr


def test_a_study_beside_modules_of_the_same_names(installed, tmp_path):
    for name in ("pipeline.py", "stages/__init__.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("raise SystemExit('not this one')")
    code, out, errors = python(installed, tmp_path, "-m", "bipedstudy", "gait", "--json")
    assert code == 0, errors
    assert '"period_s": 0.48268202' in out and "comes with" in errors
    code, _, errors = python(installed, tmp_path, "-m", "bipedstudy", "run-all")
    assert code == 2 and "there is no dvc.yaml" in errors
    assert python(installed, tmp_path, "-m", "bipedstudy", "doctor")[0] == 0
    assert python(installed, tmp_path, "-m", "bipedstudy", "init", "mine")[0] == 0
    for name in ("pipeline.py", "stages/__init__.py"):
        (tmp_path / "mine" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "mine" / name).write_text("raise SystemExit('not this one')")
    code, out, errors = python(installed, tmp_path / "mine", "-m", "bipedstudy", "run", "multibody")
    assert code == 0, errors
    assert re.search("analytic +computed", out) and re.search("multibody +computed", out)
    told = "import bipedstudy as bs; print(bs.load('analytic').summary())"
    code, out, errors = python(installed, tmp_path / "mine", "-c", told)
    assert code == 0 and "stable gait" in out, errors


def test_nothing_is_left_behind_and_another_packages_files_are_said(installed, tmp_path):
    """What a command keeps is no part of site-packages; where another package lies, each command is one sentence."""
    record, = installed.glob("bipedstudy-*.dist-info/RECORD")
    recorded = {line.rsplit(",", 2)[0] for line in record.read_text().splitlines()}
    environment = {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    code, out, errors = python(installed, tmp_path, "-m", "bipedstudy", "init", "mine", **environment)
    assert code == 0, errors
    assert python(installed, tmp_path / "mine", "-m", "bipedstudy", "status", **environment)[0] in (0, 3)
    assert [path.name for path in (tmp_path / "cache/bipedstudy").glob("*.syntax.json")]
    here = {path.relative_to(installed).as_posix() for path in installed.rglob("*") if path.is_file()}
    own = {name for name in here - recorded if name.split("/")[0] in ("bipedstudy", "pipeline", "stages")}
    assert not [name for name in own if not name.endswith(".pyc")]
    code, out, _ = python(installed, tmp_path, "-m", "bipedstudy", "--version")
    assert code == 0 and re.fullmatch(r"bipedstudy, version \S+, code [0-9a-f]{16}\n", out), "a wheel has no commit"
    for package in ("pipeline", "stages"):
        place = installed / package / "__init__.py"
        before = place.read_bytes()
        for content in (b"'Of another study.'\n", None):
            place.unlink() if content is None else place.write_bytes(content)
            for command in (("--version",), ("gait",), ("run-all",)):
                code, out, errors = python(installed, tmp_path, "-m", "bipedstudy", *command)
                assert (code, out, len(errors.splitlines())) == (2, "", 1)
                assert str(place) in errors and "another distribution" in errors
            place.write_bytes(before)
    assert python(installed, tmp_path, "-m", "bipedstudy", "--version")[0] == 0
