.PHONY: all install derive derive-check reproduce test test-browser verify lint notebooks docs bench audits vendor clean

PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
TOOLS := .venv/.tools
SITE := .venv/.site
WHEELS := .venv/wheelhouse
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
export PYTHONHASHSEED = 0

all: derive reproduce

# what `make` needs; SciPy's solvers are drawn beside the schemes
$(READY): pyproject.toml extras/pyproject.toml
	@echo "installing: the package, its extras and what they import, into .venv"
	@$(PYTHON) -m venv .venv && $(PIP) install -e . -e extras && touch $(READY)

# what tests, lint, notebooks and benchmarks need besides
$(TOOLS): $(READY)
	@echo "installing: the tools of the tests, into .venv"
	@$(PIP) install -e '.[dev]' && $(BIN)/pyright --version && touch $(TOOLS)

# what builds the site, and executes the notebooks for it
$(SITE): $(READY)
	@echo "installing: Sphinx, into .venv"
	@$(PIP) install -e '.[docs]' && touch $(SITE)

# what all of these install, for the tests that install them again without a network
$(WHEELS): $(READY)
	@echo "downloading: all packages once more, into .venv/wheelhouse"
	@$(PIP) download --dest $(WHEELS) '.[dev,docs]' ./extras hatchling editables pip setuptools && touch $(WHEELS)

install: $(READY)

derive: $(READY)
	$(BIN)/python -m substep_derive && $(BIN)/python -m substep_explorer.derive && $(BIN)/python -m substep_thesis.derive

derive-check: $(READY)
	$(BIN)/python -m substep_derive --check
	$(BIN)/python -m substep_explorer.derive --check
	$(BIN)/python -m substep_thesis.derive --check

reproduce: $(READY)
	$(BIN)/substep reproduce

# room for what pyright makes and drops, which saves a fifth of its time; only where there is a node that takes the option
YOUNG := --max-semi-space-size=64
# in the gate the types of what is installed, in `make lint` and `make verify` those of tests, benchmarks and the site, too
test: TYPED := src derive extras
lint: $(TOOLS)
	$(BIN)/lint-imports --no-logo
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	@echo "$(BIN)/pyright $(TYPED)" && \
	  NODE_OPTIONS="$$(NODE_OPTIONS=$(YOUNG) node -e 0 2>/dev/null && echo $(YOUNG))" $(BIN)/pyright $(TYPED)

# one thread of linear algebra for each of pytest's workers: others would spin while they wait for the cores of these
test verify: export OPENBLAS_NUM_THREADS = 1

test: lint
	$(BIN)/pytest

# the explorer in a real browser; needs node, npm and Chromium (on Debian: apt-get install nodejs npm chromium)
test-browser: $(TOOLS)
	@for needed in node npm "chromium chromium-browser google-chrome"; do \
	  for program in $$needed; do command -v $$program >/dev/null && continue 2; done; \
	  echo "expected one of: $$needed, found none; on Debian: apt-get install nodejs npm chromium" >&2; exit 1; \
	done
	npm install --silent --no-save --prefix .browser playwright-core@1.65.1
	SUBSTEP_BROWSER=.browser $(BIN)/pytest -n 0 -rs tests/test_explorer_browser.py

# Chart.js as npm has it, with its licence and its sha256
vendor: $(READY)
	$(BIN)/python -m substep_explorer.vendor

verify: lint $(SITE) $(WHEELS)
	SUBSTEP_VERIFY=1 $(BIN)/pytest -n auto

notebooks: $(TOOLS)
	$(BIN)/jupytext --to ipynb --execute notebooks/*.py

# the site, into results/site/index.html; a warning is an error
docs: $(SITE)
	$(BIN)/sphinx-build -W --keep-going --quiet -c docs/site docs results/site

# BENCH=--quick takes some minutes
bench: $(TOOLS)
	$(BIN)/python -m benchmarks $(BENCH)

# installs each program into an environment of its own
audits: $(TOOLS)
	$(BIN)/python -m audits audits/.environments

clean:
	rm -rf .venv .browser results docs/generated
