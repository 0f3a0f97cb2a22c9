# `cmake --install` and the Debian package.
#
# Components: runtime is what somebody at a machine needs (program, machine files, samples, documents), development what
# somebody needs who links the parts.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # a package of the program needs no tests to be built
include(cmake/Export.cmake)

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
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= ${TRUNNION_PYTHON_VERSION}), python3 (<< ${TRUNNION_PYTHON_NEXT}), python3-numpy")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
include(CPack)
