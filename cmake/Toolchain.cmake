# What every target is compiled with: a compiler cache and a fast linker where they exist, warnings from one interface.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Two clones of the same source share what was compiled: paths below the clone count relative to it.
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=true ${CCACHE_PROGRAM})
endif()
find_program(MOLD_PROGRAM mold)
if(MOLD_PROGRAM)
  add_link_options(-fuse-ld=mold)
endif()

add_library(trunnion_warnings INTERFACE)
target_compile_options(trunnion_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast
  -Wno-missing-field-initializers)  # designated initialisers leave the defaults to the struct
if(TRUNNION_WERROR)
  target_compile_options(trunnion_warnings INTERFACE -Werror)
endif()
