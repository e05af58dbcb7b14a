# Two commands: `make study` builds the study, `make test` tests it. Either may come first, on a machine with
# nothing but make and Python 3.10 or later. `make install` does the environment alone.

PYTHON ?= python3
BIN := .venv/bin
STUDY := .venv/installed-study
TEST := .venv/installed-test
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
PYTEST := $(BIN)/python -m pytest -n 2

.PHONY: install readme study test test-slow check lock clean

install: $(STUDY)

study: $(STUDY)
	$(BIN)/bipedstudy run-all

test: $(TEST)
	$(PYTEST)

test-slow: $(TEST)
	$(PYTEST) -m slow

# The README's verdict table and picture, from the results.
readme: study
	$(BIN)/bipedstudy claims --into README.md
	cp results/figures/figure_08_hip_motion.png docs/hip_motion.png

check: $(TEST)
	$(BIN)/ruff check .
	$(BIN)/mypy

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' \
	  || { echo 'bipedstudy needs Python 3.10 or later; name one with: make PYTHON=python3.12' >&2; exit 1; }
	$(PYTHON) -m venv .venv

$(STUDY): requirements/study.txt pyproject.toml | $(BIN)/python
	$(PIP) install --require-hashes -r requirements/study.txt
	$(PIP) install --no-deps --no-build-isolation --editable .
	@touch $@

$(TEST): requirements/test.txt $(STUDY)
	$(PIP) install --require-hashes -r requirements/test.txt
	@touch $@

# Pin again the newest versions that pyproject.toml allows: versions and hashes, no addresses. Needs uv.
LOCK := uv pip compile --universal --python-version 3.10 --generate-hashes --no-header --no-annotate --quiet --upgrade

lock:
	echo 'setuptools>=77' | $(LOCK) --extra test pyproject.toml - --output-file requirements/test.txt
	echo 'setuptools>=77' | $(LOCK) --constraint requirements/test.txt pyproject.toml - --output-file requirements/study.txt

clean:
	rm -rf .venv build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
