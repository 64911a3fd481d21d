# find_package(pbw) where `make install PREFIX=` put pbw; for another place -DCMAKE_PREFIX_PATH=that PREFIX.
#   pbw::pbw       the headers and the library, which has pbw.h, pbw_check.h, pbw_query.h, pbw_live.h: all that most need
#   pbw::header    the header alone, for a program that defines PBW_IMPLEMENTATION in one source file of its own
#   pbw::library   what pbw::pbw links: static, or shared where BUILD_SHARED_LIBS is on
# All of them have the companion headers and bring threads.
include(CMakeFindDependencyMacro)
set(THREADS_PREFER_PTHREAD_FLAG ON)
find_dependency(Threads)

if(NOT TARGET pbw::pbw)
    get_filename_component(pbw_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

    add_library(pbw::header INTERFACE IMPORTED)
    set_target_properties(pbw::header PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${pbw_PREFIX}/include/pbw"
        INTERFACE_LINK_LIBRARIES Threads::Threads)

    if(BUILD_SHARED_LIBS)
        add_library(pbw::library SHARED IMPORTED)
        set_target_properties(pbw::library PROPERTIES IMPORTED_LOCATION "${pbw_PREFIX}/lib/libpbw.so")
    else()
        add_library(pbw::library STATIC IMPORTED)
        set_target_properties(pbw::library PROPERTIES IMPORTED_LOCATION "${pbw_PREFIX}/lib/libpbw.a")
    endif()
    set_target_properties(pbw::library PROPERTIES
        IMPORTED_LINK_INTERFACE_LANGUAGES C
        INTERFACE_LINK_LIBRARIES pbw::header)

    add_library(pbw::pbw INTERFACE IMPORTED)
    set_target_properties(pbw::pbw PROPERTIES INTERFACE_LINK_LIBRARIES pbw::library)
endif()
