# Two commands do everything: `make demo` and `make test`. Both set up what they need, once.
SHELL := /bin/bash
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
DEV_STAMP := $(VENV)/.installed-dev
PYTEST := $(BIN)/python -m pytest
WORKERS ?= 2

.PHONY: demo test check bench bench-tracking bench-motion fuzz durability soak mutate messages examples screens tools clean

demo: $(STAMP)
	@$(BIN)/rehab-app demo --serve

# A test that hangs is ended with where it hung, and a worker that dies ends the run: xdist would wait for ever.
test: $(DEV_STAMP) tools check
	$(PYTEST) -n $(WORKERS) --dist loadfile --max-worker-restart 0 --timeout 600 -m "not bench and not browser" tests
	$(PYTEST) --timeout 900 -m browser tests/browser

check: $(DEV_STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/basedpyright

bench: $(DEV_STAMP)
	$(PYTEST) -m bench -s tests/bench

bench-motion: $(DEV_STAMP)
	$(PYTEST) -m bench -s -q tests/bench/motion/test_bench_motion.py

bench-tracking: $(DEV_STAMP)
	$(PYTEST) -m bench -s tests/bench/test_tracking_bench.py tests/bench/tracking

fuzz: $(DEV_STAMP)
	$(BIN)/python -m tests.bench.motion.fuzz

# A thousand recordings killed at random moments, and a hundred migrations, backups, restorings and erasures;
# then the disk is full a hundred times in each.
durability: $(DEV_STAMP)
	$(BIN)/python -m tests.bench.durability.kills --kills 1000
	$(BIN)/python -m tests.bench.durability.acts --kills 100
	$(BIN)/python -m tests.bench.durability.full_disk --times 300

# Eight hours of clinic, most of an hour on the wall.
soak: $(DEV_STAMP)
	$(BIN)/python -m tests.bench.soak.clinic_day --hours 8

# In a copy: cosmic-ray changes the sources that it tests. MUTANTS=0 tries them all, which takes hours.
MUTANTS ?= 200
mutate: $(DEV_STAMP)
	$(BIN)/python -m tests.bench.motion.fuzz_mutation $(MUTANTS)

# After new texts in pages: adds them to the catalogues, empty; a test says which are still to be translated.
messages: $(DEV_STAMP)
	$(BIN)/pybabel -q extract -F web_assets/locale/babel.cfg -k marked --no-location --sort-output -o build/messages.pot .
	$(BIN)/pybabel -q update -i build/messages.pot -o web_assets/locale/it.po -l it --no-fuzzy-matching --ignore-obsolete

examples: $(STAMP)
	$(BIN)/rehab-app demo --examples docs/examples

# Every page of an example clinic in a picture; SCREENS="patient live" draws only those.
screens: $(DEV_STAMP)
	$(BIN)/python -m tests.screens.draw $(SCREENS)

tools:
	@bash tests/install-tools.sh

$(STAMP): pyproject.toml
	@command -v $(PYTHON) >/dev/null || { echo "$(PYTHON) is missing: install Python 3.11 to 3.13 (Debian: sudo apt-get install python3 python3-venv) and run make again." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(0 if (3, 11) <= sys.version_info[:2] <= (3, 13) else "Python is %d.%d, but must be 3.11 to 3.13: run make with PYTHON=python3.12 or the like." % sys.version_info[:2])'
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv --clear $(VENV) >/dev/null 2>&1 \
	  || { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && apt-get update -qq \
	       && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq python3-venv >/dev/null && $(PYTHON) -m venv --clear $(VENV); } \
	  || { echo "$(PYTHON) cannot make a virtual environment: install python3-venv (Debian: sudo apt-get install python3-venv) and run make again." >&2; exit 1; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(DEV_STAMP): $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,dask,markerless,openni,parquet,postgres,realsense,ros2,s3]'
	@touch $@

clean:
	rm -rf $(VENV) tests/foreign/node_modules build dist
