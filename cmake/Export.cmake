# The parts for whoever links them: find_package(Trunnion COMPONENTS part …) and `pkg-config trunnion-PART` (trunnion: all).
include(CMakePackageConfigHelpers)
get_property(parts GLOBAL PROPERTY TRUNNION_PARTS)
list(TRANSFORM parts PREPEND trunnion_ OUTPUT_VARIABLE part_targets)
install(TARGETS ${part_targets} trunnion_toml EXPORT TrunnionTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
foreach(part IN LISTS parts)
  set(folder ${PROJECT_SOURCE_DIR}/src/${part})
  if(NOT EXISTS ${folder})
    set(folder ${PROJECT_SOURCE_DIR}/${part})
  endif()
  install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/trunnion COMPONENT development
    FILES_MATCHING PATTERN "*.h")
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/src/error.h ${PROJECT_SOURCE_DIR}/src/loaded_module.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/trunnion COMPONENT development)

# What parts link of the outside: its arguments of find_package, and its words in a .pc file.
set(outside
  "Eigen3::Eigen|Eigen3 3.4 NO_MODULE|Requires eigen3"
  "nlohmann_json::nlohmann_json|nlohmann_json 3.11 CONFIG|Requires nlohmann_json"
  "trunnion_toml|tomlplusplus CONFIG|Requires tomlplusplus"
  "SQLite::SQLite3|SQLite3|Requires sqlite3"
  "Boost::headers|Boost 1.74 CONFIG|"
  "CGAL::CGAL|CGAL 5.5 CONFIG|Libs -lmpfr -lgmp"
  "Threads::Threads|Threads|Libs -pthread"
  "dl||Libs -ldl")

# trunnion_outside(LIBRARY PACKAGE PC_FIELD PC_WORDS): the row of `outside` for an imported target.
function(trunnion_outside LIBRARY PACKAGE FIELD WORDS)
  foreach(row IN LISTS outside)
    if(row MATCHES "^([^|]*)[|]([^|]*)[|]([A-Za-z]*) ?(.*)$" AND CMAKE_MATCH_1 STREQUAL LIBRARY)
      set(${PACKAGE} "${CMAKE_MATCH_2}" PARENT_SCOPE)
      set(${FIELD} "${CMAKE_MATCH_3}" PARENT_SCOPE)
      set(${WORDS} "${CMAKE_MATCH_4}" PARENT_SCOPE)
      return()
    endif()
  endforeach()
  message(FATAL_ERROR "cmake/Export.cmake: ${LIBRARY}, which a part links, is in no row of `outside`")
endfunction()

# The prefix as seen from the folder of .pc files, so that what was installed may be moved.
set(pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX}/${pkgconfig_dir} OUTPUT_VARIABLE up)
function(trunnion_pkg_config NAME DESCRIPTION REQUIRES LIBS)
  list(JOIN REQUIRES " " REQUIRES)
  list(JOIN LIBS " " LIBS)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/trunnion.pc.in ${PROJECT_BINARY_DIR}/pkgconfig/${NAME}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/pkgconfig/${NAME}.pc DESTINATION ${pkgconfig_dir} COMPONENT development)
endfunction()

set(trunnion_links "")
foreach(part IN LISTS parts)
  get_property(links GLOBAL PROPERTY TRUNNION_PART_${part}_LINK)
  get_property(libraries GLOBAL PROPERTY TRUNNION_PART_${part}_OUTSIDE)
  set(requires ${links})
  list(TRANSFORM requires PREPEND trunnion-)
  set(libs "")
  get_target_property(type trunnion_${part} TYPE)
  if(NOT type STREQUAL INTERFACE_LIBRARY)
    set(libs "-L\${libdir}" -ltrunnion_${part})
  endif()
  string(APPEND trunnion_links "set(trunnion_${part}_links ${links})\nset(trunnion_${part}_packages")
  foreach(library IN LISTS libraries)
    trunnion_outside(${library} package field words)
    if(package)
      string(APPEND trunnion_links " \"${package}\"")
    endif()
    if(field STREQUAL Requires)
      list(APPEND requires ${words})
    elseif(field STREQUAL Libs)
      list(APPEND libs ${words})
    endif()
  endforeach()
  string(APPEND trunnion_links ")\n")
  trunnion_pkg_config(trunnion-${part} "the part ${part} of Trunnion" "${requires}" "${libs}")
endforeach()
list(TRANSFORM parts PREPEND trunnion- OUTPUT_VARIABLE requires)
trunnion_pkg_config(trunnion "all parts of Trunnion" "${requires}" "")

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Trunnion)
install(EXPORT TrunnionTargets NAMESPACE trunnion:: DESTINATION ${package_dir} COMPONENT development)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/TrunnionConfig.cmake.in
  ${PROJECT_BINARY_DIR}/TrunnionConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/TrunnionConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/TrunnionConfig.cmake ${PROJECT_BINARY_DIR}/TrunnionConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT development)
