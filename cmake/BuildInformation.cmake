# Version and git hash, and files embedded into the program (report templates, Chart.js, three.js).
execute_process(COMMAND git rev-parse --short=12 HEAD WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}
  OUTPUT_VARIABLE SIMGAP_GIT_HASH OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT SIMGAP_GIT_HASH)
  set(SIMGAP_GIT_HASH unknown)
endif()
if(EXISTS ${CMAKE_SOURCE_DIR}/.git/logs/HEAD)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/.git/logs/HEAD)
endif()
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/simgap/version.h @ONLY CONTENT
"#pragma once
namespace simgap {
inline constexpr char kVersion[] = \"@PROJECT_VERSION@\";
inline constexpr char kGitHash[] = \"@SIMGAP_GIT_HASH@\";
}  // namespace simgap
")
include_directories(${CMAKE_BINARY_DIR}/generated)

# Writes each asset into a C++ array that the target can read through simgap/report/html/assets.h.
function(simgap_embed_assets target)
  set(libraries ${CHART_JS} ${THREE_JS} ${ORBIT_CONTROLS_JS})
  set(assets chart_js=${CHART_JS} three_js=${THREE_JS} orbit_controls_js=${ORBIT_CONTROLS_JS})
  file(GLOB embedded CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/src/report/html/templates/*)
  foreach(config calibrate_arm calibrate_lines calibrate_motions)
    list(APPEND embedded ${CMAKE_SOURCE_DIR}/configs/${config}.yaml)
  endforeach()
  foreach(file ${embedded})
    get_filename_component(name ${file} NAME)
    string(REPLACE "." "_" name ${name})
    list(APPEND assets ${name}=${file})
  endforeach()
  set(output ${CMAKE_BINARY_DIR}/generated/assets.cpp)
  add_custom_command(OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DASSETS=${assets}" -DOUTPUT=${output} -P ${CMAKE_SOURCE_DIR}/cmake/EmbedAssets.cmake
    DEPENDS ${embedded} ${libraries} ${CMAKE_SOURCE_DIR}/cmake/EmbedAssets.cmake VERBATIM)
  target_sources(${target} PRIVATE ${output})
  set_source_files_properties(${output} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON COMPILE_OPTIONS -Wno-overlength-strings)
endfunction()
