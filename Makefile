# Everything runs in a virtual environment of its own, made on first use.
PYTHON ?= python3
FILE ?= examples/refuse-collector-6x2.yaml
VENV := .venv
BIN := $(if $(filter Windows_NT,$(OS)),$(VENV)/Scripts,$(VENV)/bin)
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
PAGE := src/cardan/web/static/index.html
# Two cores; the slowest are told, for what grows unseen ends in a time limit.
PYTEST = $(BIN)/python -m pytest -q -n 2 --dist worksteal --durations 15 --durations-min 5
INSTALL = $(PIP) install --constraint constraints.txt --editable

# Matrices are small: BLAS threads of its own only get in each other's way.
export OPENBLAS_NUM_THREADS ?= 1
# Compiled once, for each of the processes that tests start; an image that forbids it is not ours.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: check serve test lowest texts bracket long lint docs oracle office browser front pictures slow mutants bench clean

check: $(VENV)/cardan       ## check FILE, the main job
	@$(BIN)/cardan check $(FILE); code=$$?; [ $$code -le 1 ] || exit $$code

serve: $(VENV)/cardan-web $(PAGE)   ## the workbench, in the browser
	@$(BIN)/cardan serve $(FILE)

test: $(VENV)/cardan-test   ## the whole test suite
	$(PYTEST)

texts: $(VENV)/cardan-test  ## what has no translation yet, by language
	$(BIN)/python -m pytest -q tests/unit/render/test_translations.py tests/unit/documents/test_approval_report.py -k "texts or translated or catalogue or language"

lint: $(VENV)/cardan-lint $(VENV)/cardan-test   ## format, lint, types, layers of imports
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports

docs: $(VENV)/cardan-docs   ## the documentation site, into site/
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

oracle: $(VENV)/cardan-oracles $(VENV)/cardan-test  ## results against independent multibody engines
	$(PYTEST) -m "oracle and not bracket and not long" tests/verify

# Two of them at once: idle threads of a solver spin, and would take each other's core.
bracket long: export NGS_NUM_THREADS ?= 1

bracket: $(VENV)/cardan-bracket $(VENV)/cardan-test  ## the bracket's tests; with CalculiX, where it is installed, beside it
	$(PYTEST) -m "bracket and not oracle and not browser and not long"
	@if command -v ccx >/dev/null; then $(PYTEST) --dist loadscope -m "bracket and oracle and not long" tests/verify; \
	else echo "CalculiX is not installed (apt-get install calculix-ccx): not compared with it"; fi

long: $(VENV)/cardan-bracket $(VENV)/cardan-oracles $(VENV)/cardan-test  ## what takes hours: CalculiX's contact, hundreds of drives; by hand
	$(PYTEST) --dist loadscope -m "long"

office: $(VENV)/cardan-test  ## workbooks recomputed by LibreOffice
	$(BIN)/python -m pytest -q -m "office and not long" tests/office

browser: $(VENV)/cardan-browser $(VENV)/cardan-test node_modules/axe-core $(PAGE)  ## pages read in Chromium
	$(PYTEST) -m "browser and not long" tests/browser

pictures: $(VENV)/cardan-browser $(VENV)/cardan-test $(PAGE)   ## every picture in docs and the live page, made anew
	$(BIN)/python docs/pictures.py
	$(BIN)/python docs/reports/make.py
	$(BIN)/python docs/case.py

front: web/node_modules   ## the workbench's page: types and unit tests
	cd web && npm run --silent types && npm run --silent test

slow: $(VENV)/cardan-test  ## what takes seconds or minutes: recordings made to mislead, searches, bombs
	$(PYTEST) -m "slow and not bracket and not oracle and not long"

lowest: $(VENV)-lowest/made  ## unit tests with the lowest versions of libraries that are allowed
	$(VENV)-lowest/bin/python -m pytest -q -n 2 --dist worksteal tests/unit

MODULE ?= physics/loads/statics.py
mutants: $(VENV)/cardan-mutants $(VENV)/cardan-test  ## mutation testing of MODULE: lists mutants that survive
	$(BIN)/python tests/mutants $(MODULE)

bench: $(VENV)/cardan-bench $(VENV)/cardan-oracles $(VENV)-peers/made  ## performance, as ratios in one run
	CARDAN_PEERS=$(CURDIR)/$(VENV)-peers/bin/python $(BIN)/python -m benchmarks

$(VENV)/cardan: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) .
	@touch $@

$(VENV)/cardan-%: $(VENV)/cardan
	$(INSTALL) .[$*]
	@touch $@

$(PAGE): $(wildcard web/src/*) web/types.mjs src/cardan/web/messages.schema.json web/index.html web/vite.config.ts web/node_modules
	cd web && npm run --silent build -- --logLevel error
	@touch $@

web/node_modules: web/package.json web/package-lock.json
	@command -v npm >/dev/null || { echo "the workbench's page needs Node 20.19 or newer with npm to be built"; exit 1; }
	cd web && npm ci --silent
	@touch $@

# What we are measured against has needs of its own, which are not ours.
$(VENV)-peers/made:
	$(PYTHON) -m venv $(VENV)-peers
	for peer in fatpack py-fatigue rfcnt rainflow pylife; do \
	$(VENV)-peers/bin/python -m pip --quiet --disable-pip-version-check install $$peer || true; done
	@touch $@

$(VENV)-lowest/made: pyproject.toml tests/lowest_versions.py
	$(PYTHON) -m venv $(VENV)-lowest
	$(VENV)-lowest/bin/python tests/lowest_versions.py > $(VENV)-lowest/constraints.txt
	$(VENV)-lowest/bin/python -m pip --quiet --disable-pip-version-check install --only-binary :all: \
	  --constraint $(VENV)-lowest/constraints.txt --editable .[test]
	@touch $@

node_modules/axe-core:
	npm install --silent --no-save --no-package-lock axe-core@4.14.1

clean:
	rm -rf $(VENV) node_modules web/node_modules web/made src/cardan/web/static site build dist \
	  $(VENV)-peers $(VENV)-lowest
