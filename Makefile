# Everything a fresh machine needs: `make demo` runs the main job, `make test` passes the tests.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: reproduce demo setup test test-bare fuzz check format bench docs videos setup-oracles setup-blender test-oracles clean

demo: $(READY)  ## walk with a kick pasted in: clips, document, pictures and numbers in the folder demo/
	$(BIN)/kinestitch demo demo

setup: $(READY)  ## the environment, in .venv

$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Python 3.11 or later is needed: make PYTHON=python3.11 …"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(PIP) --upgrade pip
	$(PIP) --editable '.[dev]'
	touch $@

test: $(READY)  ## all tests that need no other program; real clips come from KINESTITCH_DATA
	$(BIN)/python -m pytest --doctest-modules src tests --ignore=tests/oracles

test-bare:  ## a fresh environment without extras, in .venv-bare: the package is whole, works, and names what misses
	PYTHON=$(PYTHON) sh tests/install/check_bare.sh

fuzz: $(READY)  ## 10,000 damaged files for every reader; what goes wrong is kept in tests/fuzz/corpus
	$(BIN)/python tests/fuzz/run.py --count 10000

check: $(READY)  ## format, lint, types, and one run of every benchmark
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python -m pytest benchmarks --quiet --benchmark-disable

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(READY)  ## every benchmark in full; writes docs/benchmarks.md
	$(PIP) --editable '.[bench]'
	$(BIN)/python -m pytest benchmarks --quiet --ratios docs/benchmarks.md

docs: $(READY)  ## the pictures, from the samples; and the tables, from the real clips where KINESTITCH_DATA is set
	$(BIN)/python docs/make_pictures.py
	@if [ -n "$$KINESTITCH_DATA" ]; then for table in seams features adaptive retargeting cutting loops; do \
	$(BIN)/python -m kinestitch.experiments.$$table "$$KINESTITCH_DATA" -o docs/$$table.md || exit 1; done; \
	$(BIN)/python -m kinestitch.experiments.phase "$$KINESTITCH_DATA" -o docs/time.md || exit 1; \
	$(BIN)/python -m kinestitch.experiments.feet "$$KINESTITCH_DATA" -o docs/feet_table.md || exit 1; \
	else echo "KINESTITCH_DATA is not set: the tables in docs stay as they are"; fi

videos: $(READY)  ## the samples' edits as videos, and stills around their seams, in the folder videos/
	$(BIN)/python docs/make_videos.py videos

reproduce: $(READY)  ## the paper's figures and claims, computed anew: out/report.html, docs/results.md, docs/results.json
	$(BIN)/kinestitch reproduce $(KINESTITCH_DATA) -o out --docs $(if $(KINESTITCH_DATA),docs,out)

setup-oracles: $(READY)  ## other people's readers, each in an environment of its own
	PYTHON=$(PYTHON) sh tests/oracles/setup.sh
	sh tests/oracles/setup_validator.sh

setup-blender:  ## Blender as a Python module, in .venv-bpy; KINESTITCH_BLENDER may name another Python that has it
	PYTHON=$(PYTHON) sh tests/oracles/setup.sh bpy

test-oracles: setup-oracles  ## our files and numbers against Blender, ufbx and the glTF validator
	KINESTITCH_ORACLES=1 $(BIN)/python -m pytest tests/oracles tests/files/test_gltf_validator.py

clean:
	rm -rf $(VENV) .venv-* demo videos build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
