# cmake -D BUILD=<build tree> -D SOURCE=<source tree> -D OUT=<scratch> -D CXX=… -D CXX_FLAGS=… -P install_test.cmake
# Installs the build tree, moves what was installed elsewhere, and links against it there, found by CMake and by pkg-config.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}: ${status}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(prefix ${OUT}/elsewhere)
set(trunnion ${prefix}/bin/trunnion)
set(inputs ${prefix}/share/trunnion/samples/calibrate/machine.toml ${prefix}/share/trunnion/samples/calibrate/replica.csv)
set(position ${prefix}/share/trunnion/samples/calibrate/positions.csv)
set(configure ${CMAKE_COMMAND} -G Ninja -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${CXX} -D
  "CMAKE_CXX_FLAGS=${CXX_FLAGS}")

# check_consumer(PROGRAM): the deviations by its model are those by the model of the installed program.
function(check_consumer PROGRAM)
  run(${PROGRAM} ${inputs} ${OUT}/of_library.json)
  message(STATUS "${PROGRAM}\n${output}")
  list(GET inputs 0 machine)
  list(GET inputs 1 observations)
  run(${trunnion} identify --machine ${machine} --observations ${observations} -o ${OUT}/of_program.json)
  foreach(model of_library of_program)
    run(${trunnion} evaluate --machine ${machine} --model ${OUT}/${model}.json --at ${position} -o ${OUT}/${model}.csv)
    file(STRINGS ${OUT}/${model}.csv ${model} REGEX "^[^#]")
  endforeach()
  if(NOT of_library STREQUAL of_program OR of_library STREQUAL "")
    message(FATAL_ERROR "${PROGRAM}: its model evaluates to\n${of_library}\nthat of the program to\n${of_program}")
  endif()
  file(REMOVE ${OUT}/of_library.json)
endfunction()

file(REMOVE_RECURSE ${OUT})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${OUT}/prefix)
file(RENAME ${OUT}/prefix ${prefix})

run(${configure} -S ${SOURCE}/samples/library -B ${OUT}/build)
run(${CMAKE_COMMAND} --build ${OUT}/build)
check_consumer(${OUT}/build/calibrate)

execute_process(COMMAND ${configure} -S ${SOURCE}/tests/install/missing_part -B ${OUT}/missing_part
  RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE output)
if(status EQUAL 0 OR NOT output MATCHES "the parts are.*model")
  message(FATAL_ERROR "a part that there is not: ${status}\n${output}")
endif()

find_program(pkg_config NAMES pkg-config pkgconf)
if(NOT pkg_config)
  message(STATUS "no pkg-config here: what it would say is not tested")
  return()
endif()
file(GLOB_RECURSE pc_folder ${prefix}/*/trunnion.pc)
cmake_path(GET pc_folder PARENT_PATH pc_folder)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
run(sh -c "${CXX} ${CXX_FLAGS} -std=c++20 ${SOURCE}/samples/library/calibrate.cpp $(${pkg_config} --cflags --libs trunnion-io) -o ${OUT}/calibrate")
check_consumer(${OUT}/calibrate)

# Every header that is installed can be included, with nothing but what pkg-config says.
file(GLOB_RECURSE headers RELATIVE ${prefix}/include/trunnion ${prefix}/include/trunnion/*.h)
list(TRANSFORM headers PREPEND "#include \"")
list(TRANSFORM headers APPEND "\"")
list(JOIN headers "\n" headers)
file(WRITE ${OUT}/all_headers.cpp "${headers}\nint main() {}\n")
run(sh -c "${CXX} -std=c++20 -O2 ${OUT}/all_headers.cpp $(${pkg_config} --cflags --libs trunnion) -o ${OUT}/all_headers")
