# Two commands do everything: `make demo` and `make test`. Both set up what they need, once.
SHELL := /bin/bash
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
DEV_STAMP := $(VENV)/.installed-dev
PYTEST := $(BIN)/python -m pytest

.PHONY: demo test check bench examples browser-tools clean

demo: $(STAMP)
	$(BIN)/rehab-app demo --serve

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(0 if (3,11) <= sys.version_info < (3,14) else "rehab-app needs Python 3.11 to 3.13, this is %s; set PYTHON=python3.11" % sys.version.split()[0])'
	@$(PYTHON) -m venv $(VENV) || { echo "python3 cannot make a virtual environment here: apt-get install python3-venv, then run make again" >&2; exit 1; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	@touch $@

$(DEV_STAMP): $(STAMP) tests/foreign/package.json
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	@touch $@

browser-tools:
	@bash tests/install-tools.sh

test: $(DEV_STAMP) browser-tools check
	$(PYTEST) -n 2 --dist loadgroup -m "not bench" tests

check: $(DEV_STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/basedpyright

bench: $(DEV_STAMP)
	$(PYTEST) -m bench -s tests/bench

examples: $(STAMP)
	$(BIN)/rehab-app demo --examples docs/examples

clean:
	rm -rf $(VENV) node_modules build dist
