# `make` lists the targets.  Each sets itself up in ./.venv at the versions of constraints.txt, and again when those change.
# Needs Python 3.11 or newer and make.  PYTHON=python3.12 chooses the interpreter; ARGS=... goes to the command behind a target.

PYTHON ?=
ARGS =
BIN = .venv/bin
PIP = $(BIN)/python -m pip install --disable-pip-version-check --no-input -c constraints.txt
# One linear-algebra thread for each of the two test processes: more only compete for the cores.
ONE_THREAD = OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
PYTEST = $(ONE_THREAD) $(BIN)/python -m pytest
# Without the plugins of nbmake and zarr, each of which takes each process a third of a second to load, and that of
# logging, which listens anew before, in and after each test.
TESTS = $(PYTEST) -p no:nbmake -p no:zarr -p no:logging -n 2

.DEFAULT_GOAL = help
.NOTPARALLEL:
.DELETE_ON_ERROR:
.SUFFIXES:
.PHONY: help report explore explore-test test slow thorough quick check bench benchmarks-table notebooks docs paper release clean FORCE
unexport PYTHONPATH PYTHONHOME VIRTUAL_ENV
unexport PYTHONDONTWRITEBYTECODE # to compile a hundred modules at each start of Python takes minutes of the tests

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## /\1	/p' Makefile

report: .venv/.core ## the report on the paper's rod, into ./lure-report; ARGS="my-rod.toml" for your own
	$(BIN)/lure report $(ARGS)

explore: .venv/.core ## the page on which a loop is explored in the browser, into ./lure-page; ARGS="plant.toml" for your own
	$(BIN)/lure explore $(ARGS)

explore-test: .venv/.browser ## that page in Chromium: what it says is what the command says; without Chromium or npm it says so
	$(PYTEST) -p no:nbmake -m browser -rs -s $(ARGS) tests/explore

test: .venv/.test ## the tests; ARGS="-k popov" for some
	$(TESTS) --dist worksteal $(ARGS)

slow: .venv/.test ## the dearest tests, eight minutes of them, which `make test` leaves out
	$(TESTS) --dist worksteal -m slow $(ARGS)

thorough: .venv/.test ## these two and more, with large samples and many random examples: for a night
	$(TESTS) --dist worksteal --hypothesis-profile=thorough $(ARGS)

quick: .venv/.test ## under a minute: tests that name what is changed, then some of every floor, no slow ones
	$(TESTS) $(ARGS) $$($(BIN)/python tests/quick.py)

check: .venv/.dev ## format, lint and docstrings, types, tests; stops at the first that fails
	$(BIN)/python -m ruff format --check .
	$(BIN)/python -m ruff check .
	$(BIN)/python -m mypy
	$(TESTS) --dist worksteal $(ARGS)

bench: .venv/.bench ## the benchmarks, one after another
	@set -e; for script in benchmarks/*.py; do echo "== $$script"; $(ONE_THREAD) $(BIN)/python "$$script"; done

benchmarks-table: .venv/.core ## published numbers against ours: circle to Zames-Falb, and counterexamples
	$(BIN)/python benchmarks/published/table.py $(ARGS)

notebooks: .venv/.test ## run the notebooks; what they show is then in build/notebooks
	rm -rf build/notebooks
	$(BIN)/python -m jupytext --quiet --to ../build/notebooks//ipynb --set-kernel python3 notebooks/*.py
	$(PYTEST) -n 2 --nbmake --nbmake-timeout=600 --overwrite $(ARGS) build/notebooks
	@if grep -l '"name": "stderr"' build/notebooks/*.ipynb; then echo "A warning is on the page of what is named above." >&2; exit 1; fi
	@touch build/notebooks/.run

build/notebooks/.run: $(wildcard notebooks/*.py)
	@$(MAKE) --no-print-directory notebooks ARGS=

docs: .venv/.docs build/notebooks/.run ## the documentation, into build/docs/index.html; its notebooks and pages are run first
	$(TESTS) --dist worksteal -m pages tests/house/test_docs.py
	$(ONE_THREAD) $(BIN)/python -m sphinx -q -W --keep-going -d build/doctrees docs build/docs
	$(BIN)/python docs/links.py build/docs

paper: .venv/.core ## the paper about lure with its figures, into build/paper, as the Journal of Open Source Software takes it
	rm -rf build/paper && mkdir -p build && cp -r paper build/paper
	$(BIN)/lure report dt-6 -o build/paper/dt-6 --quiet
	cp build/paper/dt-6/figures/largest.svg build/paper/classes.svg
	cp notebooks/figures/popov.svg build/paper/popov.svg

release: .venv/.core ## what a release is, up to the upload and without it; wheel and sdist are then in dist; ARGS=--rehearse
	.ci/release $(ARGS)

clean: ## remove the environment, the caches and everything made here
	rm -rf .venv .pytest_cache .hypothesis .mypy_cache .ruff_cache build dist lure-report lure-page
	rm -rf docs/notebooks docs/notes docs/pictures docs/project docs/reference/api
	find . -name .git -prune -o -name __pycache__ -prune -exec rm -rf {} +

# A stamp is written after pip has succeeded, and a larger set of packages stands for the smaller ones.

.venv/.core: .venv/.place pyproject.toml constraints.txt
	$(call install,.,lure)
	@touch $@

.venv/.bench: .venv/.place pyproject.toml constraints.txt
	$(call install,.[bench],lure and the peers it is compared with)
	@touch .venv/.core $@

.venv/.test: .venv/.place pyproject.toml constraints.txt
	$(call install,.[test],lure and what its tests need)
	@touch .venv/.core $@

.venv/.docs: .venv/.place pyproject.toml constraints.txt
	$(call install,.[docs],lure and what its tests and documentation need)
	@touch .venv/.core .venv/.test $@

.venv/.browser: .venv/.place pyproject.toml constraints.txt
	$(call install,.[browser],lure and what drives a browser)
	@touch .venv/.core .venv/.test $@

.venv/.dev: .venv/.place pyproject.toml constraints.txt
	$(call install,.[dev],lure and what its tests and checks need)
	@touch .venv/.core .venv/.test $@

# .venv/.unfinished outlives only an install that was killed; the half-unpacked packages it may have left are not mended.
define install
@echo "Installing $(2) into .venv ..."
@touch .venv/.unfinished
@{ $(PIP) hatchling editables && $(PIP) --no-build-isolation -e '$(1)'; } >.venv/install.log 2>&1 || { \
	cat .venv/install.log >&2; rm -f .venv/.unfinished; \
	echo "pip could not install what constraints.txt names (its messages are above); if a package has no build for this" \
		"Python, choose another: make PYTHON=python3.13" >&2; exit 1; }
@rm -f .venv/.unfinished
endef

# Keeps .venv if it works, stands where it was made and is of the PYTHON asked for; makes it anew otherwise.
# The file changes only then, so that nothing is installed again without need.
.venv/.place: FORCE
	@of() { "$$1" -c 'import sys; print(sys.base_prefix, sys.version)' 2>/dev/null; }; \
	fits() { "$$1" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }; \
	if [ "$$(cat $@ 2>/dev/null)" = "$$(pwd -P)" ] && [ ! -e .venv/.unfinished ] && \
		$(BIN)/python -c 'import pip' 2>/dev/null && \
		{ [ -z "$$PYTHON" ] || [ "$$(of "$$PYTHON")" = "$$(of $(BIN)/python)" ]; }; then exit 0; fi; \
	if [ -n "$$PYTHON" ]; then set -- "$$PYTHON"; else set -- python3 python3.13 python3.12 python3.11; fi; \
	for python do if fits "$$python"; then \
		echo "Making .venv with $$("$$python" --version) ..."; \
		rm -rf .venv && "$$python" -m venv .venv && pwd -P >$@ && exit 0; exit 1; \
	fi; done; \
	echo "No Python 3.11 or newer with venv and pip among: $$*; install one (Debian, Ubuntu: python3 and python3-venv)" \
		"or name it: make PYTHON=/path/to/python3" >&2; exit 1
