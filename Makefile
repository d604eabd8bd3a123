# `make demo` and `make test` do everything on a machine with Python 3.10 to 3.13, git and make.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo gallery report test test-all lint llvm schema clean

demo: $(READY) ## publish two cloths, render them, and say where the pictures are
	$(BIN)/python examples/demo.py out/demo

gallery: $(READY) ## render every example scene in a cloth that suits it, ten minutes
	$(BIN)/python examples/gallery.py out/gallery

report: $(READY) ## judge three cloths and write the page of each, a minute or two
	$(BIN)/python examples/report.py out/report

test: $(READY) ## the fast tests
	$(BIN)/python -m pytest -q -m "not slow"

test-all: $(READY) ## all tests, a quarter of an hour
	$(BIN)/python -m pytest -q

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python scripts/generate_schema.py --check

llvm: ## unpack the libLLVM that Mitsuba needs into the virtual environment
	sh scripts/fetch_llvm.sh $(VENV)/lib/weaveusd-llvm

schema: $(READY) ## write the schema anew from weaveusd/contract.py
	$(BIN)/python scripts/generate_schema.py

$(READY): pyproject.toml scripts/fetch_llvm.sh
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 13))' || \
		{ echo "weaveusd needs Python 3.10 to 3.13; say which: make PYTHON=python3.11"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV) || \
		{ rm -rf $(VENV); echo "no virtual environment: apt-get install python3-venv"; exit 1; }
	@echo "Installing weaveusd and what it needs into $(VENV), a few minutes at most …"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	sh scripts/fetch_llvm.sh $(VENV)/lib/weaveusd-llvm
	@touch $@

clean:
	rm -rf $(VENV) out
