# On Windows use the commands of README.md, or run this in a POSIX shell (Git Bash, WSL).
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

.PHONY: setup setup-dev demo test test-failed test-all test-fast lint format bench soak clean

setup: $(VENV)/.installed
setup-dev: $(VENV)/.installed-dev

$(VENV)/.installed: pyproject.toml constraints.txt
	@echo "installing labrig and what it needs into $(VENV) ..."
	@$(PYTHON) -m venv $(VENV)
	@$(PIP) -e .
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	@echo "installing what the tests and linters need ..."
	@$(PIP) -e ".[dev]"
	@touch $@

demo: setup
	@rm -rf demo
	@$(BIN)/labrig demo demo

test: setup-dev
	$(BIN)/python -m pytest -n 2

test-failed: setup-dev
	$(BIN)/python -m pytest --last-failed --last-failed-no-failures none

test-all: setup-dev
	$(BIN)/python -m pytest -n 2 -m ""

test-fast: setup-dev
	$(BIN)/python -m pytest -n 2 -m "not slow and not thorough"

lint: setup-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: setup-dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: setup-dev
	$(BIN)/python -m benchmarks

soak: setup-dev
	$(BIN)/python -m benchmarks.soak --runs 200

clean:
	rm -rf $(VENV) demo build *.egg-info
