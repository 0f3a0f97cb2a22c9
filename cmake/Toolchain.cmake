# What every target is compiled with: a compiler cache and a fast linker where they exist, warnings from one interface.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
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
