# make run    set up what is missing, then analyse the default engine at 6000 rpm with pictures
# make test   set up what is missing, then run the tests, but for slow ones
# make test-slow   run the slow ones: long jobs, campaigns, films, cycles of rods in parts
# make docs   build the manual into docs/_build/html
# make pages  check syntax, references and spelling of the manual, without running what it shows
# make lint   style, types and the direction of imports
# make setup  only set up

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

# Tests run side by side: more threads inside each would only stand in each other's way.
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1
# They start the program some hundred times: it is compiled once, whatever the environment says.
COMPILED := PYTHONDONTWRITEBYTECODE=

.PHONY: run test test-slow lint docs pages setup clean

run: $(VENV)/.run
	$(BIN)/fea run --rpm 6000 --screenshot

test: $(VENV)/.dev
	$(ONE_THREAD) $(COMPILED) $(BIN)/python -m pytest --numprocesses 2 --dist worksteal -m "not slow"

test-slow: $(VENV)/.dev
	$(ONE_THREAD) $(COMPILED) $(BIN)/python -m pytest --numprocesses 2 --dist worksteal -m slow

lint: $(VENV)/.dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/mypy --platform win32 --no-warn-unreachable --cache-dir .mypy_cache/win32
	$(BIN)/mypy --platform darwin --no-warn-unreachable --cache-dir .mypy_cache/darwin
	$(BIN)/mypy --config-file tests/benchmarks/mypy.ini
	$(BIN)/lint-imports

# Pages are built side by side, so what they run has one thread.
docs: pages
	$(ONE_THREAD) $(BIN)/python -m sphinx --quiet --jobs auto --fail-on-warning --keep-going -d docs/_build/doctrees docs docs/_build/html
	@echo "docs/_build/html/index.html"

pages: $(VENV)/.docs
	$(BIN)/python -m sphinx --quiet --builder dummy --fail-on-warning --keep-going docs docs/_build/pages
	$(BIN)/codespell

setup: $(VENV)/.run

clean:
	rm -rf $(VENV) build dist docs/_build

# The stamps say that everything is installed; an environment whose making was interrupted has none, and
# is made anew if its pip does not work.
$(VENV)/.run: pyproject.toml
	@$(PYTHON) .ci/system_packages.py
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || { rm -rf $(VENV) && $(PYTHON) -m venv $(VENV); }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

# Dependency groups came with pip 25.1.
$(VENV)/.dev: $(VENV)/.run
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "pip>=25.1"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --group dev
	@touch $@

$(VENV)/.docs: $(VENV)/.run
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "pip>=25.1"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[sweep]" --group docs
	@touch $@
