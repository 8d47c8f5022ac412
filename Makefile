# The four commands a newcomer types. Each does its own set-up.
#   make demo    bake and relight the built-in scene; open demo/report.html
#   make test    every test, formatting and lints
#   make bench   every table of docs/results, minutes to hours
#   make lint    formatting and lints alone

CARGO ?= cargo
PYTHON ?= python3
VENV := .venv

.PHONY: demo test bench lint tables

demo:
	$(CARGO) run --release --locked -p ylm-cli -- demo --out demo

test: lint tables
	$(CARGO) test --locked --workspace

bench:
	$(CARGO) build --release --locked -p ylm-bench
	for table in $$(target/release/ylm-bench --list); do \
		target/release/ylm-bench $$table || exit 1; \
	done

lint:
	$(CARGO) fmt --all --check
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings

# Generated tables and kernels are what their generators write.
tables: $(VENV)/ready
	for generator in tools/*.py; do $(VENV)/bin/python $$generator --check || exit 1; done

$(VENV)/ready: tools/requirements.txt
	rm -rf $(VENV)
	$(PYTHON) -m venv $(VENV) || { apt-get update -qq && apt-get install -y -qq python3-venv && $(PYTHON) -m venv $(VENV); }
	$(VENV)/bin/pip install --quiet --requirement tools/requirements.txt
	touch $@
