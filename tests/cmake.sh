#!/bin/sh
# cmake.sh FOLDER: builds and runs examples/cmake there, by itself and as a part of another project, where CMake is.
work=$1/cmake
. tests/check.sh
mkdir -p "$work/other/third"
if ! command -v cmake > /dev/null; then
    skip "examples/cmake: no cmake"
    finish
fi

prints() { "$1" > "$work/printed" && echo "success: 4 triangles" | diff - "$work/printed"; }

check "alone: configures" cmake -S examples/cmake -B "$work/alone" -DCMAKE_C_FLAGS_RELEASE=-O1
check "alone: builds" cmake --build "$work/alone"
check "alone: runs" prints "$work/alone/app"
check "alone: ctest" cmake --build "$work/alone" --target test

# A project in C++ that has copied the folder and pbw.h.
cp examples/cmake/* pbw.h "$work/other/third"
cp examples/cmake/app.c "$work/other/main.cpp"
cat > "$work/other/CMakeLists.txt" << 'TEXT'
cmake_minimum_required(VERSION 3.10)
project(other LANGUAGES C CXX)
add_subdirectory(third)
add_executable(main main.cpp)
target_link_libraries(main PRIVATE pbw::pbw)
TEXT
check "as a part: configures" cmake -S "$work/other" -B "$work/other/build" -DCMAKE_BUILD_TYPE=Debug
check "as a part: builds" cmake --build "$work/other/build"
check "as a part: runs" prints "$work/other/build/main"

mkdir "$work/lost"
cp examples/cmake/* "$work/lost"
check "without pbw.h: says so" sh -c \
    "cmake -S $work/lost -B $work/lost/build 2>&1 | grep 'pbw.h is not beside this file'"
finish
