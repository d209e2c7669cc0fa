# mukca: one Makefile for everything.  `make help` lists the targets.
#
# Sources are found by wildcard: src/*/*.c make the program, tests/unit/test_*.c one cmocka program
# each, tests/*.sh and tests/*/run.sh the script tests of `make check` (MUKCA and BUILD are in their
# environment; they print `ok NAME` or `not ok NAME` lines, and exit 77 when skipped).
# Objects go to $(BUILD); `make BUILD=build/x CFLAGS=...` builds a variant next to the default one;
# `make V=1` prints full commands.

BUILD  ?= build
PREFIX ?= /usr/local
DESTDIR ?=
CC     := $(if $(filter default,$(origin CC)),gcc,$(CC))
CXX    := $(if $(filter default,$(origin CXX)),g++,$(CXX))
PYTHON ?= python3

VERSION := $(shell sed -n 's/.*MUKCA_VERSION "\(.*\)".*/\1/p' include/mukca/version.h)

# ---- sources, objects, products ------------------------------------------------------------------
# modules of the core library, in the order of tests/layers.sh
CORE_MODULES := base math model effect arm fit infer recalibrate capture plan simulate diagnose fleet
CORE_SRC := $(filter-out src/fit/nlopt_adapter%,$(foreach module,$(CORE_MODULES),\
            $(sort $(wildcard src/$(module)/*.c))))
# the part of these for control loops: no stdio, no allocation, no clock, no locale
RT_SRC := $(addprefix src/,$(addsuffix .c,base/cells base/number base/print math/orientation \
          math/rotation math/sincos model/chain model/fk model/fk_jacobian model/gravity model/row_state \
          arm/acceptance arm/corrected arm/corrected_jacobian arm/offsets_parse)) $(sort $(wildcard src/effect/*.c))
REST_SRC := $(sort $(wildcard src/fit/nlopt_adapter*.c $(foreach module,io lcm report record,\
            src/$(module)/*.c src/$(module)/*.cc)))
CLI_SRC  := $(sort $(wildcard src/cli/*.c))
TEST_SRC := $(sort $(wildcard tests/unit/test_*.c))
BENCH_SRC := $(sort $(wildcard tools/bench/bench_*.c))
FUZZ_SRC := $(sort $(wildcard tests/fuzz/fuzz_*.c))
EXAMPLE_SRC := $(sort $(wildcard tools/example_*.c))
HEADERS  := $(sort $(wildcard include/mukca/*.h))
SCRIPTS  := $(sort $(wildcard tests/*.sh tests/*/run.sh))

object = $(patsubst %,$(BUILD)/obj/%.o,$(basename $(1)))
CORE_OBJ := $(call object,$(CORE_SRC))
RT_OBJ   := $(call object,$(RT_SRC))
REST_OBJ := $(call object,$(REST_SRC))
CLI_OBJ  := $(call object,$(CLI_SRC))
# the part of the command-line layer that tests link: all but main
CLI_LIB  := $(filter-out %/main.o,$(CLI_OBJ))
TESTS    := $(TEST_SRC:tests/unit/%.c=$(BUILD)/tests/%)
BENCHES  := $(BENCH_SRC:tools/bench/%.c=$(BUILD)/bench/%)
FUZZERS  := $(FUZZ_SRC:tests/fuzz/%.c=$(BUILD)/fuzzers/%)
EXAMPLES := $(EXAMPLE_SRC:tools/%.c=$(BUILD)/examples/%)
PROGRAM  := $(if $(wildcard src/cli/main.c),$(BUILD)/mukca)
CORE     := $(BUILD)/libmukca_core.a
RT       := $(BUILD)/libmukca_rt.a

# ---- flags ---------------------------------------------------------------------------------------
WARNINGS := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wvla -Wundef \
            -Wcast-qual -Wwrite-strings -Wformat=2 $(if $(WERROR),-Werror)
C_WARNINGS := $(WARNINGS) -Wstrict-prototypes -Wmissing-prototypes
OPTIMISE := -O3 -g -ffp-contract=off -fno-math-errno -ffunction-sections -fdata-sections
DEFINES  := -D_DEFAULT_SOURCE -D_XOPEN_SOURCE=700
# `make HARDENING=` disables these flags; so does a compiler that lacks one of them.
HARDENING ?= -fstack-protector-strong -fstack-clash-protection -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2
HARDEN    := $(shell $(CC) -Werror -O1 $(HARDENING) -x c -c -o /dev/null /dev/null 2>/dev/null && \
             echo '$(HARDENING)')
C_FLAGS   = -std=c11 $(OPTIMISE) $(HARDEN) $(C_WARNINGS) $(DEFINES) -Iinclude -Isrc -MMD -MP
CXX_FLAGS = -std=c++17 $(OPTIMISE) $(HARDEN) $(WARNINGS) $(DEFINES) -Iinclude -Isrc -MMD -MP
# A build id depends on the build path; without it packages are reproducible.
LD_FLAGS  = -Wl,--gc-sections -Wl,--as-needed -Wl,--build-id=none -Wl,-z,relro,-z,now,-z,noexecstack

# The flags of the libraries are in a generated makefile; make restarts after generating it.
# `demo` and `check` install missing libraries, the other targets only report them.
NEEDS_LIBRARIES := $(filter-out core rt check-arm64 check-cortex-m7 deb-arm64 clean help dist uninstall format,$(or $(MAKECMDGOALS),all))
ifneq ($(NEEDS_LIBRARIES),)
include $(BUILD)/config.mk
endif

$(BUILD)/config.mk: tools/deps tools/config
	@mkdir -p $(@D)
	@$(if $(SYSROOT),,tools/deps $(if $(filter demo check,$(MAKECMDGOALS)),,--check))
	@$(SYSROOT_CONFIG) tools/config > $@.new && mv $@.new $@

# SYSROOT=FOLDER: headers and libraries of the target (tools/sysroot), for a cross compiler
ifneq ($(SYSROOT),)
SYSROOT_LIB := $(SYSROOT)/usr/lib/$(shell $(CC) -dumpmachine)
SYSROOT_CONFIG := PKG_CONFIG_SYSROOT_DIR=$(SYSROOT) PKG_CONFIG_LIBDIR=$(SYSROOT_LIB)/pkgconfig:$(SYSROOT)/usr/share/pkgconfig
override CPPFLAGS += --sysroot=$(SYSROOT)
override LDFLAGS += --sysroot=$(SYSROOT) -Wl,-rpath-link,$(SYSROOT_LIB)
endif

quietly = $(if $(V),,@echo '  $(1)'; )

# ---- targets -------------------------------------------------------------------------------------
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.SECONDARY:
.PHONY: all core rt demo programs check check-arm64 check-cortex-m7 deb-arm64 \
        attack closed-loop soak faults unit asan memcheck tidy format fuzz bench golden verify-real verify-outside \
        verify-orders verify-fleet fleets verify-paper verify-small-arms verify-plan verify-report interop blind install uninstall deb dist clean help FORCE

all: $(PROGRAM) $(CORE) $(RT) ## the program build/mukca and the core library (default)

core: $(CORE) $(RT) ## build/libmukca_core.a, libmukca_rt.a: C11 and libm only, cross-compile (CC=...)

rt: $(RT) ## build/libmukca_rt.a for control loops: no stdio, no allocation, bare metal

$(RT): $(RT_OBJ)
$(CORE): $(CORE_OBJ)
$(CORE) $(RT):
	@rm -f $@
	$(call quietly,AR $@)$(AR) qcsD $@ $^

$(BUILD)/mukca: $(CLI_OBJ) $(REST_OBJ) $(CORE)
	$(call quietly,LD $@)$(CXX) $(LD_FLAGS) $(LDFLAGS) -o $@ $^ $(LIBS) -lm

# A change of compiler or flags rebuilds everything.
$(BUILD)/flags: FORCE
	@mkdir -p $(@D)
	@echo '$(subst ','\'',$(CC) $(CXX) $(C_FLAGS) $(CXX_FLAGS) $(CPPFLAGS) $(CFLAGS) $(CXXFLAGS) $(LDFLAGS))' | \
	    cmp -s - $@ || echo '$(subst ','\'',$(CC) $(CXX) $(C_FLAGS) $(CXX_FLAGS) $(CPPFLAGS) $(CFLAGS) $(CXXFLAGS) $(LDFLAGS))' > $@

$(CORE_OBJ): LIB_CFLAGS :=
# No stack protector: targets of control loops may lack the libc functions that it calls.
$(RT_OBJ): private HARDEN :=
$(BUILD)/obj/%.o: %.c $(BUILD)/flags
	@mkdir -p $(@D)
	$(call quietly,CC $<)$(CC) $(C_FLAGS) $(LIB_CFLAGS) $(CPPFLAGS) $(CFLAGS) -c -o $@ $<

$(BUILD)/obj/%.o: %.cc $(BUILD)/flags
	@mkdir -p $(@D)
	$(call quietly,CXX $<)$(CXX) $(CXX_FLAGS) $(LIB_CFLAGS) $(CPPFLAGS) $(CFLAGS) $(CXXFLAGS) -c -o $@ $<

# Tests of kernels without allocation count the calls of a wrapped malloc.
$(BUILD)/tests/test_noalloc%: LD_FLAGS += -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=free
$(TESTS): $(BUILD)/tests/%: $(BUILD)/obj/tests/unit/%.o $(CLI_LIB) $(REST_OBJ) $(CORE)
	@mkdir -p $(@D)
	$(call quietly,LD $@)$(CXX) $(LD_FLAGS) $(LDFLAGS) -o $@ $^ $(LIBS) -lcmocka -lm

$(BENCHES): $(BUILD)/bench/%: $(BUILD)/obj/tools/bench/%.o $(REST_OBJ) $(CORE)
	@mkdir -p $(@D)
	$(call quietly,LD $@)$(CXX) $(LD_FLAGS) $(LDFLAGS) -o $@ $^ $(LIBS) -lm

# Examples of the core library: linked with it and libm only, and with LCM if they use it.
$(BUILD)/examples/example_impedance: EXAMPLE_LIBS = $(filter -llcm -l%thread-2.0 -lglib-2.0 -pthread,$(LIBS))
$(EXAMPLES): $(BUILD)/examples/%: $(BUILD)/obj/tools/%.o $(CORE)
	@mkdir -p $(@D)
	$(call quietly,LD $@)$(CC) $(LD_FLAGS) $(LDFLAGS) -o $@ $^ $(EXAMPLE_LIBS) -lm

$(FUZZERS): $(BUILD)/fuzzers/%: $(BUILD)/obj/tests/fuzz/%.o $(CLI_LIB) $(REST_OBJ) $(CORE)
	@mkdir -p $(@D)
	$(call quietly,LD $@)$(CXX) $(LD_FLAGS) $(LDFLAGS) -fsanitize=fuzzer -o $@ $^ $(LIBS) -lm

TEST_ENVIRONMENT := MUKCA=$(abspath $(BUILD))/mukca BUILD=$(abspath $(BUILD)) LC_ALL=C.UTF-8 \
    PYTHONDONTWRITEBYTECODE=1

attack: $(PROGRAM) $(TESTS) ## hostile datagrams, files and people against every command, in namespaces
	@$(TEST_ENVIRONMENT) $(call script,attack)


demo: all ## calibrate, diagnose and report the demo arm of data/ into build/demo
	@$(TEST_ENVIRONMENT) $(call script,demo) build/demo

check: $(PROGRAM) $(TESTS) $(EXAMPLES) $(RT) ## build and run every test
	@$(TEST_ENVIRONMENT) tests/run $(TESTS) $(SCRIPTS)

check-arm64: ## the program and its tests for arm64, under qemu-user
	+@tools/cross/arm64

check-cortex-m7: ## libmukca_rt.a on a bare Cortex-M7 (qemu): figures, and equal to the host
	+@tools/cross/cortex-m7

soak: $(PROGRAM) ## the LCM tests in full: 60 s at 1 kHz, 100 kills, a million hostile messages
	@$(TEST_ENVIRONMENT) MUKCA_LONG=1 tests/lcm/run.sh

programs: $(PROGRAM) $(TESTS) $(EXAMPLES) $(RT) ## build the programs that check runs

faults: $(PROGRAM) ## every failing allocation, write, sync and rename; 100 kills, 100 power cuts
	@$(TEST_ENVIRONMENT) MUKCA_LONG=1 tests/run $(abspath tests/fault/run.sh)
	@$(TEST_ENVIRONMENT) MUKCA_LONG=1 LCM_TESTS="$(abspath $(wildcard tests/lcm/test_kill.py \
	    tests/lcm/test_power.py))" tests/run tests/lcm/run.sh

unit: $(TESTS) ## the cmocka tests only
	@$(TEST_ENVIRONMENT) tests/run $(TESTS)

SANITIZE := -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
asan: ## all tests under the address and undefined-behaviour sanitizers
	+@ASAN_OPTIONS=detect_leaks=1 $(MAKE) --no-print-directory BUILD=build/asan \
	    CFLAGS='-O1 $(SANITIZE) $(CFLAGS)' LDFLAGS='$(SANITIZE) $(LDFLAGS)' check

memcheck: $(PROGRAM) $(TESTS) ## the unit tests and a calibration under valgrind
	@$(TEST_ENVIRONMENT) tests/memcheck $(TESTS)

tidy: ## clang-tidy, cppcheck and gcc -fanalyzer; a finding is an error
	@tools/tidy $(BUILD) $(C_FLAGS) $(LIB_CFLAGS)

format: ## clang-format all sources in place
	clang-format -i $$(git ls-files '*.c' '*.h' '*.cc')

fuzz: ## libFuzzer on every reader (FUZZ_SECONDS=60 each, two at a time)
	+@$(MAKE) --no-print-directory BUILD=build/fuzz CC=clang CXX=clang++ \
	    CFLAGS='-O1 -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined $(CFLAGS)' \
	    LDFLAGS='-fsanitize=address,undefined $(LDFLAGS)' fuzz-run
.PHONY: fuzz-run
fuzz-run: $(FUZZERS)
	@tests/fuzz/run $(FUZZERS)

# Script of a target NAME: tools/NAME/run*, tools/NAME.sh, tools/NAME.py or tools/NAME.
script = $(or $(firstword $(wildcard $(1:%=tools/%/run) $(1:%=tools/%/run.sh) $(1:%=tools/%/run.py) \
    $(1:%=tools/%.sh) $(1:%=tools/%.py)) $(if $(wildcard tools/$(1)/.),,$(wildcard tools/$(1)))),\
    sh -c 'echo "make $@: its script tools/$(1) is not in this tree" >&2; exit 1')

bench: $(PROGRAM) $(BENCHES) ## times and memory compared with the references
	@$(TEST_ENVIRONMENT) $(call script,bench)

golden: $(PROGRAM) ## rewrite the expected output of the command-line tests and the man page's COMMANDS
	@$(TEST_ENVIRONMENT) UPDATE_GOLDEN=1 tests/cli/run.sh
	@$(TEST_ENVIRONMENT) UPDATE_GOLDEN=1 tests/docs/run.sh

verify-real: $(PROGRAM) ## the published real robots: Table I, minima of J, diagnosis (needs the data)
	@$(TEST_ENVIRONMENT) $(call script,verify_real)

verify-outside: $(PROGRAM) ## rules of an honest diagnosis on public measurements of others (needs the data)
	@$(TEST_ENVIRONMENT) $(call script,verify_outside)

verify-orders: $(PROGRAM) ## the main cause in reordered and halved real recordings (needs the data)
	@$(TEST_ENVIRONMENT) $(call script,verify_orders)

verify-fleet: $(PROGRAM) ## shared traits of published arms, each predicted with those of the others (needs the data)
	@$(TEST_ENVIRONMENT) $(call script,verify_fleet)

fleets: $(PROGRAM) ## simulated fleets: shared traits found, false ones, broken arms (FLEETS=20)
	@$(TEST_ENVIRONMENT) $(PYTHON) tools/fleet/simulated.py --fleets $(or $(FLEETS),20)

verify-small-arms: $(PROGRAM) ## false causes on pure noise for arms with two to seven axes
	@$(TEST_ENVIRONMENT) $(call script,small_arms)

closed-loop: $(PROGRAM) $(EXAMPLES) ## from capture to a peg in a hole, against MuJoCo (PyPI): table and figure
	@$(TEST_ENVIRONMENT) $(call script,closed_loop)
	@$(TEST_ENVIRONMENT) tools/closed_loop/run failures.py
	@$(TEST_ENVIRONMENT) tools/closed_loop/run realtime.py

verify-paper: $(PROGRAM) ## Kana et al. (2022), Tables 3 to 12, compared with ours
	@$(TEST_ENVIRONMENT) $(call script,verify_paper)

interop: $(PROGRAM) ## exported models in Pinocchio, MuJoCo, yourdfpy (PyPI) against mukca fk
	@$(TEST_ENVIRONMENT) $(or $(wildcard tests/interop/run.py),$(call script,interop))
	@$(TEST_ENVIRONMENT) $(PYTHON) tests/interop/inertials.py

blind: $(PROGRAM) ## sealed cases of the independent generator, scored
	@$(TEST_ENVIRONMENT) $(call script,blind)

verify-plan: $(BENCHES) ## value of planned postures on simulated arms
	@$(BUILD)/bench/bench_plan accuracy 50
	@$(BUILD)/bench/bench_plan ties 50
	@$(BUILD)/bench/bench_plan ties 50 random

verify-report: $(PROGRAM) ## reports of the demo and of real robots in a headless browser
	@$(TEST_ENVIRONMENT) $(call script,verify_report)

artefact: ## STL files, drawing and picture of the printed tool (needs openscad)
	@$(call script,artefact)

deb: $(PROGRAM) $(CORE) ## a Debian package in build/
	@$(TEST_ENVIRONMENT) VERSION=$(VERSION) $(call script,deb)

deb-arm64: ## the same for arm64, cross-built
	+@VERSION=$(VERSION) tools/cross/arm64 deb

dist: ## a reproducible source archive in build/
	@VERSION=$(VERSION) $(call script,dist)

# ---- install -------------------------------------------------------------------------------------
bindir := $(DESTDIR)$(PREFIX)/bin
libdir := $(DESTDIR)$(PREFIX)/lib
incdir := $(DESTDIR)$(PREFIX)/include/mukca
share  := $(DESTDIR)$(PREFIX)/share
MAN1   := $(wildcard mukca.1)
MAN5   := $(wildcard mukca-formats.5)

# Folders that install may have created, inner ones first, except those of a system prefix.
emptied := $(libdir)/pkgconfig $(libdir)/systemd/system $(libdir)/systemd $(share)/man/man1 \
    $(share)/man/man5 $(share)/bash-completion/completions $(share)/bash-completion \
    $(share)/zsh/site-functions $(share)/zsh \
    $(if $(filter /usr /usr/local,$(DESTDIR)$(PREFIX)),,$(bindir) $(libdir) $(dir $(incdir)) \
    $(share)/man $(share) $(DESTDIR)$(PREFIX))

install: all ## program, core library, headers, mukca.pc, unit, man pages, completion (DESTDIR, PREFIX)
	install -d $(bindir) $(libdir)/pkgconfig $(libdir)/systemd/system $(incdir) $(share)/man/man1 \
	    $(share)/man/man5 $(share)/mukca/lcm $(share)/mukca/inertials $(share)/mukca/traits $(share)/bash-completion/completions \
	    $(share)/zsh/site-functions
	install -m 755 $(BUILD)/mukca $(bindir)/mukca
	install -m 644 $(CORE) $(RT) $(libdir)/
	install -m 644 $(HEADERS) $(incdir)/
	sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@VERSION@|$(VERSION)|' tools/mukca.pc.in > $(libdir)/pkgconfig/mukca.pc
	sed -e 's|/usr/local|$(PREFIX)|' data/systemd/mukca.service > $(libdir)/systemd/system/mukca.service
	install -m 644 data/lcm/*.lcm $(share)/mukca/lcm/
	install -m 644 data/inertials/*.tsv $(share)/mukca/inertials/
	install -m 644 data/traits/*.tsv $(share)/mukca/traits/
	install -m 644 $(MAN1) $(share)/man/man1/
	$(if $(MAN5),install -m 644 $(MAN5) $(share)/man/man5/)
	$(EMULATOR) $(BUILD)/mukca completion bash > $(share)/bash-completion/completions/mukca
	$(EMULATOR) $(BUILD)/mukca completion zsh > $(share)/zsh/site-functions/_mukca

uninstall: ## remove the installed files
	rm -f $(bindir)/mukca $(libdir)/libmukca_core.a $(libdir)/libmukca_rt.a $(libdir)/pkgconfig/mukca.pc \
	    $(libdir)/systemd/system/mukca.service \
	    $(share)/man/man1/mukca.1 $(share)/man/man5/mukca-formats.5 \
	    $(share)/bash-completion/completions/mukca $(share)/zsh/site-functions/_mukca
	rm -rf $(incdir) $(share)/mukca
	@rmdir $(emptied) 2>/dev/null || true

clean: ## remove build/
	rm -rf build $(filter-out build,$(BUILD))

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1\t\2/p' Makefile | while IFS="$$(printf '\t')" read -r t d; do \
	    printf '  %-13s %s\n' "$$t" "$$d"; done

-include $(shell find $(BUILD)/obj -name '*.d' 2>/dev/null)
