# `make run` renders a picture, `make test` checks everything; both set up what they need first (see tools/setup.py).

PYTHON ?= python3
VENV_PYTHON := .venv/bin/python
SCENE ?= scenes/scene.json
OUT ?= out/$(basename $(notdir $(SCENE))).ppm
ARGS ?=

.PHONY: help setup run compare test test-all testsuite bench report docs doctor clean

help:
	@echo "make run        render SCENE (default: $(SCENE)) to OUT (default: $(OUT))"
	@echo "make compare    tell how far picture A is from reference B: make compare A=mine.ppm B=scene.exr"
	@echo "make test       run the tests (make test-all: the slow ones too); ARGS are passed on to pytest"
	@echo "make testsuite  render the pictures of TestSuite/"
	@echo "make bench      measure speed, error and memory beside Mitsuba"
	@echo "make report     make the figures of Report/report.pdf and typeset it"
	@echo "make docs       write the reference pages that are made from the code"
	@echo "make doctor     tell what is installed, what is wrong, and how to mend it"
	@echo "make setup      only install: .venv, pinned packages, LLVM"
	@echo "make clean      remove what was installed here; pictures in out/ stay"

setup: require-python
	@$(PYTHON) tools/setup.py run

run: setup
	@mkdir -p "$$(dirname "$(OUT)")"
	@$(VENV_PYTHON) -m renderer "$(SCENE)" -o "$(OUT)" $(ARGS)
	@echo "The picture is in $(OUT)"

compare: require-pictures setup-compare
	@$(VENV_PYTHON) -m renderer compare "$(A)" "$(B)" $(ARGS)

test: setup-test
	@$(VENV_PYTHON) -m pytest $(ARGS)

test-all: setup-test
	@$(VENV_PYTHON) -m pytest -m "slow or not slow" $(ARGS)

testsuite: setup-test
	@$(VENV_PYTHON) -m tools.testsuite $(ARGS)

bench: setup-bench
	@$(VENV_PYTHON) -m benchmarks $(ARGS)

report: setup-report
	@$(VENV_PYTHON) -m tools.report $(ARGS)

docs: setup
	@$(VENV_PYTHON) -m renderer.scene.reference

doctor: setup
	@$(VENV_PYTHON) -m renderer doctor

clean: # set-up never deletes an environment that the user made, and pictures cannot be had back by make
	rm -rf .pytest_cache .hypothesis
	@if [ -e .venv/setup/made-here ] || [ ! -e .venv ]; then echo rm -rf .venv; rm -rf .venv; \
	else echo ".venv was not made by make and stays; delete it yourself"; fi

.PHONY: setup-test setup-bench setup-report setup-compare require-python require-pictures
setup-test: require-python
	@$(PYTHON) tools/setup.py run test

setup-bench: require-python
	@$(PYTHON) tools/setup.py run test bench

setup-report: require-python
	@$(PYTHON) tools/setup.py run test report

setup-compare: require-python
	@$(PYTHON) tools/setup.py run compare

require-pictures:
	@test -n "$(A)" && test -n "$(B)" || { echo "two pictures are needed: make compare A=mine.ppm B=scene.exr" >&2; exit 2; }

require-python:
	@command -v $(PYTHON) >/dev/null || { echo "$(PYTHON) was not found; Python 3.11 or newer is needed" >&2; exit 1; }
