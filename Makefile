# tfsat: `make` lists what can be made.
.NOTPARALLEL:
.DEFAULT_GOAL := help
SHELL := /bin/sh

VENV := .venv
BIN := $(VENV)/bin
SEARCHED := python3 python3.14 python3.13 python3.12 python3.11
PYTHON ?= $(shell for p in $(SEARCHED); do \
  "$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo "$$p"; break; }; done)
MAKE_VENV = $(PYTHON) -m venv --clear

export PIP_DISABLE_PIP_VERSION_CHECK := 1
# Hundreds of processes of a test run import the same modules: what is compiled is kept, as containers often forbid.
export PYTHONDONTWRITEBYTECODE :=
# The same lock in the same place means the same environment, however new the files look.
LOCKED = $$(cksum <requirements.lock) $(CURDIR)
LOCKED_RUNTIME = $$(cksum <requirements-runtime.lock) $(CURDIR)
PACKAGED = $$(cksum <pyproject.toml)

# Bold where a person reads it, plain in files and pipes.
define say
@if [ -t 1 ] && [ -n "$$TERM" ] && [ "$$TERM" != dumb ] && [ -z "$$NO_COLOR$$CI" ]; \
  then printf '\033[1m== %s\033[0m\n' "$(1)"; else printf '== %s\n' "$(1)"; fi
endef

.PHONY: help
help:  ## this list
	@echo "tfsat: flight software and ground tools of a transformable CubeSat robot"
	@echo
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-16s %s\n", $$1, $$2 }' Makefile

.PHONY: demo
demo: compiler runtime  ## a whole drop on the desk: rehearsed, evaluated, reported, bundled, reproduced (Python, C++ compiler)
	$(call say,building the emulated robot)
	@$(BIN)/python -m tfsat_host.emulated.build >/dev/null
	$(call say,rehearsing 59/70: from the upload to the report)
	@$(BIN)/tfsat-host rehearse 59 70 --out build/demo --force
	$(call say,the same with a dead gyro: the preflight must see it)
# Of the whole screen the verdict and where the rest is; all of it where the preflight does not end it with NO-GO (4).
	@$(BIN)/tfsat-host rehearse 59 70 --fault gyro-dead@powered --out build/demo-no-go --force >build/demo-no-go.txt 2>&1; \
	  [ $$? = 4 ] && sed -n '/^Preflight:/,/^All checks:/p;/^All checks:/q' build/demo-no-go.txt || \
	  { cat build/demo-no-go.txt; exit 1; }
	$(call say,everything in one archive - and recomputed from the raw data in it)
	@$(BIN)/tfsat-host bundle build/demo --out build/demo.tfsat.zip --force
	@rm -rf build/demo-reproduced && $(BIN)/tfsat-host reproduce build/demo.tfsat.zip --out build/demo-reproduced
	$(call say,results in build/demo)
	@echo "Open this one: build/demo/report.html"
	@echo "Once more by hand: $(BIN)/tfsat-host evaluate build/demo"

.PHONY: test
# Style and types are checked beside the tests. A test on each core leaves none for a second thread of its linear algebra.
test: toolchain compiler venv firmware protocol-check wiring-check  ## install what is missing, build both firmwares, run every test
	$(call say,tests)
	@$(MAKE) --no-print-directory lint & lint=$$!; \
	  OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist worksteal; tests=$$?; \
	  wait $$lint || { echo "Error: style or types, see above, or: make lint" >&2; exit 1; }; exit $$tests
	@$(BIN)/python -m tests.validation.stale

RUNS := 10000000
BOARD_RUNS := 1000000

.PHONY: fuzz
fuzz: toolchain venv  ## look for inputs that break the link or the board, RUNS=10000000 BOARD_RUNS=1000000
	$(call say,fuzzing the link (RUNS=$(RUNS)) and the board behind it (BOARD_RUNS=$(BOARD_RUNS)))
	@$(BIN)/python -m tests.validation.fuzz.campaign --runs $(RUNS) --board-runs $(BOARD_RUNS)

# atheris has wheels for Linux alone, so it stays out of the lock.
.PHONY: fuzz-decode
fuzz-decode: RUNS := 1000000
fuzz-decode: venv  ## look for damaged logs that the decoder gets wrong, RUNS=1000000 (a quarter of an hour on two cores)
	$(call say,fuzzing the decoder (RUNS=$(RUNS)))
	@[ -e build/fuzz-decode/installed ] || { $(MAKE_VENV) build/fuzz-decode/venv && \
	  build/fuzz-decode/venv/bin/pip install -qq atheris numpy fastcrc && touch build/fuzz-decode/installed; }
	@$(BIN)/python -m tests.validation.fuzz.log_campaign --runs $(RUNS)

.PHONY: bench-decode
bench-decode: decoders  ## measure the decoder next to pyulog, mcap, pymavlink's DFReader and Kaitai on the same samples
	$(call say,decoders on the same samples)
	@PYTHONPATH=host:. build/bench-decode/venv/bin/python -m tests.validation.decode_bench

.PHONY: bench-design
bench-design: venv  ## measure the maneuver design next to the same swarm by MuJoCo rollouts, and the grids
	$(call say,the maneuver design on one core)
	@$(BIN)/python -m tests.validation.design_bench

.PHONY: together-report
together-report: venv  ## search for what joints that move together reach (minutes) for docs/joints-together.md
	$(call say,joints that move together)
	@[ -d build/casadi/casadi ] || $(BIN)/pip install -qq --no-deps --target build/casadi casadi
	@OPENBLAS_NUM_THREADS=1 PYTHONPATH=build/casadi $(BIN)/python -m tests.validation.joints_together

.PHONY: paper-numbers
paper-numbers: venv  ## compute the tables of docs/paper-numbers.md (half a minute)
	$(call say,the paper's numbers and ours)
	@$(BIN)/python -m tests.validation.paper_numbers

.PHONY: decode-report
decode-report: compiler venv decoders  ## measure the decoder (minutes), decode four drops and write docs/decode-report.md
	$(call say,what the decoder was measured to do)
	@$(BIN)/python -m tests.validation.decode_bench.report

.PHONY: decoders
decoders: venv
	@[ -e build/bench-decode/installed ] || { $(MAKE_VENV) build/bench-decode/venv && \
	  build/bench-decode/venv/bin/pip install -qq pyulog mcap pymavlink kaitaistruct numpy fastcrc && \
	  touch build/bench-decode/installed; }

.PHONY: sequencer-report
sequencer-report: toolchain venv  ## measure the sequencer's image in full (minutes) for docs/sequencer-proof.md
	$(call say,proving the sequencer's image)
	@$(BIN)/python -m tests.validation.sequencer_proof

.PHONY: logger-report
logger-report: toolchain venv  ## try the logger's core on a failing card in full (minutes) for docs/logger-proof.md
	$(call say,proving the logger's core)
	@$(BIN)/python -m tests.validation.logger_proof

.PHONY: calibration-report
calibration-report: compiler venv  ## calibrate thirty emulated robots (minutes) for docs/calibration-proof.md
	$(call say,how far calibrations are from the truth)
	@$(BIN)/python -m tests.validation.calibration_proof

# One core a process: the campaign has two of them.
.PHONY: evaluation-report
evaluation-report: compiler venv  ## evaluate a thousand emulated drops (an hour on two cores) for docs/evaluation-proof.md
	$(call say,how far evaluations are from the truth)
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.validation.evaluation_proof

.PHONY: sbc-report
sbc-report: compiler venv  ## evaluate 1200 drops with all drawn (twenty minutes) for docs/simulation-based-calibration.md
	$(call say,whether every ± of an evaluation is right)
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.validation.simulation_based_calibration

.PHONY: pages
pages: venv  ## put the campaigns' tables into the pages of docs/
	@$(BIN)/python -m tests.validation.pages

.PHONY: prove
prove: toolchain compiler venv firmware  ## run the campaigns whose code has changed, plant defects that the suite must see (an hour or two)
	$(call say,proof pages)
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.validation.prove
	$(call say,planted defects and wide grids)
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist worksteal -m prove
	$(call say,a defect in each package of the host)
	@$(BIN)/python -m tests.validation.planted_defects

.PHONY: release
release: toolchain venv firmware  ## refuse stale proof pages, a dirty tree, a silent CHANGELOG; else build dist/
	$(call say,release)
	@$(BIN)/python -m tests.validation.release

.PHONY: contract
contract: compiler venv  ## record what commands print and write, after an intended difference; review its diff
	$(call say,what commands print and write from now on)
	@$(BIN)/python -m tests.contract
	@git --no-pager diff --stat tests/contract

.PHONY: screenshots
screenshots: compiler venv  ## draw the pictures of docs/report.md again (needs Chromium)
	$(call say,pictures of the report)
	@$(BIN)/python -m tests.report.screenshots docs/screenshots

# A dead link or an unknown name is an error. What a page calls is imported: numpy, not a board.
.PHONY: guide
guide: venv  ## build the user guide as a site, build/guide/index.html
	$(call say,the user guide)
	@$(BIN)/python -m sphinx -W --keep-going -q -c docs -d build/guide-doctrees . build/guide
	@echo "Open build/guide/index.html"

.PHONY: firmware
firmware: venv  ## build both firmwares for their boards
	$(call say,firmware of the sequencer (Arduino Micro))
	@$(MAKE) --no-print-directory -f tools/firmware/sequencer.mk PYTHON=$(BIN)/python
	$(call say,firmware of the logger (Teensy 4.1))
	@$(MAKE) --no-print-directory -f tools/firmware/logger.mk PYTHON=$(BIN)/python

.PHONY: protocol
protocol: venv  ## regenerate everything that comes from protocol/tfsat.toml
	$(call say,generating from protocol/tfsat.toml)
	@$(BIN)/python tools/generate_protocol.py

.PHONY: protocol-check
protocol-check: venv
	$(call say,generated files against protocol/tfsat.toml)
	@$(BIN)/python tools/generate_protocol.py --check

.PHONY: wiring
wiring: venv  ## draw docs/wiring.svg and write docs/wiring.md from docs/wiring.toml
	$(call say,generating from docs/wiring.toml)
	@$(BIN)/python tools/generate_wiring.py

.PHONY: wiring-check
wiring-check: venv
	$(call say,generated files against docs/wiring.toml)
	@$(BIN)/python tools/generate_wiring.py --check

.PHONY: kaitai
kaitai: venv  ## recompile the tests' independent decoder after the log's layout changed (needs Node.js)
	$(call say,compiling protocol/tfsat_log.ksy)
	@$(BIN)/python tools/compile_kaitai.py

.PHONY: vendor
vendor: venv  ## fetch again what the report page is drawn with, as tools/report_vendor locks it (needs Node.js)
	$(call say,uPlot and twgl.js for the report page)
	@$(BIN)/python tools/vendor_report.py

.PHONY: lint
lint: venv  ## check style, types and which package imports which
	$(call say,style and types)
	@$(BIN)/ruff check --quiet
	@$(BIN)/ruff format --check --quiet || { $(BIN)/ruff format --check; \
	  echo "Error: not formatted. Run: $(BIN)/ruff format" >&2; exit 1; }
	@$(BIN)/mypy --no-error-summary --num-workers auto
	@broken=$$($(BIN)/lint-imports --no-logo --no-cache) || { echo "$$broken"; exit 1; }

# uv resolves for every platform and Python version at once; it lives apart, so that nothing else needs it.
.PHONY: lock
lock: python  ## choose new versions of all dependencies and write requirements.lock
	$(call say,locking dependencies)
	@[ -x build/lock/bin/uv ] || { $(MAKE_VENV) build/lock && build/lock/bin/pip install -qq uv; }
	@build/lock/bin/uv pip compile --no-config --quiet --upgrade --universal --python-version 3.11 \
	  --generate-hashes --no-emit-index-url --extra dev --extra figures --extra parquet --extra pandas --extra xarray --extra mcap --extra dask --extra simulators --extra ferraris --extra guide \
	  --custom-compile-command "make lock" -o requirements.lock pyproject.toml
	@build/lock/bin/uv pip compile --no-config --quiet --universal --python-version 3.11 --constraint requirements.lock \
	  --generate-hashes --no-emit-index-url --extra editable \
	  --custom-compile-command "make lock" -o requirements-runtime.lock pyproject.toml
	@! grep -n '://' requirements.lock requirements-runtime.lock || { echo "Error: a lock names a host" >&2; exit 1; }

# What the commands need and no more: for `make demo`. An environment of `make venv` has it all.
.PHONY: runtime
runtime: python
	@[ "$$(cat $(VENV)/locked 2>/dev/null)" = "$(LOCKED)" ] || \
	  [ "$$(cat $(VENV)/runtime 2>/dev/null)" = "$(LOCKED_RUNTIME)" ] || { set -e; \
	  echo "== environment: installing $$(grep -c '==' requirements-runtime.lock) locked packages into $(VENV)"; \
	  $(MAKE_VENV) $(VENV); \
	  $(BIN)/python -m pip install $$([ -t 1 ] || echo -qq) --require-hashes -r requirements-runtime.lock; \
	  $(BIN)/python -m pip install -qq --no-deps --no-build-isolation -e .; \
	  echo "$(LOCKED_RUNTIME)" >$(VENV)/runtime; }

.PHONY: venv
venv: python
	@[ "$$(cat $(VENV)/locked 2>/dev/null)" = "$(LOCKED)" ] || { set -e; \
	  echo "== environment: installing $$(grep -c '==' requirements.lock) locked packages into $(VENV) (a minute or two)"; \
	  $(MAKE_VENV) $(VENV); \
	  $(BIN)/python -m pip install -qq --require-hashes -r requirements.lock; \
	  echo "$(LOCKED)" >$(VENV)/locked; }
	@[ "$$(cat $(VENV)/packaged 2>/dev/null)" = "$(PACKAGED)" ] || { set -e; \
	  $(BIN)/python -m pip install -qq --no-deps --no-build-isolation -e .; \
	  echo "$(PACKAGED)" >$(VENV)/packaged; }

.PHONY: python
python:
	@[ -n "$(PYTHON)" ] || { echo "Error: no Python 3.11 or newer among: $(SEARCHED)" >&2; \
	  echo "  Everything here runs on Python. Install it (Debian, Ubuntu: apt install python3 python3-venv;" >&2; \
	  echo "  macOS: brew install python; Windows: inside WSL), or name yours: make PYTHON=/path/to/python3" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "Error: $(PYTHON) is not Python 3.11 or newer." >&2; \
	  echo "  Leave PYTHON unset to search for one, or name another: make PYTHON=/path/to/python3" >&2; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { \
	  echo "Error: $(PYTHON) cannot make virtual environments: its venv module is incomplete." >&2; \
	  echo "  Install it (Debian, Ubuntu: apt install python3-venv), then run make again." >&2; exit 1; }

.PHONY: compiler
compiler:
	@for c in "$(CXX)" c++ g++ clang++; do command -v "$$c" >/dev/null 2>&1 && exit 0; done; \
	  echo "Error: no C++ compiler (c++, g++ or clang++)." >&2; \
	  echo "  The emulated robot runs the real firmware, compiled for this computer. Install one" >&2; \
	  echo "  (Debian, Ubuntu: apt install g++; macOS: xcode-select --install), then run make again." >&2; exit 1

.PHONY: toolchain
toolchain:
	@tools/install-toolchain.sh

.PHONY: clean
clean:  ## remove everything that was made, the environment included
	@rm -rf build dist $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis
