# What `cmake --install` exports: find_package(simgap) gives simgap::controller, the headers a controller needs. They have
# no dependencies, so that the package has none either.
include(CMakePackageConfigHelpers)
add_library(simgap_controller INTERFACE)
add_library(simgap::controller ALIAS simgap_controller)
set_target_properties(simgap_controller PROPERTIES EXPORT_NAME controller)
target_compile_features(simgap_controller INTERFACE cxx_std_20)
target_sources(simgap_controller INTERFACE FILE_SET HEADERS BASE_DIRS include
  FILES include/simgap/model/actuator/feed_forward.h include/simgap/model/actuator/pam.h)
install(TARGETS simgap_controller EXPORT simgap FILE_SET HEADERS DESTINATION include)

set(package_directory lib/cmake/simgap)
install(EXPORT simgap NAMESPACE simgap:: FILE simgapConfig.cmake DESTINATION ${package_directory})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/simgapConfigVersion.cmake VERSION ${PROJECT_VERSION}
  COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${CMAKE_BINARY_DIR}/simgapConfigVersion.cmake DESTINATION ${package_directory})
