# make demo, make test and make check set up a virtual environment of their own: python3, make and Rust's cargo are
# all they need.

PYTHON ?= python3
VENV := .venv
# Windows has Scripts where others have bin.
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
DEMO := out/chess.png
CARGO ?= cargo
CRATE := --manifest-path tracer/Cargo.toml
# The same random cases each time, so that no test fails by chance: without it, cargo test searches.
export PROPTEST_RNG_SEED ?= 1
# What the compiled module is made of.
NATIVE := $(wildcard tracer/Cargo.* tracer/*/Cargo.toml tracer/src/*.rs tracer/src/*/*.rs tracer/src/*/*/*.rs) \
	$(wildcard tracer/*/src/*.rs tracer/*/src/*/*.rs)

.PHONY: demo rust test integration dev soak check lint format docs site bench clean help

help:            ## show this list
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/'

demo: $(VENV)/run.stamp ## render a game of chess to out/chess.png
	@mkdir -p $(dir $(DEMO))
	$(BIN)/rtcli render scenes/chess.yaml -o $(DEMO)
	@echo "The picture is in $(abspath $(DEMO))"

rust:            ## compile the tests of Rust
	$(need_cargo)
	$(CARGO) test $(CRATE) --workspace --locked --quiet --no-run

test: $(VENV)/dev.stamp ## run the tests of Rust and Python: some minutes
	$(CARGO) test $(CRATE) --workspace --locked --quiet
	$(BIN)/python -m pytest -n auto -m "not integration"

# By file, since the tests of one share a build, a cluster, a browser or a server.
integration: $(VENV)/oracle.stamp ## run the tests with other people's programs, and those that take long
	$(BIN)/python -m pytest -n auto --dist loadfile -m integration

# The release stamps go, so that whatever tests or measures for good compiles a release again.
dev: $(VENV)/tools.stamp ## recompile the native tracer in seconds, for working on it
	@rm -f $(VENV)/run.stamp $(VENV)/dev.stamp
	VIRTUAL_ENV=$(abspath $(VENV)) $(BIN)/maturin develop --profile dev-fast --skip-install --quiet

soak: $(VENV)/dev.stamp ## look for scenes that the tracers paint differently: make soak SOAK="--minutes 60"
	$(BIN)/python tests/support/soak.py $(SOAK)

check: lint test ## lint, and run the tests

lint: $(VENV)/tools.stamp ## format, lint, types, import contracts, in Rust and Python
	$(CARGO) fmt $(CRATE) --all --check
	$(CARGO) clippy $(CRATE) --workspace --all-targets --locked -- --deny warnings
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(VENV)/tools.stamp ## format the code
	$(CARGO) fmt $(CRATE) --all
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

docs: $(VENV)/dev.stamp ## regenerate schema, tables and help texts in pages, tutorial, gallery
	$(BIN)/python tools/refresh.py

site: $(VENV)/tools.stamp ## build the documentation to site/index.html; a warning is an error
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --nitpicky --quiet --fresh-env docs site
	@echo "The first page is $(abspath site/index.html)"

bench: $(VENV)/run.stamp ## compare the speed with that of others: see benchmarks/README.md
	$(BIN)/python benchmarks/run.py $(BENCH)

clean:           ## remove what was made
	rm -rf $(VENV) out site build dist tracer/target rtcli/gallery rtcli/tracer/_native.abi3.so rtcli/tracer/_native.pyd

# Said here, because pip says it at length.
define need_cargo
@command -v $(CARGO) >/dev/null || \
	{ echo "rtcli is compiled with Rust 1.88 or newer, and there is no $(CARGO) here: see https://rustup.rs" >&2; exit 1; }
endef

# A stamp is newer than what it was installed from.
$(VENV)/python.stamp:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' \
		|| { echo "rtcli needs Python 3.10 or newer; name one: make PYTHON=python3.12 ..." >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/run.stamp: pyproject.toml $(NATIVE) | $(VENV)/python.stamp
	$(need_cargo)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/dev.stamp: pyproject.toml $(NATIVE) | $(VENV)/python.stamp
	$(need_cargo)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@ $(VENV)/run.stamp

# The development tools, which a change in Rust does not make out of date: linting need not wait for a release build.
$(VENV)/tools.stamp: pyproject.toml | $(VENV)/python.stamp
	$(MAKE) $(VENV)/dev.stamp
	@touch $@

# Peers to compare with, heavy and not there for every platform: their tests skip, and say so, where they are missing.
$(VENV)/oracle.stamp: $(VENV)/dev.stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[oracle]' \
		|| echo "Mitsuba cannot be installed here: the test that needs it will be skipped"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[readers]' \
		|| echo "Readers of data sets cannot be installed here: the tests that need them will be skipped"
	@touch $@
