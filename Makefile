# Two commands for a start: `make run` flies, `make test` tests. Both set up .venv by themselves.
PYTHON ?= python3
BIN := .venv/bin
JOBS ?= 2

.PHONY: run test test-slow lint bench images clean

run: .venv/installed
	@$(BIN)/drone-cli run first_flight --speed 2
	@echo
	@echo "Try next:"
	@echo "  source $(BIN)/activate            (fish: source $(BIN)/activate.fish)"
	@echo "  drone-cli run beacon_route --speed 4"
	@echo "  drone-cli run first_flight -p side=8m -p speed=3m/s"
	@echo "  drone-cli missions survey_square"

test: .venv/dev
	$(BIN)/python -m pytest -n $(JOBS)

test-slow: .venv/dev
	$(BIN)/python -m pytest -n $(JOBS) -m slow

lint: .venv/dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: .venv/dev
	$(BIN)/python -m bench

.venv/installed: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or newer is needed; name one: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)"; exit 1; }
	@echo "Setting up .venv (once, about a minute) …"
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

.venv/dev: .venv/installed
	@echo "Adding the tools of development …"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

images: .venv/dev
	$(BIN)/python -m docs.draw_images
	$(BIN)/python -m docs.draw_architecture

clean:
	rm -rf .venv
