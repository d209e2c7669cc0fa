# SYSROOT=FOLDER: headers and libraries of the target (tools/sysroot), for a cross compiler.
SYSROOT_LIB := $(SYSROOT)/usr/lib/$(shell $(CC) -dumpmachine)
SYSROOT_CONFIG := PKG_CONFIG_SYSROOT_DIR=$(SYSROOT) PKG_CONFIG_LIBDIR=$(SYSROOT_LIB)/pkgconfig:$(SYSROOT)/usr/share/pkgconfig
override CPPFLAGS += --sysroot=$(SYSROOT)
override LDFLAGS += --sysroot=$(SYSROOT) -Wl,-rpath-link,$(SYSROOT_LIB)
