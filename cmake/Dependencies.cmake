# Builds that keep assertions on have no build type; CGAL need not warn of it.
set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE TRUE)

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(CLI11 CONFIG REQUIRED)
find_package(tomlplusplus CONFIG REQUIRED)
find_package(nlohmann_json 3.11 CONFIG REQUIRED)
find_package(Boost 1.74 CONFIG REQUIRED)

# The compiled toml++, not the header-only parser: four seconds a file less.
add_library(trunnion_toml INTERFACE)
target_link_libraries(trunnion_toml INTERFACE tomlplusplus::tomlplusplus)
target_compile_definitions(trunnion_toml INTERFACE TOML_HEADER_ONLY=0)
