# `cmake --install`, the exported package (find_package(Trunnion)) and the Debian package.
#
# Components: runtime is what somebody at a machine needs (program, machine files, samples, documents), development what
# somebody needs who links the parts.
include(CMakePackageConfigHelpers)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # a package of the program needs no tests to be built

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

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Trunnion)
install(EXPORT TrunnionTargets NAMESPACE trunnion:: DESTINATION ${package_dir} COMPONENT development)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/TrunnionConfig.cmake.in
  ${PROJECT_BINARY_DIR}/TrunnionConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/TrunnionConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/TrunnionConfig.cmake ${PROJECT_BINARY_DIR}/TrunnionConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT development)

if(TARGET trunnion)
  install(TARGETS trunnion RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/machines ${PROJECT_SOURCE_DIR}/samples
  DESTINATION ${CMAKE_INSTALL_DATADIR}/trunnion COMPONENT runtime
  USE_SOURCE_PERMISSIONS PATTERN demo.sh EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/LICENSE
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME trunnion)
set(CPACK_PACKAGE_VENDOR "Trunnion")
set(CPACK_PACKAGE_CONTACT "Trunnion maintainers <maintainers@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Rotary-axis errors of five-axis machines: identify, correct, verify")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime)  # what links the parts builds them
if(TARGET trunnion_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME trunnion)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-trunnion)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-numpy")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
include(CPack)
