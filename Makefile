# make validate   Mitsuba 3 and the reference tracer against exact answers; says where the report is
# make test       the tests, in under ten minutes on two cores
# make test-all   the tests, then the reference tracer on every case at ±0.2 %: about two hours
# make check      formatting, lint, types, import rules
# make bench      how fast, beside Mitsuba 3, in four minutes on an idle machine; ARGS=--json for programs
# make calibrate  how often verdicts are wrong, and what they resolve: an hour; ARGS="--part mitsuba" for a part
# make truth     the committed data of the cases anew, in about twenty minutes
# make verdicts  docs/verdicts.md: every form of every renderer on every case; some hours
# make schema     results.schema.json and scene.schema.json from the code
# make pins       constraints.txt from what is installed

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
INSTALLED_DEV := $(VENV)/.installed-dev

.PHONY: validate test test-all check bench calibrate truth verdicts schema pins clean

validate: $(INSTALLED)
	@$(BIN)/lightproof validate $(ARGS)

test: $(INSTALLED_DEV)
	$(BIN)/python -m pytest $(ARGS)

test-all: test
	@# ends with 4, inconclusive, where a case says why ±0.2 % takes longer; a fail is 1
	$(BIN)/lightproof validate --all --renderer reference:mis:sobol --tolerance 0.2% --budget 120 --no-total

check: $(INSTALLED_DEV)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(INSTALLED)
	@$(BIN)/python -m benchmarks $(ARGS)

calibrate: $(INSTALLED)
	@$(BIN)/python -m benchmarks.calibration $(ARGS)

truth: $(INSTALLED)
	$(BIN)/python -m comparisons.truth cornell-box --spp 131072
	for name in cornell-box-empty facing-squares around-the-corner cornell-box-spectral; do \
		$(BIN)/python -m comparisons.truth $$name || exit 1; done
	for name in cornell-box cornell-box-empty facing-squares around-the-corner cornell-box-spectral; do \
		$(BIN)/python -m comparisons.truth $$name --later || exit 1; done

# those that are listed by themselves; BUDGET="--budget 2" for a look
BUDGET ?= --budget 10
verdicts: $(INSTALLED_DEV)
	for name in $$($(BIN)/python docs/verdicts.py --names); do \
		$(BIN)/lightproof validate --all --renderer $$name $(BUDGET) --out build/verdicts/$$name; done; true
	$(BIN)/python docs/verdicts.py build/verdicts/*

schema: $(INSTALLED_DEV)
	$(BIN)/python -m comparisons.results
	$(BIN)/python -m scenes.schema

pins: $(INSTALLED_DEV)
	{ echo "# What CI has tested; written by make pins."; \
		$(BIN)/python -m pip freeze --exclude-editable --exclude lightproof; } > constraints.txt

# the constraints pin what CI has tested; a marker file keeps a second run from installing again
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

$(INSTALLED): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "Python 3.11 or later is needed; found $$($(PYTHON) --version). Try: make PYTHON=python3.12"; exit 1; }
	@echo "Setting up $(VENV); this takes a minute, once"
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade "pip>=25.1"
	@$(PIP) --editable .
	@touch $@

$(INSTALLED_DEV): $(INSTALLED)
	@$(PIP) --group dev
	@touch $@

clean:
	rm -rf $(VENV) build dist .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
