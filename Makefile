# `make demo` and `make test` do all the set-up themselves, on a fresh machine, too.
PYTHON ?= $(shell for p in python3.12 python3.11 python3; do \
	$$p -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info < (3, 13))' 2>/dev/null && echo $$p && break; done)
BIN := .venv/bin
# Two processes test at once: each with threads for all cores would wait on the other.
TESTED := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2

.PHONY: demo test test-slow lint bench ranging quality session clean

demo: .venv/ready
	$(BIN)/difflidar demo --out out/demo

test: .venv/ready
	$(TESTED) -m "not slow" $(TESTS)

test-slow: .venv/ready
	$(TESTED) --dist worksteal -m slow $(TESTS)

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

bench: .venv/ready
	$(BIN)/python -m pytest bench -s -o python_files='bench_*.py' -p no:randomly -p no:xdist --benchmark-columns=min,median,max,rounds

ranging: .venv/ready
	OPENBLAS_NUM_THREADS=1 $(BIN)/python bench/ranging.py

quality: .venv/ready
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m fusion.quality $(or $(DIFFLIDAR_DATA),../shared/data) docs/quality.md

session: .venv/ready
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tools/room_session.py recordings/samples/room.rrd

.venv/ready: pyproject.toml constraints.txt tools/system_libraries.sh
	@test -n "$(PYTHON)" || { echo "difflidar needs Python 3.11 or 3.12 with venv; none was found" >&2; exit 2; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[test]"
	tools/system_libraries.sh $(BIN)/python
	touch $@

clean:
	rm -rf .venv out .pytest_cache .hypothesis .ruff_cache
