# cmake -DBUILD=… -DPREFIX=… -DCONSUMER=… -DCOMPILER=… -DVERSION=… -P install_test.cmake
# Installs the project into an empty prefix, builds a controller with the installed package and runs it; then the
# installed program.
file(REMOVE_RECURSE ${PREFIX})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX})
foreach(file include/simgap/model/actuator/feed_forward.h include/simgap/model/actuator/pam.h include/simgap/simulate/arm.h
    lib/libsimgap_arm.so lib/simgap/libsimgap_images.so
    lib/simgap/libsimgap_cma_es.so lib/simgap/libsimgap_mpi.so lib/cmake/simgap/simgapConfig.cmake lib/cmake/simgap/simgapConfigVersion.cmake)
  if(NOT EXISTS ${PREFIX}/${file})
    message(FATAL_ERROR "${file} was not installed")
  endif()
endforeach()
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${PREFIX}/consumer -DCMAKE_PREFIX_PATH=${PREFIX} -DCMAKE_CXX_COMPILER=${COMPILER}
  -DSIMGAP_VERSION=${VERSION})
run(${CMAKE_COMMAND} --build ${PREFIX}/consumer)
run(${PREFIX}/consumer/controller)
run(${PREFIX}/consumer/internal_model ${SOURCE}/data/arm/arm.yaml)
# Without its modules it fails: it must not look for them where it was built, where anybody could have put others.
if(DEFINED ENV{TMPDIR})
  set(stray $ENV{TMPDIR}/simgap-stray)
else()
  set(stray /tmp/simgap-stray)
endif()
file(REMOVE_RECURSE ${stray})
file(COPY ${PREFIX}/bin/simgap DESTINATION ${stray})
execute_process(COMMAND ${stray}/simgap calibrate-cameras ${SOURCE}/data/capture/left ${SOURCE}/data/capture/right
  --board chessboard:9x6:0.025 RESULT_VARIABLE code ERROR_VARIABLE output WORKING_DIRECTORY ${stray})
if(NOT code EQUAL 2 OR NOT output MATCHES "simgap: a part of the program cannot be loaded: ${stray}/../lib/simgap")
  message(FATAL_ERROR "a program without modules ended with ${code}: ${output}")
endif()
file(REMOVE_RECURSE ${stray})
run(${PREFIX}/bin/simgap --version)
if(NOT output MATCHES "^simgap ${VERSION} ")
  message(FATAL_ERROR "the program says '${output}', expected version ${VERSION}")
endif()
