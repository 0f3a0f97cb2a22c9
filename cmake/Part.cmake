# In builds of the developers, whatever runs once a call or a test compiles no further than -O1: a fifth less to wait.
function(trunnion_compile_lightly TARGET)
  if(CMAKE_CXX_FLAGS MATCHES "-O2")
    target_compile_options(${TARGET} PRIVATE -O1)
  endif()
endfunction()

# trunnion_part(NAME SOURCES a.cpp … [LINK part …] [PRIVATE library …])
#
# One library a part: trunnion::NAME. LINK names the parts it may include (they restate the diagram of docs/architecture.md,
# tests/link_graph_test.py checks it), PRIVATE the outside libraries that stay behind its headers.
define_property(GLOBAL PROPERTY TRUNNION_PARTS BRIEF_DOCS "All parts" FULL_DOCS "Names of all parts, in order of definition")

function(trunnion_part NAME)
  cmake_parse_arguments(PART "" "" "SOURCES;LINK;PUBLIC;PRIVATE" ${ARGN})
  set(target trunnion_${NAME})
  if(PART_SOURCES)
    add_library(${target} STATIC ${PART_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:trunnion_warnings> ${PART_PRIVATE})
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(trunnion::${NAME} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${NAME})
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/trunnion>)
  foreach(part IN LISTS PART_LINK)
    target_link_libraries(${target} ${scope} trunnion::${part})
  endforeach()
  target_link_libraries(${target} ${scope} ${PART_PUBLIC})
  target_compile_features(${target} ${scope} cxx_std_20)
  set(PART_OUTSIDE ${PART_PUBLIC} ${PART_PRIVATE})
  set_property(GLOBAL APPEND PROPERTY TRUNNION_PARTS ${NAME})
  set_property(GLOBAL PROPERTY TRUNNION_PART_${NAME}_LINK "${PART_LINK}")
  set_property(GLOBAL PROPERTY TRUNNION_PART_${NAME}_OUTSIDE "${PART_OUTSIDE}")
endfunction()

# Writes <build>/link_graph.txt, one line a part: `NAME: part part …`, what trunnion_part(NAME LINK …) said.
function(trunnion_write_link_graph)
  get_property(parts GLOBAL PROPERTY TRUNNION_PARTS)
  set(text "")
  foreach(part IN LISTS parts)
    get_property(link GLOBAL PROPERTY TRUNNION_PART_${part}_LINK)
    list(JOIN link " " link)
    string(APPEND text "${part}: ${link}\n")
  endforeach()
  file(WRITE ${PROJECT_BINARY_DIR}/link_graph.txt "${text}")
endfunction()

# trunnion_test(NAME SOURCES a_test.cpp … [LINK …] [LABELS …]): one GoogleTest program, its cases known to ctest. What
# is tested is compiled as the preset says; the cases themselves, which run once, no further than -O1.
function(trunnion_test NAME)
  cmake_parse_arguments(TEST "" "" "SOURCES;LINK;LABELS" ${ARGN})
  add_executable(${NAME} ${TEST_SOURCES})
  target_link_libraries(${NAME} PRIVATE trunnion_warnings ${TEST_LINK} GTest::gmock GTest::gtest_main)
  target_include_directories(${NAME} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(${NAME} PRIVATE TRUNNION_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  trunnion_compile_lightly(${NAME})
  set(labels)
  if(TEST_LABELS)
    set(labels PROPERTIES LABELS "${TEST_LABELS}")
  endif()
  gtest_discover_tests(${NAME} DISCOVERY_MODE PRE_TEST ${labels})
endfunction()
