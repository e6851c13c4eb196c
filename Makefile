# Every target does its own set-up; a second call installs nothing.
PYTHON ?= python3
VENV   ?= .venv
BIN     = $(VENV)/bin
STAMP   = $(VENV)/.installed
CONSTRAINTS ?= constraints.txt
# More than processors: tests with real processes mostly wait.
PYTEST_WORKERS ?= 3

# Threads of NumPy and numba must neither fight nor spin while they wait.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_WAIT_POLICY ?= passive
# Tests start a thousand processes: one that keeps no bytecode compiles all of it at every start.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help demo test tests-alone test-long test-quick test-numba test-arm check fmt wheel golden proto clean real-input worlds figures studies limits standing standing-flow

help:            ## say what there is
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/'

demo: $(STAMP)   ## learn, export, drive, record, replay
	$(BIN)/reflexarc demo

test: check      ## every check, then every test
	$(BIN)/pytest -n $(PYTEST_WORKERS) --dist worksteal

tests-alone: $(STAMP)
	$(BIN)/pytest -n $(PYTEST_WORKERS) --dist worksteal

test-long: $(STAMP) ## more tests with real processes: three minutes
	$(BIN)/pytest -m long -n $(PYTEST_WORKERS) --dist worksteal

test-quick: $(STAMP) ## what a change breaks first: no robots, no training
	$(BIN)/pytest -q -n $(PYTEST_WORKERS) tests/house tests/docs tests/runtime tests/logs/container tests/cli/terminal

# Each version of Numba, and each Python (PYTHON=python3.13), gets an environment of its own, with
# constraints of its own: what Numba needs of NumPy and llvmlite is its own choice. Types are checked
# with the pinned versions only: older ones have no stubs.
test-numba:      ## every test on another Numba: VERSION=0.62.1 [PYTHON=python3.12]
	@test -n "$(VERSION)" || { echo 'test-numba: VERSION=0.62.1: which version of Numba?' >&2; exit 2; }
	$(MAKE) runs/constraints-numba-$(VERSION).txt
	$(MAKE) tests-alone VENV=.venv-$(notdir $(PYTHON))-numba-$(VERSION) \
		CONSTRAINTS=runs/constraints-numba-$(VERSION).txt

runs/constraints-numba-%.txt: constraints.txt
	mkdir -p runs
	grep -vE '^(numba|llvmlite|numpy)==' $< > $@
	echo 'numba==$*' >> $@

# The emulated machine lies in .arm/; a second call downloads nothing.
test-arm: $(STAMP) ## replay the golden logs on an emulated aarch64: the same bits?
	$(BIN)/python tests/arm/replay_on_arm.py

check: $(STAMP)  ## format, linter, types, import contracts
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

fmt: $(STAMP)    ## format the code, mend what the linter can
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# In an environment of its own: what builds it, without torch and all that tests need.
wheel:           ## build dist/reflexarc-*.whl
	test -x .venv-wheel/bin/python || $(PYTHON) -m venv .venv-wheel
	.venv-wheel/bin/pip install --quiet --disable-pip-version-check -c $(CONSTRAINTS) build hatchling
	.venv-wheel/bin/python -m build --wheel --no-isolation --outdir dist .

golden: $(STAMP) ## rebuild the golden logs; look at the difference before you commit it
	$(BIN)/python tests/golden/build.py

real-input: $(STAMP) ## a reflex on real lidar logs: DATA="intel.log.gz …" (CARMEN, CoreSLAM) → table and pictures
	@test -n "$(DATA)" || { echo 'real-input: DATA="path/to/intel.log.gz …": which lidar logs?' >&2; exit 2; }
	$(BIN)/python docs/real_input.py $(DATA)

worlds: $(STAMP) ## check and draw every shipped world → docs/worlds.md and its pictures
	$(BIN)/python docs/worlds_page.py

# A drive in lockstep is the same on every machine; its robot has a name that no other drive has.
figures: $(STAMP) ## draw the pictures that need no measuring (a minute) → docs/figures/
	$(BIN)/reflexarc train
	$(BIN)/reflexarc sim --seed 7 --lockstep --steps 600 --robot figures & \
		trap "kill $$! 2>/dev/null || true" EXIT; \
		$(BIN)/reflexarc run runs/reflex-0/policy.onnx --lockstep --ticks 600 --robot figures \
		--record runs/drive.mcap
	$(BIN)/reflexarc render runs/drive.mcap -o docs/figures/drive.png
	$(BIN)/reflexarc render crossing -o docs/figures/crossing.gif --policy runs/reflex-0/policy.onnx --seed 1
	$(BIN)/python docs/environment_picture.py

studies: $(STAMP) ## run every shipped study (half an hour) → docs/studies/
	for file in trainer/reflexarc_trainer/study/shipped/*.toml; do \
		$(BIN)/reflexarc study $$(basename $$file .toml) || [ $$? = 1 ] || exit 2; done
	$(BIN)/python docs/studies_page.py

standing: $(STAMP) ## train, measure everybody on the full suite → docs/standing.md: an hour and more
	for seed in 0 1 2 3 4; do for preset in reflex paper online binocular reflex-online rover; do \
		test -f runs/presets/$$preset-$$seed/policy.onnx || \
		$(BIN)/reflexarc train --preset $$preset --seed $$seed --out runs/presets/$$preset-$$seed; done; done
	$(BIN)/python benchmarks/rivals.py --seeds 5
	$(BIN)/reflexarc evaluate runs/presets/*/policy.onnx runs/rivals/*.onnx --suite full --setting field \
		--baseline random $$($(BIN)/python -c 'from reflexarc_baselines.registry import HOMES; print(*(n for n in HOMES if n != "blind" and not n.startswith("flow")))') \
		--resume
	$(BIN)/python docs/standing_page.py runs/evaluation-full/results.json
	$(MAKE) standing-flow

# Their quarter of the sideways speed has limits of its own. The grid of robustness is left out: it
# divides by a score, and none of theirs is above that of an agent that never steers.
SUITE ?= full
standing-flow: $(STAMP) ## measure those that see by flow [SUITE=lite] → their section of docs/standing.md
	$(BIN)/reflexarc evaluate --suite $(SUITE) --setting field --no-page --resume -o runs/evaluation-flow-$(SUITE) \
		--family discs rectangles outlines gates corridors steps motion appearance senses timing body automata home \
		--baseline $$($(BIN)/python -c 'from reflexarc_baselines.registry import HOMES; print(*(n for n in HOMES if n.startswith("flow")))')
	$(BIN)/python docs/standing_page.py runs/evaluation-flow-$(SUITE)/results.json --flow

limits: $(STAMP) ## the oracle's figures that ship with the suites: half an hour
	$(BIN)/python -m reflexarc_sim_bridge.evaluation.limits.shipping

proto:           ## generate messages_pb2 (protoc of grpcio-tools 1.71, the oldest supported protobuf)
	$(PYTHON) -m venv .venv-proto
	.venv-proto/bin/pip install --quiet grpcio-tools==1.71.2
	.venv-proto/bin/python -m grpc_tools.protoc -I runtime --python_out=runtime --pyi_out=runtime \
		reflexarc_runtime/messages.proto

clean:           ## remove the environment, the emulated machine and what was built
	rm -rf .venv .venv-* .arm dist

$(STAMP): pyproject.toml $(CONSTRAINTS)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -c $(CONSTRAINTS) -e '.[dev]'
	touch $(STAMP)
