# cmake -D BUILD=<build tree> -D SOURCE=<this folder> -D OUT=<scratch> -P install_test.cmake
# Installs the build tree into OUT and builds and runs the consumer against it.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}: ${status}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${OUT})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${OUT}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${OUT}/build -G Ninja -D CMAKE_PREFIX_PATH=${OUT}/prefix -D CMAKE_CXX_COMPILER=${CXX}
  -D "CMAKE_CXX_FLAGS=${CXX_FLAGS}")
run(${CMAKE_COMMAND} --build ${OUT}/build)
run(${OUT}/build/consumer)
message(STATUS "${output}")
