# A registry is written from one or more folders: every file NAME.cpp in it must define
#     namespace simgap::<NAMESPACE>::NAME { extern const <TYPE> entry; }
# (a namespace of its own: several entries are compiled as one, whatever their helpers are called), and the generated file
# defines   std::span<const TYPE* const> simgap::<NAMESPACE>::all().
# Adding an entry is adding one file; the linker cannot drop it, because the generated table names it.
function(simgap_registry target)
  cmake_parse_arguments(arg "" "TYPE;HEADER;NAMESPACE" "FOLDER" ${ARGN})
  list(TRANSFORM arg_FOLDER REPLACE "(.+)" "${CMAKE_SOURCE_DIR}/\\1/*.cpp" OUTPUT_VARIABLE patterns)
  file(GLOB files CONFIGURE_DEPENDS ${patterns})
  set(declarations "")
  set(entries "")
  foreach(file ${files})
    get_filename_component(name ${file} NAME_WE)
    string(APPEND declarations "namespace ${name} { extern const ${arg_TYPE} entry; }\n")
    string(APPEND entries "    &${name}::entry,\n")
  endforeach()
  list(LENGTH files count)
  set(output ${CMAKE_BINARY_DIR}/registry/${arg_NAMESPACE}.cpp)
  file(CONFIGURE OUTPUT ${output} CONTENT
"// Written by CMake from ${arg_FOLDER}; do not edit.
#include \"${arg_HEADER}\"
namespace simgap::${arg_NAMESPACE} {
${declarations}static constexpr const ${arg_TYPE}* kAll[] = {
${entries}};
std::span<const ${arg_TYPE}* const> all() { return kAll; }
}  // namespace simgap::${arg_NAMESPACE}
")
  target_sources(${target} PRIVATE ${output})
endfunction()
