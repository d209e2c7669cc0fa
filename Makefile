# mukca: `make help` lists the targets.  Those of research, sanitizers and other processors are in
# tools/Makefile (`make -f tools/Makefile help`), which includes this one.
#
# Sources are found by wildcard: src/*/*.c (but src/heart) make the program, tests/unit/test_*.c one
# cmocka program each, tests/*.sh and tests/*/run.sh the script tests of `make check` (MUKCA and BUILD
# are in their environment; they print `ok NAME` or `not ok NAME` lines, and exit 77 when skipped).
# Objects go to $(BUILD); `make BUILD=build/x CFLAGS=...` builds a variant next to the default one;
# `make V=1` prints full commands.
BUILD  ?= build
PREFIX ?= /usr/local
CC     := $(if $(filter default,$(origin CC)),gcc,$(CC))
CXX    := $(if $(filter default,$(origin CXX)),g++,$(CXX))

VERSION := $(shell sed -n 's/.*MUKCA_VERSION "\(.*\)".*/\1/p' include/mukca/version.h)

# ---- sources, objects, products ------------------------------------------------------------------
# modules of the core library, in the order of tests/layers.sh
CORE_MODULES := base math model dynamics effect arm infer fit recalibrate plan simulate diagnose accept capture motion fleet
CORE_SRC := $(filter-out src/fit/nlopt_%,$(foreach module,$(CORE_MODULES),\
            $(sort $(wildcard src/$(module)/*.c))))
# the part of these for control loops: no stdio, no allocation, no clock, no locale
RT_SRC := $(addprefix src/,$(addsuffix .c,base/cells base/number base/print math/orientation \
          math/rotation math/sincos model/chain model/chain_lookup model/fk model/fk_frames \
          model/gravity model/row_state arm/acceptance arm/corrected arm/offsets_parse)) $(sort $(wildcard src/effect/*.c))
# the paper's calibration alone, of the program's files (ARCHITECTURE.md)
HEART_SRC := $(addprefix src/,$(addsuffix .c,heart/main heart/read base/pool base/status math/rotation \
             model/chain model/fk model/dataset fit/parameters fit/sweep fit/observe fit/cost \
             fit/nlopt_adapter arm/offset_lines))

object = $(patsubst %,$(BUILD)/obj/%.o,$(basename $(1)))
CORE_OBJ := $(call object,$(CORE_SRC))
RT_OBJ   := $(call object,$(RT_SRC))
REST_OBJ := $(call object,$(sort $(wildcard src/fit/nlopt_*.c $(foreach module,io lcm report record,\
            src/$(module)/*.c src/$(module)/*.cc))))
CLI_OBJ  := $(call object,$(sort $(wildcard src/cli/*.c)))
# the part of the command-line layer that tests link: all but main
CLI_LIB  := $(filter-out %/main.o,$(CLI_OBJ))
TESTS    := $(patsubst tests/unit/%.c,$(BUILD)/tests/%,$(sort $(wildcard tests/unit/test_*.c)))
BENCHES  := $(patsubst tools/bench/%.c,$(BUILD)/bench/%,$(sort $(wildcard tools/bench/bench_*.c)))
EXAMPLES := $(patsubst tools/%.c,$(BUILD)/examples/%,$(sort $(wildcard tools/example_*.c)))
PROGRAM  := $(BUILD)/mukca
CORE     := $(BUILD)/libmukca_core.a
RT       := $(BUILD)/libmukca_rt.a

# ---- flags ---------------------------------------------------------------------------------------
WARNINGS := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wvla -Wundef \
            -Wcast-qual -Wwrite-strings -Wformat=2 $(if $(WERROR),-Werror)
# -falign-loops: the speed of a kernel must not depend on where the linker puts it (5 % of a diagnosis).
OPTIMISE := -O3 -g -falign-loops=32 -ffp-contract=off -fno-math-errno -ffunction-sections -fdata-sections -fstack-usage
DEFINES  := -D_DEFAULT_SOURCE -D_XOPEN_SOURCE=700
# `make HARDENING=` disables these flags; so does a compiler that lacks one of them.
HARDENING ?= -fstack-protector-strong -fstack-clash-protection -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2
HARDEN    := $(shell $(CC) -Werror -O1 $(HARDENING) -x c -c -o /dev/null /dev/null 2>/dev/null && echo '$(HARDENING)')
C_FLAGS   = -std=c11 $(OPTIMISE) $(HARDEN) $(WARNINGS) -Wstrict-prototypes -Wmissing-prototypes $(DEFINES) \
            -Iinclude -Isrc -MMD -MP
CXX_FLAGS = -std=c++17 $(OPTIMISE) $(HARDEN) $(WARNINGS) $(DEFINES) -Iinclude -Isrc -MMD -MP
# A build id depends on the build path; without it packages are reproducible.
LD_FLAGS  = -Wl,--gc-sections -Wl,--as-needed -Wl,--build-id=none -Wl,-z,relro,-z,now,-z,noexecstack

# The flags of the libraries are in a generated makefile; make restarts after generating it.
# `demo` and `check` install missing libraries, the other targets only report them.
NEEDS_LIBRARIES := $(filter-out core rt clean help dist uninstall format artefact $(NO_LIBRARIES),$(or $(MAKECMDGOALS),all))
include $(if $(NEEDS_LIBRARIES),$(BUILD)/config.mk)

$(BUILD)/config.mk: tools/deps tools/config
	@mkdir -p $(@D)
	@$(if $(SYSROOT),,tools/deps $(if $(filter demo check,$(MAKECMDGOALS)),,--check))
	@$(SYSROOT_CONFIG) tools/config > $@.new && mv $@.new $@

# SYSROOT=FOLDER: headers and libraries of the target, for a cross compiler
include $(if $(SYSROOT),tools/cross/sysroot.mk)
quietly = $(if $(V),,@echo '  $(1)'; )
# link with compiler $(1) and libraries $(2)
link = $(call quietly,LD $@)mkdir -p $(@D); $(1) $(LD_FLAGS) $(LDFLAGS) -o $@ $^ $(2) -lm

# ---- targets -------------------------------------------------------------------------------------
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.SECONDARY:
.PHONY: all core rt heart demo programs check golden bench tidy figures format deb dist artefact install uninstall \
        clean help FORCE

all: $(PROGRAM) $(CORE) $(RT) ## the program build/mukca and the core library (default)
core: $(CORE) $(RT) ## build/libmukca_core.a, libmukca_rt.a: C11, libm, POSIX threads; cross-compile (CC=...)
rt: $(RT) ## build/libmukca_rt.a for control loops: no stdio, no allocation, bare metal
heart: $(BUILD)/heart ## build/heart: the paper's calibration alone, in 2,000 lines

$(BUILD)/heart: $(call object,$(HEART_SRC))
	$(call link,$(CC),-lnlopt)

$(RT): $(RT_OBJ)
$(CORE): $(CORE_OBJ)
$(CORE) $(RT):
	@rm -f $@
	$(call quietly,AR $@)$(AR) qcsD $@ $^

$(BUILD)/mukca: $(CLI_OBJ) $(REST_OBJ) $(CORE)
	$(call link,$(CXX),$(LIBS))

# A change of compiler or flags rebuilds everything.
stamp = $(subst ','\'',$(CC) $(CXX) $(C_FLAGS) $(CXX_FLAGS) $(CPPFLAGS) $(CFLAGS) $(CXXFLAGS) $(LDFLAGS))
$(BUILD)/flags: FORCE
	@mkdir -p $(@D); echo '$(stamp)' | cmp -s - $@ || echo '$(stamp)' > $@

$(CORE_OBJ): LIB_CFLAGS :=
# No stack protector: targets of control loops may lack the libc functions that it calls.
$(RT_OBJ): private HARDEN :=
# Dense products multiply and add in one instruction where a processor can (src/base/clones.h).
$(patsubst %,$(BUILD)/obj/src/%.o,math/dense_gram infer/mixture infer/posterior infer/sets_search): \
    private OPTIMISE += -ffp-contract=fast
$(BUILD)/obj/%.o: %.c $(BUILD)/flags
	@mkdir -p $(@D)
	$(call quietly,CC $<)$(CC) $(C_FLAGS) $(LIB_CFLAGS) $(CPPFLAGS) $(CFLAGS) -c -o $@ $<
$(BUILD)/obj/%.o: %.cc $(BUILD)/flags
	@mkdir -p $(@D)
	$(call quietly,CXX $<)$(CXX) $(CXX_FLAGS) $(LIB_CFLAGS) $(CPPFLAGS) $(CFLAGS) $(CXXFLAGS) -c -o $@ $<

# Tests of kernels without allocation count the calls of a wrapped malloc.
$(BUILD)/tests/test_noalloc%: LD_FLAGS += -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=free
$(TESTS): $(BUILD)/tests/%: $(BUILD)/obj/tests/unit/%.o $(CLI_LIB) $(REST_OBJ) $(CORE)
	$(call link,$(CXX),$(LIBS) -lcmocka)

$(BENCHES): $(BUILD)/bench/%: $(BUILD)/obj/tools/bench/%.o $(REST_OBJ) $(CORE)
	$(call link,$(CXX),$(LIBS))

# Examples of the core library: linked with it and libm only, and with LCM if they use it.
$(BUILD)/examples/example_impedance: EXAMPLE_LIBS = $(filter -llcm -l%thread-2.0 -lglib-2.0 -pthread,$(LIBS))
$(EXAMPLES): $(BUILD)/examples/%: $(BUILD)/obj/tools/%.o $(CORE)
	$(call link,$(CC),$(EXAMPLE_LIBS))

TEST_ENVIRONMENT := MUKCA=$(abspath $(BUILD))/mukca BUILD=$(abspath $(BUILD)) LC_ALL=C.UTF-8 \
    PYTHONDONTWRITEBYTECODE=1 HEART_SRC='$(HEART_SRC)'

demo: all ## calibrate, diagnose and report the real arm of data/panda into build/demo
	@$(TEST_ENVIRONMENT) tools/demo/run build/demo

check: programs ## build and run every test
	@$(TEST_ENVIRONMENT) tests/run $(TESTS) $(sort $(wildcard tests/*.sh tests/*/run.sh))
programs: $(PROGRAM) $(TESTS) $(EXAMPLES) $(RT) $(BUILD)/heart $(BENCHES)

tidy: ## clang-tidy, cppcheck and gcc -fanalyzer; a finding is an error
	@tools/tidy $(BUILD) $(filter-out -fstack-usage,$(C_FLAGS)) $(LIB_CFLAGS)
format: ## clang-format all sources in place
	clang-format -i $$(git ls-files '*.c' '*.h' '*.cc')

bench: $(PROGRAM) $(BENCHES) ## times and memory compared with the references
	@$(TEST_ENVIRONMENT) tools/bench/run.py
golden: $(PROGRAM) ## rewrite the expected output of the command-line tests and the man page's COMMANDS
	@$(TEST_ENVIRONMENT) UPDATE_GOLDEN=1 sh -c 'tests/cli/run.sh && tests/docs/run.sh'
figures: $(PROGRAM) $(if $(TIMES),$(BENCHES)) ## the figures in README and docs/comparison.md (TIMES="fit growth": of bench, too)
	@$(TEST_ENVIRONMENT) tools/figures.py $(if $(TIMES),--times $(TIMES))
	@$(TEST_ENVIRONMENT) tools/centres.py
artefact: ## STL files, drawing and picture of the printed tool (needs openscad)
	@tools/artefact

deb: $(PROGRAM) $(CORE) ## a Debian package in build/
	@$(TEST_ENVIRONMENT) VERSION=$(VERSION) tools/deb/run
dist: ## a reproducible source archive in build/
	@VERSION=$(VERSION) tools/dist

# ---- install -------------------------------------------------------------------------------------
bindir := $(DESTDIR)$(PREFIX)/bin
libdir := $(DESTDIR)$(PREFIX)/lib
incdir := $(DESTDIR)$(PREFIX)/include/mukca
share  := $(DESTDIR)$(PREFIX)/share
# Folders that install may have created, inner ones first, except those of a system prefix.
emptied := $(libdir)/pkgconfig $(libdir)/systemd/system $(libdir)/systemd $(share)/man/man1 \
    $(share)/man/man5 $(share)/bash-completion/completions $(share)/bash-completion \
    $(share)/zsh/site-functions $(share)/zsh \
    $(if $(filter /usr /usr/local,$(DESTDIR)$(PREFIX)),,$(bindir) $(libdir) $(dir $(incdir)) \
    $(share)/man $(share) $(DESTDIR)$(PREFIX))

install: all ## program, core library, headers, mukca.pc, unit, man pages, completion (DESTDIR, PREFIX)
	install -d $(libdir)/pkgconfig $(libdir)/systemd/system $(share)/bash-completion/completions \
	    $(share)/zsh/site-functions
	install -D -m 755 -t $(bindir) $(BUILD)/mukca
	install -D -m 644 -t $(libdir) $(CORE) $(RT)
	install -D -m 644 -t $(incdir) include/mukca/*.h
	sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@VERSION@|$(VERSION)|' tools/mukca.pc.in > $(libdir)/pkgconfig/mukca.pc
	sed -e 's|/usr/local|$(PREFIX)|' data/systemd/mukca.service > $(libdir)/systemd/system/mukca.service
	for d in lcm inertials traits; do install -D -m 644 -t $(share)/mukca/$$d data/$$d/*.[lt]*; done
	install -D -m 644 -t $(share)/man/man1 mukca.1
	install -D -m 644 -t $(share)/man/man5 mukca-formats.5
	install -m 644 data/completion.bash $(share)/bash-completion/completions/mukca
	{ printf '#compdef mukca\nautoload -U +X bashcompinit && bashcompinit\n'; cat data/completion.bash; \
	    echo '_bash_complete -o default -F _mukca'; } > $(share)/zsh/site-functions/_mukca

uninstall: ## remove the installed files
	rm -f $(bindir)/mukca $(libdir)/libmukca_core.a $(libdir)/libmukca_rt.a $(libdir)/pkgconfig/mukca.pc \
	    $(libdir)/systemd/system/mukca.service $(share)/man/man1/mukca.1 $(share)/man/man5/mukca-formats.5 \
	    $(share)/bash-completion/completions/mukca $(share)/zsh/site-functions/_mukca
	rm -rf $(incdir) $(share)/mukca
	@rmdir $(emptied) 2>/dev/null || true

clean: ## remove build/
	rm -rf build $(filter-out build,$(BUILD))
help: ## this list
	@sed -n 's/^\([a-z0-9-]*\):.*## \(.*\)/  \1\t\2/p' $(firstword $(MAKEFILE_LIST)) | expand -t 16

-include $(shell find $(BUILD)/obj -name '*.d' 2>/dev/null)
