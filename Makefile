# Two commands for a start: `make run` flies, `make test` tests. Both set up .venv by themselves;
# `make VENV=.venv-3.13 PYTHON=python3.13 test` does it beside that for another interpreter.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
JOBS ?= 2

.PHONY: run test test-slow lint bench images clean

run: $(VENV)/installed
	@$(BIN)/drone-cli run first_flight --speed 2
	@echo
	@echo "Try next:"
	@echo "  source $(BIN)/activate            (fish: source $(BIN)/activate.fish)"
	@echo "  drone-cli run beacon_route --speed 4"
	@echo "  drone-cli run first_flight -p side=8m -p speed=3m/s"
	@echo "  drone-cli missions survey_square"

test: $(VENV)/dev
	$(BIN)/python -m pytest -n $(JOBS)

test-slow: $(VENV)/dev
	$(BIN)/python -m pytest -n $(JOBS) -m slow

lint: $(VENV)/dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/dev
	$(BIN)/python -m bench

$(VENV)/installed: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or newer is needed; name one: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)"; exit 1; }
	@echo "Setting up $(VENV) (once, about a minute) …"
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

$(VENV)/dev: $(VENV)/installed
	@echo "Adding the tools of development …"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

images: $(VENV)/dev
	$(BIN)/python -m docs.draw_images
	$(BIN)/python -m docs.draw_architecture

clean:
	rm -rf $(VENV)
