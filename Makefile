# Every target builds .venv by itself on first use.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
# One BLAS thread each: the work is spread over the service's own pool.
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1
# Python keeps what it has compiled, though the environment may forbid it: tests start hundreds of processes.
export PYTHONDONTWRITEBYTECODE :=
COVERAGE := build/coverage
# Per cent of the lines of all packages that the tests in their folders run, but for voa_core, whose lines and branches
# are all run, without compiling. Never lower it.
FLOOR := 95

.PHONY: help setup demo test bench load chaos lint docs rules lock image clean
help:  ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 10

setup: $(STAMP)  ## build .venv from requirements.lock, with every extra

$(STAMP): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or newer is needed; name one with: make PYTHON=/path/to/python3.11"; exit 1; }
	@$(PYTHON) -m venv $(VENV) || \
	  { echo "python3 has no venv module; on Debian: apt-get install python3-venv"; exit 1; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@echo "compiling the kernels (once)"
	@$(BIN)/python -m voa_core.warmup
	@touch $@

demo: setup  ## a simulated lidar robot helps an arm to grasp; prints the story, leaves a page in build/demo
	@$(BIN)/voa demo --out build/demo

test: setup system-packages  ## all tests; PostgreSQL and Chromium are installed by themselves where that is allowed
	rm -rf $(COVERAGE)
	$(BIN)/python -m coverage run --data-file=$(COVERAGE)/all -m pytest -n 2 --dist worksteal tests
	$(BIN)/python -m coverage report --data-file=$(COVERAGE)/all --omit='voa_core/*' --skip-covered --fail-under=$(FLOOR)
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m coverage run --branch --data-file=$(COVERAGE)/core -m pytest -q -n 2 --dist worksteal -m 'not statistics' tests/voa_core
	$(BIN)/python -m coverage report --data-file=$(COVERAGE)/core --include='voa_core/*' --show-missing --skip-covered --fail-under=100

.PHONY: system-packages
system-packages:  # PostgreSQL, a browser, a balancer, a compiler for faults of disks, a reader of units, a clock that tests can set
	@missing=""; \
	command -v initdb >/dev/null || ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || missing="$$missing postgresql"; \
	command -v chromium >/dev/null || missing="$$missing chromium"; \
	command -v cc >/dev/null || missing="$$missing gcc libc6-dev"; \
	PATH="$$PATH:/usr/sbin" command -v haproxy >/dev/null || missing="$$missing haproxy"; \
	command -v systemd-analyze >/dev/null || missing="$$missing systemd"; \
	ls /usr/lib/*/faketime/libfaketimeMT.so.1 >/dev/null 2>&1 || missing="$$missing faketime"; \
	if [ -z "$$missing" ]; then exit 0; fi; \
	if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	  echo "installing for the tests:$$missing" && apt-get -qq update && \
	  DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends $$missing >/dev/null; \
	else \
	  echo "the tests need system packages; on Debian: apt-get install$$missing"; exit 1; \
	fi

lint: setup  ## ruff and mypy, strict
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy voa_core service clients assets deploy tests

docs: setup  ## the documentation, into build/docs/index.html
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet -f deploy/mkdocs.yml

rules:  ## Prometheus's own checks of the alerts, and their tests
	@deploy/monitoring/promtool.sh check rules rules.yml
	@deploy/monitoring/promtool.sh test rules rules.test.yml

load: setup system-packages  ## sessions at 5 Hz that a service carries, as tables and in build/load.json
	@$(BIN)/python -m tests.load --out build/load.json

# Answered writes under kills, faults and cuts, on each database; share of the bytes of a history with a flipped bit; words
# of the names of attacks.
WRITES ?= 100000
BITS ?= 1
ONLY ?=

chaos: setup system-packages  ## attacks on a running service, each with its figure before and now
	@CHAOS_WRITES=$(WRITES) CHAOS_BITS=$(BITS) $(BIN)/python -m tests.chaos $(ONLY)
	@$(BIN)/python -m tests.simulation --planted
	@$(BIN)/python -m tests.simulation --writes $(WRITES)

bench: setup  ## the ratios beside their gates, median of three whole runs, also in build/bench.json; fails where a gate is missed
	@$(BIN)/python -m tests.benchmarks --runs 3 --out build/bench.json

UV_LOCK = $(BIN)/uv pip compile --quiet --universal --generate-hashes --no-emit-index-url --python-version 3.11 \
  --custom-compile-command "make lock"
IMAGE_LOCK = $(UV_LOCK) --no-annotate -c requirements.lock

lock: setup  ## requirements.lock from pyproject.toml, and from that one what goes into the images
	$(UV_LOCK) --all-extras -o requirements.lock pyproject.toml
	$(IMAGE_LOCK) --override deploy/requirements-unused.txt --extra core --extra zenoh -o deploy/requirements-core.lock pyproject.toml
	$(IMAGE_LOCK) --override deploy/requirements-unused.txt --extra service --extra postgres -o deploy/requirements-service.lock pyproject.toml
	$(IMAGE_LOCK) --extra fleet -o deploy/requirements-fleet.lock pyproject.toml
	$(IMAGE_LOCK) --extra console -o deploy/requirements-console.lock pyproject.toml
	echo hatchling | $(IMAGE_LOCK) -o deploy/requirements-build.lock -

image: setup  ## build the container images without Docker, run them hardened, try them out
	@deploy/image.sh

clean:  ## remove what the targets built
	rm -rf $(VENV) build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
