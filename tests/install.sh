#!/bin/sh
# install.sh FOLDER: `make install` of what is built in FOLDER, staged and then moved; it works with a plain compiler,
# pkg-config and CMake's find_package; `make uninstall` leaves only what others put there.
CC=${CC:-cc} work=$1/install-test
. tests/check.sh
staged="$work/stage with space" prefix="$(cd "$work" && pwd)/moved"
version=$(sed -n '1s/.* - v\([0-9.]*\) - .*/\1/p' pbw.h)
says() {        # says COMMAND...: runs app.c
    "$@" > "$work/printed" && echo "success: 4 triangles" | diff - "$work/printed"
}
refused() {     # refused VERSION: find_package sees ours and does not take it
    ! cmake -S "$work" -B "$work/cmake-other" -DCMAKE_PREFIX_PATH="$prefix" -DWANTED="$1" > "$work/refused" 2>&1 &&
        grep "pbwConfig.cmake, version: $version" "$work/refused"
}

check "make install" make --no-print-directory install B="$1" DESTDIR="$staged" PREFIX=/opt/pbw
mv "$staged/opt/pbw" "$prefix"
check "nothing is installed elsewhere" [ -z "$(find "$staged" -type f)" ]
for file in man/man1/pbw.1 bash-completion/completions/pbw zsh/site-functions/_pbw doc/pbw/LICENSE doc/pbw/README.md; do
    check "share/$file is there" [ -s "$prefix/share/$file" ]
done
check "the program runs" "$prefix/bin/pbw" --generate uniform 100 --quiet -o "$work/p.obj"
for header in "$prefix"/include/pbw/*.h; do
    name=$(basename "$header") compiler=$CC define=
    case $name in
    pbw_mpi.h)
        compiler=mpicc
        command -v mpicc > /dev/null || { skip "a program includes $name: no mpicc"; continue; } ;;
    pbw_stuffing.h) define=-DPBW_SURFACE_IMPLEMENTATION ;;       # all of its functions are static
    esac
    # shellcheck disable=SC2086
    check "a program includes $name" \
        $compiler $define -std=c99 -I"$prefix/include" -include "pbw/$name" -x c -fsyntax-only /dev/null
done

# pkg-config: the shared library, the static one, the header alone.
if command -v pkg-config > /dev/null; then
    export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
    check "pkg-config: version" [ "$(pkg-config --modversion pbw)" = "$version" ]
    cflags=$(pkg-config --cflags pbw)
    check "pkg-config: shared: compiles" $CC examples/cmake/app.c $cflags $(pkg-config --libs pbw) -o "$work/shared"
    check "pkg-config: shared: runs" says env LD_LIBRARY_PATH="$prefix/lib" "$work/shared"
    check "pkg-config: static: compiles" \
        $CC examples/cmake/app.c $cflags -static $(pkg-config --static --libs pbw) -o "$work/static"
    check "pkg-config: static: runs" says "$work/static"
    check "pkg-config: header: compiles" \
        $CC examples/cmake/app.c examples/cmake/pbw.c $cflags -lpthread -o "$work/header"
    check "pkg-config: header: runs" says "$work/header"
else
    skip "pkg-config: not installed"
fi

# CMake: C and C++, static, shared, the header alone.
cat > "$work/CMakeLists.txt" << 'TEXT'
cmake_minimum_required(VERSION 3.10)
project(user LANGUAGES C CXX)
find_package(pbw ${WANTED} REQUIRED)
find_package(pbw REQUIRED)
add_executable(compiled app.c)
target_link_libraries(compiled PRIVATE pbw::pbw)
add_executable(cxx app.cpp)
target_link_libraries(cxx PRIVATE pbw::pbw)
add_executable(library app.c)
target_link_libraries(library PRIVATE pbw::library)
if(NOT BUILD_SHARED_LIBS)
    foreach(target header pbw)
        add_executable(own_${target} app.c pbw.c)
        target_link_libraries(own_${target} PRIVATE pbw::${target})
    endforeach()
endif()
TEXT
cp examples/cmake/app.c examples/cmake/pbw.c "$work"
cp examples/cmake/app.c "$work/app.cpp"
if command -v cmake > /dev/null; then
    for shared in OFF ON; do
        build="$work/cmake-$shared"
        check "find_package, shared $shared: configures" cmake -S "$work" -B "$build" -DCMAKE_PREFIX_PATH="$prefix" \
            -DBUILD_SHARED_LIBS=$shared -DWANTED="${version%.*}"
        check "find_package, shared $shared: builds" cmake --build "$build"
        for program in compiled cxx library $([ $shared = ON ] || echo own_header own_pbw); do
            check "find_package, shared $shared: $program runs" says "$build/$program"
        done
    done
    for wanted in 9 "${version%.*}.99" 0.0.1; do
        check "find_package: version $wanted is not this one" refused $wanted
    done
else
    skip "find_package: no cmake"
fi

touch "$prefix/lib/other"
check "make uninstall" make --no-print-directory uninstall B="$1" PREFIX="$prefix"
check "only what is another's is left" [ "$(find "$prefix" ! -type d)" = "$prefix/lib/other" ]
finish
