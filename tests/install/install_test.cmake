# cmake -DBUILD=… -DPREFIX=… -DCOMPILER=… -DSOURCE=… -P install_test.cmake
# Installs the project into an empty prefix, compiles a controller against it and runs it; then the installed program.
file(REMOVE_RECURSE ${PREFIX})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX})
foreach(file include/simgap/model/actuator/feed_forward.h include/simgap/model/actuator/pam.h lib/simgap/libsimgap_images.so
    lib/simgap/libsimgap_cma_es.so)
  if(NOT EXISTS ${PREFIX}/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()
run(${COMPILER} -std=c++20 -Wall -Wextra -Werror -I${PREFIX}/include ${SOURCE} -o ${PREFIX}/controller)
run(${PREFIX}/controller)
run(${PREFIX}/bin/simgap --version)
