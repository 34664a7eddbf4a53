.PHONY: all install derive derive-check reproduce test verify lint notebooks bench clean

PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
export PYTHONHASHSEED = 0

all: derive reproduce

$(READY): pyproject.toml
	$(PYTHON) -m venv .venv && $(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]' && $(BIN)/pyright --version && touch $(READY)

install: $(READY)

derive: $(READY)
	$(BIN)/python -m substep_derive

derive-check: $(READY)
	$(BIN)/python -m substep_derive --check

reproduce: $(READY)
	$(BIN)/substep reproduce

lint: $(READY)
	$(BIN)/lint-imports --no-logo
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	$(BIN)/pyright

test: lint
	$(BIN)/pytest

verify: $(READY)
	SUBSTEP_VERIFY=1 $(BIN)/pytest

notebooks: $(READY)
	$(BIN)/jupytext --to ipynb --execute notebooks/*.py

bench: $(READY)
	$(BIN)/python -m benchmarks

clean:
	rm -rf .venv results
