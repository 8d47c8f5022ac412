# The four commands a newcomer types. Each does its own set-up.
#   make demo    bake and relight the built-in scene; open demo/report.html
#   make test    every test, formatting and lints
#   make bench   every table of docs/results, minutes to hours
#   make lint    formatting and lints alone
# For the Python package besides: make python, make sdist, make torch; for the page of `ylm view`: make web, make viewer.

CARGO ?= cargo
PYTHON ?= python3
VENV := .venv
PYTHON_VENV := python/.venv

TORCH_VENV := python/.venv-torch
# Where torch's wheels for CPUs are; those of PyPI are ten times as large.
TORCH_INDEX ?= https://download.pytorch.org/whl/cpu

.PHONY: demo test bench lint tables python sdist torch web viewer browser

demo:
	$(CARGO) run --release --locked -p ylm-cli -- demo --out demo

test: lint tables $(PYTHON_VENV)/ready web/node_modules/ready browser
	$(CARGO) test --locked --workspace
	$(TEST_PYTHON)
	$(TEST_VIEWER)

bench:
	$(CARGO) build --release --locked -p ylm-bench
	for table in $$(target/release/ylm-bench --list); do \
		target/release/ylm-bench $$table || exit 1; \
	done

# The Python package's tests alone. Its extension is the workspace's, from the profile of the other tests.
python: $(PYTHON_VENV)/ready
	$(BUILD_EXTENSION)
	$(TEST_PYTHON)

# The Python package as a source distribution, unpacked and installed elsewhere: what it takes is in it, the Rust crates too.
sdist: $(PYTHON_VENV)/ready
	rm -rf target/sdist && mkdir -p target/sdist
	$(PYTHON_VENV)/bin/python -m pip install --quiet build
	$(PYTHON_VENV)/bin/python -m build --sdist --outdir target/sdist python
	cd target/sdist && tar xzf ylm-*.tar.gz && rm ylm-*.tar.gz && mv ylm-* source && $(PYTHON) -m venv venv
	CARGO_TARGET_DIR=$(CURDIR)/target/sdist/built target/sdist/venv/bin/pip install --quiet target/sdist/source
	cd target/sdist && venv/bin/python -c "import ylm; print(ylm.__file__, ylm.bake(ylm.Mesh.demo(), bands=2, rays=16))"

# Gradients through torch, which is too large for every run: a wheel for CPUs, or where there is none Debian's package.
torch: $(TORCH_VENV)/ready
	$(BUILD_EXTENSION)
	$(COPY_EXTENSION)
	cd python && .venv-torch/bin/python -m pytest tests/test_torch.py

$(TORCH_VENV)/ready:
	rm -rf $(@D)
	$(PYTHON) -m venv $(@D)
	$(@D)/bin/pip install --quiet --index-url $(TORCH_INDEX) --retries 0 torch || { \
		rm -rf $(@D); \
		apt-get update -qq && apt-get install -y -qq --no-install-recommends python3-torch && \
		/usr/bin/python3 -m venv --system-site-packages $(@D); \
	}
	$(@D)/bin/pip install --quiet 'numpy>=1.22' pytest
	touch $@

# The page of `ylm view`, which the binary embeds, built anew from web/ and crate ylm-wasm.
web: $(VENV)/ready
	$(VENV)/bin/python tools/build_page.py

# The page's own tests, in a browser without a screen.
viewer: web/node_modules/ready browser
	$(CARGO) build --locked -p ylm-cli
	$(TEST_VIEWER)

web/node_modules/ready: web/package-lock.json
	cd web && npm ci --no-audit --no-fund --silent
	touch $@

# What runs shaders and pages in tests; YLM_CHROMIUM names another.
browser:
	@command -v $${YLM_CHROMIUM:-chromium} >/dev/null || { apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium; }

lint:
	$(CARGO) fmt --all --check
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings

# Generated tables and kernels are what their generators write.
tables: $(VENV)/ready
	for generator in tools/*.py; do $(VENV)/bin/python $$generator --check || exit 1; done

$(VENV)/ready: tools/requirements.txt
$(PYTHON_VENV)/ready: python/tests/requirements.txt
$(VENV)/ready $(PYTHON_VENV)/ready:
	rm -rf $(@D)
	$(PYTHON) -m venv $(@D) || { apt-get update -qq && apt-get install -y -qq python3-venv && $(PYTHON) -m venv $(@D); }
	$(@D)/bin/pip install --quiet --requirement $<
	touch $@

# The extension that cargo built stands beside the Python files; types are checked, then everything runs. `cargo test` leaves it in
# deps, `cargo build` beside it as well: the newest is the one.
BUILT = $${CARGO_TARGET_DIR:-target}/debug
BUILD_EXTENSION = $(CARGO) build --locked -p ylm-python -p ylm-cli --lib --bins --examples
define COPY_EXTENSION
	cp $$(ls -t $(BUILT)/lib_native.so $(BUILT)/deps/lib_native.so $(BUILT)/lib_native.dylib $(BUILT)/deps/lib_native.dylib \
		2>/dev/null | head -1) python/ylm/_native.abi3.so
endef
define TEST_PYTHON
	$(COPY_EXTENSION)
	cd python && .venv/bin/mypy && .venv/bin/python -m mypy.stubtest ylm._native
	cd python && .venv/bin/basedpyright --pythonpath .venv/bin/python --level error
	cd python && .venv/bin/python -m pytest
endef

define TEST_VIEWER
	cd web && npx tsc --noEmit --project tests
	ylm=$$(realpath $${CARGO_TARGET_DIR:-target})/debug/ylm && cd web && YLM=$$ylm npx vitest run
endef
