# What a newcomer types. Each target sets the machine up first where that is needed; all the
# work is cargo's. Variables: CARGO (default: cargo), OUT (where pictures go, default: out).

CARGO ?= cargo
OUT ?= out
FUZZ_SECONDS ?= 60
SOAK_SECONDS ?= 1800
ACCURACY_SEEDS ?= 400
STUDY_BUDGET ?= 15m
PYTHON ?= python3
PREFIX ?= /usr/local
PROFILE ?= release
FUZZ_TARGETS ?= scene_toml obj mtl ply mitsuba_xml gltf pbrt image state

.PHONY: help setup demo test mutants nightly install header albedo-tables battery bench studies against-mitsuba instructions check fuzz accuracy slurm soak clean
.DEFAULT_GOAL := help

help: ## Lists these targets.
	@sed -n 's/^\([a-z-]*\):.*## /  make \1\t/p' Makefile | expand -t 24

setup: ## Finds or fetches Embree 4 and what a build needs.
	@scripts/setup.sh

# `.exr` is the picture itself, `.png` is for the eye. Samples a pixel are chosen so that both
# renders together take less than two minutes on two cores.
demo: setup ## Renders the scenes cornell-box and suzanne-room to out/.
	@mkdir -p $(OUT)
	$(CARGO) build --release
	$(CARGO) run --release --quiet -- render scenes/cornell-box/cornell-box.toml \
		--spp 128 -o $(OUT)/cornell-box.exr -o $(OUT)/cornell-box.png
	$(CARGO) run --release --quiet -- render scenes/suzanne-room/suzanne-room.toml \
		--spp 80 -o $(OUT)/suzanne-room.exr -o $(OUT)/suzanne-room.png

# Optimised by the profile `dev` of Cargo.toml, as most tests are statistics over many samples.
test: setup ## Runs all tests.
	$(CARGO) test --workspace
	@scripts/not-tested.sh

mutants: setup ## Makes each planted bug live and shows that a test finds it.
	@scripts/mutants.sh

# What .ci/run leaves out because it is slow and rarely fails.
nightly: export ETENDUE_NIGHTLY = 1
nightly: test mutants check ## Runs all tests, all planted bugs and the gates.
	if command -v sbatch >/dev/null; then $(MAKE) slurm; fi
	CARGO_TARGET_DIR=target/nightly $(MAKE) install DESTDIR= PREFIX=$(CURDIR)/target/nightly/prefix

# Where cargo puts what it builds.
BUILT = $(or $(CARGO_TARGET_DIR),target)/$(if $(filter dev test,$(PROFILE)),debug,$(PROFILE))
VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)
# What pkg-config says has to be true from any folder.
PLACE = $(abspath $(PREFIX))
INTO = $(DESTDIR)$(PLACE)

# Both are built of one compiled renderer. An Embree of the private copy is installed along, for them to find: the folder that
# they were built in may go.
install: setup ## Builds the command and the C library and installs them under PREFIX (default: /usr/local).
	$(CARGO) build --profile $(PROFILE) -p etendue-cli -p libetendue $(CARGO_FLAGS)
	install -d $(INTO)/bin $(INTO)/include $(INTO)/lib/pkgconfig
	install -m 755 $(BUILT)/etendue $(INTO)/bin/etendue
	install -m 644 capi/include/etendue.h $(INTO)/include/etendue.h
	install -m 755 $(BUILT)/libetendue.so $(INTO)/lib/libetendue.so.$(VERSION)
	ln -sf libetendue.so.$(VERSION) $(INTO)/lib/libetendue.so.$(firstword $(subst ., ,$(VERSION)))
	ln -sf libetendue.so.$(firstword $(subst ., ,$(VERSION))) $(INTO)/lib/libetendue.so
	install -m 644 $(BUILT)/libetendue.a $(INTO)/lib/libetendue.a
	if ldd $(BUILT)/libetendue.so | grep --quiet --fixed-strings '=> $(CURDIR)/.embree/'; then \
		install -d $(INTO)/lib/etendue && cp -P .embree/lib/*.so* $(INTO)/lib/etendue/; \
	fi
	sed 's|@PREFIX@|$(PLACE)|; s|@VERSION@|$(VERSION)|' capi/etendue.pc.in > $(INTO)/lib/pkgconfig/etendue.pc

# Needs `cargo install cbindgen`. C has no heading for what Rust calls safety: it is about pointers.
header: ## Makes the C library's header anew, capi/include/etendue.h.
	cd capi && cbindgen --quiet --config cbindgen.toml --output include/etendue.h.new .
	sed -i 's|^// # Safety$$|// Pointers:|' capi/include/etendue.h.new
	mv capi/include/etendue.h.new capi/include/etendue.h

albedo-tables: setup ## Computes src/bsdf/albedo/tables.bin anew, after a change of the GGX model.
	ALBEDO_TABLES=$(CURDIR)/src/bsdf/albedo/tables.bin $(CARGO) test -p etendue --lib albedo::quadrature::the_tables

# Every run has other random numbers; its report says which.
battery: setup ## Runs the long battery of hard cases with exact answers; reports go to out/battery/.
	$(CARGO) build --release
	$(CARGO) run --release --quiet -- battery --full -o $(OUT)/battery

bench: setup ## Runs the benchmarks of single parts; backends are compared by `etendue bench`.
	$(CARGO) bench

# Nothing else should run on the machine meanwhile.
studies: setup ## Makes docs/study.md anew: studies of five scenes, STUDY_BUDGET each (default: 15m).
	$(CARGO) build --release
	scripts/studies.sh target/release/etendue $(STUDY_BUDGET)

# Needs a Python with mitsuba and numpy: PYTHON (default: python3).
against-mitsuba: setup ## Makes docs/compare.md anew: error against time of Etendue and of Mitsuba 3.
	$(CARGO) build --release
	$(PYTHON) scripts/error-against-time.py

instructions: setup ## Counts instructions a sample, of the chosen kernel and of the one with everything.
	$(CARGO) build --release
	@scripts/instructions.sh target/release/etendue --reuse off
	@scripts/instructions.sh target/release/etendue --reuse off --kernel everything

# All of the workspace, so that macros and build scripts are those of the tests; the last lint is of the library alone, without
# `internals`.
check: setup ## Runs the gates: format, lints, documentation, without a warning.
	$(CARGO) fmt --all --check
	$(CARGO) clippy --workspace --all-targets -- -D warnings
	$(CARGO) clippy --workspace --test accuracy --test soak -- -D warnings
	$(CARGO) clippy --workspace --all-targets --no-default-features -- -D warnings
	$(CARGO) clippy -p libetendue --no-default-features -- -D warnings
	RUSTDOCFLAGS='-D warnings' $(CARGO) doc --workspace --no-deps

# Needs `rustup toolchain install nightly` and `cargo install cargo-fuzz`. What is new goes to
# fuzz/found/, what breaks something to fuzz/artifacts/; its smallest form belongs in fuzz/corpus/.
# Bounds: 2 GB of memory, 10 s for one input.
fuzz: ## Feeds damaged scenes, models, pictures and state files to the loaders: FUZZ_SECONDS each (default: 60).
	@for target in $(FUZZ_TARGETS); do \
		mkdir -p fuzz/found/$$target && \
		$(CARGO) +nightly fuzz run --release $$target fuzz/found/$$target fuzz/corpus/$$target -- \
			-dict=fuzz/dictionaries/$$target.dict -max_total_time=$(FUZZ_SECONDS) \
			-timeout=10 -rss_limit_mb=2048 -print_final_stats=1 || exit 1; \
	done

accuracy: setup ## Tests error bars, stated errors and the errors of --error, with up to ACCURACY_SEEDS images each (default: 400).
	ACCURACY_SEEDS=$(ACCURACY_SEEDS) $(CARGO) test -p etendue --test accuracy

# Needs Debian's slurm-wlm and munge, and root.
slurm: setup ## Renders shards through a Slurm of one node on this machine, kills some, and compares bits.
	$(CARGO) build --release
	scripts/slurm/try.sh target/release/etendue

soak: setup ## Renders random scenes on all backends for SOAK_SECONDS (default: 1800).
	SOAK_SECONDS=$(SOAK_SECONDS) $(CARGO) test -p etendue-cli --test soak

clean: ## Removes what was built and rendered; keeps the private Embree.
	$(CARGO) clean
	rm -rf $(OUT)
