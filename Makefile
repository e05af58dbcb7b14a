# Two commands: `make study` builds the study, `make test` tests it. Either may come first, on a machine with
# nothing but make and Python 3.10 or later. `make install` does the environment alone.

PYTHON ?= python3
BIN := .venv/bin
STUDY := .venv/installed-study
TEST := .venv/installed-test
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
PYTEST := $(BIN)/python -m pytest -n 2 --dist worksteal

.PHONY: install readme site study test test-slow check lint coverage audit test-floor test-package wheel lock clean elsewhere

install: $(STUDY)

study: $(STUDY)
	$(BIN)/bipedstudy run-all

test: $(TEST)
	$(PYTEST)

test-slow: $(TEST)
	$(PYTEST) -m slow

# The claims, the README's headlines and pictures from the results, the reference from the code.
readme: study
	$(BIN)/bipedstudy claims --into docs/claims.md
	$(BIN)/bipedstudy claims --into README.md
	cp results/figures/figure_08_hip_motion.png docs/hip_motion.png
	$(BIN)/python docs/draw_walk.py
	cp results/figures/robot_symbols.html docs/robot.svg
	$(BIN)/python -m pipeline.reference

# The pages of docs/ as a site, into build/site. Needs Python 3.12 or later.
site:
	$(PYTHON) -m venv .venv-docs
	.venv-docs/bin/python -m pip --disable-pip-version-check --quiet install --require-hashes -r requirements/docs.txt
	.venv-docs/bin/python -m sphinx -W --keep-going -q -b html docs build/site

check: lint
	$(BIN)/mypy

lint: $(TEST)
	$(BIN)/ruff check .

# Which lines the quick tests reach. Compiled functions and stages in worker processes are not seen.
coverage: $(TEST)
	$(PIP) install --require-hashes -r requirements/coverage.txt
	$(BIN)/python -m coverage run --source pipeline,stages -m pytest -q
	$(BIN)/python -m coverage report --skip-covered --sort cover

# Known vulnerabilities of what is pinned: asks PyPI, and ends with an error if there are any, or if it cannot be asked.
audit: | $(BIN)/python
	$(PYTHON) -m venv .venv-audit
	.venv-audit/bin/python -m pip --disable-pip-version-check --quiet install --require-hashes -r requirements/audit.txt
	for file in requirements/*.txt; do .venv-audit/bin/pip-audit --strict --require-hashes --disable-pip -r $$file || exit; done

# The quick tests with the lowest versions that pyproject.toml allows, in an environment of their own. The one install
# without hashes: it takes what the package index has for these bounds, so run it where that may be trusted.
FLOOR := .venv-floor/bin/python
test-floor:
	$(PYTHON) -m venv .venv-floor
	sed -n 's/^    "\([a-z0-9-]*\)\(\[[a-z]*\]\)\{0,1\}>=\([0-9.]*\)",.*/\1==\3.*/p' pyproject.toml > .venv-floor/floor.txt
	$(FLOOR) -m pip --disable-pip-version-check --quiet install -c .venv-floor/floor.txt 'setuptools>=77' --editable '.[test]'
	$(FLOOR) -m pytest -n 2 --dist worksteal

# A package of results against the validator of RO-Crates, which needs other versions than the study.
test-package: $(TEST)
	$(PYTHON) -m venv .venv-package
	.venv-package/bin/python -m pip --disable-pip-version-check --quiet install --require-hashes -r requirements/package.txt
	PATH="$(CURDIR)/.venv-package/bin:$$PATH" $(PYTEST) -m slow tests/pipeline/test_package.py

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' \
	  || { echo 'bipedstudy needs Python 3.10 or later; name one with: make PYTHON=python3.12' >&2; exit 1; }
	$(PYTHON) -m venv .venv

# An environment that was copied with its folder, or restored elsewhere, runs the checkout that it was made in; one into
# which pip put a copy of the code runs that.
ELSEWHERE := $(shell [ "$$(cat $(STUDY) 2>/dev/null)" = '$(CURDIR)' ] \
  && ls .venv/lib/python*/site-packages/__editable__*bipedstudy* >/dev/null 2>&1 || echo elsewhere)
elsewhere:
$(STUDY): requirements/study.txt pyproject.toml $(ELSEWHERE) | $(BIN)/python
	@$(BIN)/python -m pipeline.wheels
	$(PIP) install --require-hashes -r requirements/study.txt
	$(PIP) install --no-deps --no-build-isolation --editable .
	$(BIN)/bipedstudy gait >/dev/null  # compiles the equations of motion, once for all commands and tests
	@echo '$(CURDIR)' > $@

$(TEST): requirements/test.txt $(STUDY)
	$(PIP) install --require-hashes -r requirements/test.txt
	@touch $@

# A wheel that brings its machine code, compiled for any processor of this platform, this Python and this numba: others
# compile on the user's machine. Into dist/.
WHEEL_TAGS = $(shell $(BIN)/python -c 'import sys, sysconfig; v = "cp%d%d" % sys.version_info[:2]; \
  print("--config-settings=--build-option=--python-tag=" + v, "--config-settings=--build-option=--plat-name=" \
  + sysconfig.get_platform().replace("-", "_").replace(".", "_"))')
SHIPPED := stages/biped/machine_code/shipped
wheel: $(STUDY)
	rm -rf build $(SHIPPED)
	NUMBA_CPU_NAME=generic NUMBA_CPU_FEATURES= NUMBA_CACHE_DIR='$(CURDIR)/build/code' \
	  $(BIN)/bipedstudy run-all --accuracy draft --results build/study
	cp -r build/code/bipedstudy $(SHIPPED)
	$(PIP) wheel --no-deps --no-build-isolation $(WHEEL_TAGS) --wheel-dir dist . ; done=$$?; rm -rf $(SHIPPED); exit $$done

# Pin again the newest versions that pyproject.toml allows: versions and hashes, no addresses. Needs uv. Extras stay, as
# pip takes no package[extra] for pinned where package alone is.
LOCK := uv pip compile --universal --python-version 3.10 --no-strip-extras --generate-hashes --no-header --no-annotate --quiet --upgrade

lock:
	echo 'setuptools>=77' | $(LOCK) --extra test pyproject.toml - --output-file requirements/test.txt
	echo 'setuptools>=77' | $(LOCK) --constraint requirements/test.txt pyproject.toml - --output-file requirements/study.txt
	echo 'coverage>=7' | $(LOCK) --constraint requirements/test.txt - --output-file requirements/coverage.txt
	printf 'furo>=2025.7\nmyst-parser>=4\nsphinx>=8\n' | $(subst 3.10,3.12,$(LOCK)) - --output-file requirements/docs.txt
	echo 'pip-audit>=2.7' | $(LOCK) - --output-file requirements/audit.txt
	echo 'roc-validator>=0.13' | $(LOCK) - --output-file requirements/package.txt

clean:
	rm -rf .venv .venv-docs .venv-floor .venv-audit .venv-package build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
