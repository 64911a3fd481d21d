# install.mk: `make install PREFIX=/where` (default /usr/local; DESTDIR is put in front of it, as packagers need), and
# `make uninstall` with the same PREFIX and DESTDIR.  What is installed may be moved as a whole.
#   bin/pbw                            the program
#   include/pbw/                       pbw.h and its companions, to be included as "pbw.h"; pbw_cuda.cu beside it
#   lib/libpbw.a, lib/libpbw.so        the implementations of pbw.h, pbw_check.h, pbw_query.h, pbw_live.h; a program
#                                      that defines PBW_IMPLEMENTATION needs neither.  (Shared library: systems with ELF.)
#   lib/pkgconfig/pbw.pc               cc program.c $(pkg-config --cflags --libs pbw)
#   lib/cmake/pbw/                     find_package(pbw): see pbwConfig.cmake
#   share/man/man1/pbw.1, completions for bash and zsh, share/doc/pbw: README.md and LICENSE
PREFIX ?= /usr/local
DESTDIR =
INSTALL = install
VERSION := $(shell sed -n '1s/.* - v\([0-9.]*\) - .*/\1/p' pbw.h)
SONAME = libpbw.so.$(basename $(VERSION))
ROOT = $(DESTDIR)$(PREFIX)
CONFIG = pbwConfig pbwConfigVersion
INSTALLED = bin/pbw include/pbw lib/libpbw.a lib/libpbw.so lib/$(SONAME) lib/libpbw.so.$(VERSION) \
    lib/pkgconfig/pbw.pc lib/cmake/pbw share/man/man1/pbw.1 share/bash-completion/completions/pbw \
    share/zsh/site-functions/_pbw share/doc/pbw

.PHONY: install uninstall

$B/libpbw.so: $B/libpbw.a
	$(CC) $(CFLAGS) -shared -Wl,-soname,$(SONAME) $B/libpbw.o -o $@ $(LIBS)

$B/install/%: examples/install/% pbw.h
	@mkdir -p $(@D)
	sed 's/@VERSION@/$(VERSION)/' $< > $@

install: $B/pbw $B/libpbw.a $B/libpbw.so $B/install/pbw.pc $(CONFIG:%=$B/install/%.cmake)
	$(INSTALL) -d $(addprefix "$(ROOT)"/,bin include/pbw lib/pkgconfig lib/cmake/pbw)
	$(INSTALL) -m 755 $B/pbw "$(ROOT)"/bin/pbw
	$(INSTALL) -m 644 pbw.h pbw_cuda.cu $(wildcard examples/lib/*.h) "$(ROOT)"/include/pbw
	$(INSTALL) -m 644 $B/libpbw.a "$(ROOT)"/lib/libpbw.a
	$(INSTALL) -m 755 $B/libpbw.so "$(ROOT)"/lib/libpbw.so.$(VERSION)
	ln -sf libpbw.so.$(VERSION) "$(ROOT)"/lib/$(SONAME)
	ln -sf $(SONAME) "$(ROOT)"/lib/libpbw.so
	$(INSTALL) -m 644 $(CONFIG:%=$B/install/%.cmake) "$(ROOT)"/lib/cmake/pbw
	$(INSTALL) -m 644 $B/install/pbw.pc "$(ROOT)"/lib/pkgconfig
	$(INSTALL) -d $(addprefix "$(ROOT)"/share/,man/man1 bash-completion/completions zsh/site-functions doc/pbw)
	$B/pbw help --man > "$(ROOT)"/share/man/man1/pbw.1
	$B/pbw help --bash > "$(ROOT)"/share/bash-completion/completions/pbw
	$B/pbw help --zsh > "$(ROOT)"/share/zsh/site-functions/_pbw
	sed -n '/^   >>license/,/^ *\*\//{/\*\//d;p;}' pbw.h > "$(ROOT)"/share/doc/pbw/LICENSE
	$(INSTALL) -m 644 README.md "$(ROOT)"/share/doc/pbw

# Folders that others use as well stay.
uninstall:
	rm -rf $(addprefix "$(ROOT)"/,$(INSTALLED))
