# On Windows use the commands of README.md, or run this in a POSIX shell (Git Bash, WSL).
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
PYTEST := $(BIN)/python -m pytest
# Between them they use all that numba compiles; else each worker would compile it for itself. The
# end of `make test` names what was compiled after all.
# A test of theirs that compiles must not be marked slow: it would compile beside the others.
# The two share nothing that is compiled, so that side by side they compile nothing twice.
MECHANICS := tests/model/test_predict.py tests/model/test_engines.py tests/model/test_design.py \
	tests/model/test_equilibrium_reference.py tests/model/dynamics/test_numpy_reference.py
PICTURES := tests/sim_hardware/test_optics_images.py tests/sim_hardware/test_world_chain.py \
	tests/sim_hardware/test_world_effects.py tests/sim_hardware/test_world.py \
	tests/sim_hardware/test_moving_world.py tests/labrig/vision/test_batch.py \
	tests/labrig/vision/test_shortest_path.py tests/labrig/vision/test_strip_end.py \
	tests/labrig/vision/test_edge_pairs.py tests/labrig/vision/test_beam_selection.py
# Without a time-out: a compilation that is cut short is not kept.
COMPILE = $(PYTEST) --timeout 0 -o faulthandler_timeout=0 -q -m "not slow and not thorough"
# Where `loadfile` replaces a process that has ended, it begins again with what ended it.
TWO_ALONE = $(PYTEST) -n 2 --dist loadfile --no-loadscope-reorder -o faulthandler_exit_on_timeout=false
# The files with such tests: to collect all others takes seconds.
ALONE = $(shell grep -rl --include='*.py' 'mark\.alone' tests)
COMPILED := $(VENV)/.compiled
COMPILED_SOURCES = $(shell grep -rlw --include='*.py' jit labrig model sim_hardware)
PIP := $(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check -c constraints.txt

# Empty, so that compiled code is kept: the tests start hundreds of processes.
export PYTHONDONTWRITEBYTECODE :=

# Warnings are errors; notebooks and commands of the pages are run.
SPHINX = $(BIN)/python -m sphinx -b html -W --keep-going -q

.PHONY: setup setup-dev setup-docs setup-all demo docs docs-after-compiled compiled compiled-mechanics compiled-pictures collected \
	test test-compiled test-failed test-all test-fast lint format bench soak clean

setup: $(VENV)/.installed
setup-dev: $(VENV)/.installed-dev

$(VENV)/.installed: pyproject.toml constraints.txt
	@echo "installing labrig and what it needs into $(VENV) ..."
	@$(PYTHON) -m venv $(VENV)
	@$(PIP) -e .
	@touch $@

# At once with what labrig needs: one call of pip is quicker than two.
$(VENV)/.installed-dev: pyproject.toml constraints.txt
	@echo "installing labrig and what it, the tests and the linters need into $(VENV) ..."
	@test -d $(VENV) || $(PYTHON) -m venv $(VENV)
	@$(PIP) -e ".[dev]"
	@touch $(VENV)/.installed $@

setup-docs: $(VENV)/.installed-docs

$(VENV)/.installed-docs: pyproject.toml constraints.txt
	@echo "installing labrig and what its documentation needs into $(VENV) ..."
	@test -d $(VENV) || $(PYTHON) -m venv $(VENV)
	@$(PIP) -e ".[docs]"
	@touch $@

# For CI: at once, for the same reason.
setup-all: pyproject.toml constraints.txt
	@echo "installing labrig and what it, the tests, the linters and the documentation need into $(VENV) ..."
	@test -d $(VENV) || $(PYTHON) -m venv $(VENV)
	@$(PIP) -e ".[dev,docs]"
	@touch $(VENV)/.installed $(VENV)/.installed-dev $(VENV)/.installed-docs

docs: setup-docs
	@$(SPHINX) docs docs/_build/html
	@echo "open docs/_build/html/index.html"

# For CI: beside the linters, and not beside what it would compile a second time.
docs-after-compiled: compiled
	@$(MAKE) --no-print-directory docs

demo: setup
	@rm -rf demo
	@$(BIN)/labrig demo demo

compiled: compiled-mechanics compiled-pictures
	@touch $(COMPILED)

compiled-mechanics: setup-dev
	@-$(COMPILE) $(MECHANICS)

compiled-pictures: setup-dev
	@-$(COMPILE) $(PICTURES)

# The tests as bytecode, once. In a fresh clone each of the four workers would compile them for itself,
# which takes half of the time to collect them.
collected: setup-dev
	@$(PYTEST) -q --collect-only > $(VENV)/.collected

# Compiled code is kept between runs; it is made first only where sources of it are newer. The tests'
# bytecode is made beside the longer of the two halves, when the shorter one is done.
$(COMPILED): $(COMPILED_SOURCES)
	@$(MAKE) --no-print-directory -j 2 compiled collected

test: setup-dev $(COMPILED)
	@$(MAKE) --no-print-directory test-compiled

# Four at a time, of which two wait most of the time (tests/side_by_side.py), and then two at a time
# what is measured against the real clock, beside which nothing may compute.
test-compiled: setup-dev
	@$(PYTEST) -n 4 --dist worksteal -m "not thorough and not alone"; code=$$?; \
	$(TWO_ALONE) -m "alone and not thorough" $(ALONE) && exit $$code

test-failed: setup-dev
	$(PYTEST) --last-failed --last-failed-no-failures none -m ""

test-all: setup-dev $(COMPILED)
	@$(PYTEST) -n 4 --dist worksteal -m "not alone"; code=$$?; \
	$(TWO_ALONE) -m alone $(ALONE) && exit $$code

test-fast: setup-dev
	$(PYTEST) -n 2 --dist worksteal -m "not slow and not thorough and not alone"

# The second mypy reads what only Windows runs.
lint: setup-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy --platform win32 --disable-error-code unreachable --no-warn-unused-ignores --cache-dir .mypy_cache/win32
	$(BIN)/lint-imports

format: setup-dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: setup-dev
	$(BIN)/python -m benchmarks

soak: setup-dev
	$(BIN)/python -m benchmarks.soak --runs 200

clean:
	rm -rf $(VENV) demo build docs/_build *.egg-info
