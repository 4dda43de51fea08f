# make bench   set up and print the benchmark's table      make test    set up and run the tests
# make check   format, lint, types, import contracts       make setup   only set up
# make wheel   build the wheel and run one episode from it

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
EPISODES ?= 2
WORKERS ?= 2

.PHONY: setup setup-dev bench test check wheel clean

setup: $(VENV)/.installed
setup-dev: $(VENV)/.installed-dev

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; sys.exit("Python >= 3.11 is needed, this is %d.%d" % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

bench: setup
	$(BIN)/icd-bench run --agent icd --agent pc-mppi --agent expert --agent random --env ICDCableRouting-v0 \
		--episodes $(EPISODES) --workers $(WORKERS)

test: setup-dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(WORKERS) --dist loadfile

check: setup-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

wheel: setup
	rm -rf build dist
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --target build/site dist/*.whl
	cd build && PYTHONPATH=site ../$(BIN)/python -m benchmarks run --agent expert \
		--env ICDCableRouting-v0 --episodes 1 --out run

clean:
	rm -rf $(VENV) build dist *.egg-info runs
