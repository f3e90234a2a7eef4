# What `cmake --install` exports: find_package(simgap) gives simgap::controller, the headers a controller needs, and
# simgap::arm, an arm as an internal model. Both need nothing but the standard library, so that the package has no
# dependencies either.
include(CMakePackageConfigHelpers)
add_library(simgap_controller INTERFACE)
add_library(simgap::controller ALIAS simgap_controller)
set_target_properties(simgap_controller PROPERTIES EXPORT_NAME controller)
target_compile_features(simgap_controller INTERFACE cxx_std_20)
target_sources(simgap_controller INTERFACE FILE_SET HEADERS BASE_DIRS include
  FILES include/simgap/model/actuator/feed_forward.h include/simgap/model/actuator/pam.h
        include/simgap/model/actuator/trajectory_control.h
        include/simgap/model/actuator/torque_split.h include/simgap/model/actuator/vertical_assist.h)
install(TARGETS simgap_controller EXPORT simgap FILE_SET HEADERS DESTINATION include)
add_library(simgap::arm ALIAS simgap_arm)
set_target_properties(simgap_arm PROPERTIES EXPORT_NAME arm)
target_compile_features(simgap_arm INTERFACE cxx_std_20)
target_sources(simgap_arm INTERFACE FILE_SET HEADERS BASE_DIRS include FILES include/simgap/simulate/arm.h)
install(TARGETS simgap_arm EXPORT simgap LIBRARY DESTINATION lib FILE_SET HEADERS DESTINATION include)

set(package_directory lib/cmake/simgap)
install(EXPORT simgap NAMESPACE simgap:: FILE simgapConfig.cmake DESTINATION ${package_directory})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/simgapConfigVersion.cmake VERSION ${PROJECT_VERSION}
  COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${CMAKE_BINARY_DIR}/simgapConfigVersion.cmake DESTINATION ${package_directory})

# Man pages and completion, from the commands as the program holds them.
set(shell_files ${CMAKE_BINARY_DIR}/shell-files)
add_custom_command(OUTPUT ${shell_files}/stamp COMMAND simgap --write-shell-files ${shell_files}/share
  COMMAND ${CMAKE_COMMAND} -E touch ${shell_files}/stamp DEPENDS simgap VERBATIM)
add_custom_target(shell_files ALL DEPENDS ${shell_files}/stamp)
install(DIRECTORY ${shell_files}/share/ DESTINATION share)
install(FILES LICENSE DESTINATION share/doc/simgap RENAME copyright)
install(FILES README.md CHANGELOG.md CITATION.cff DESTINATION share/doc/simgap)
install(FILES python/simgap.py DESTINATION lib/python3/dist-packages)
install(FILES python/example.py python/example_arrays.py DESTINATION share/doc/simgap/examples)
install(DIRECTORY data configs DESTINATION share/doc/simgap/examples)

# `cpack` makes a Debian package, whose dependencies are the libraries that the program and its modules were linked with.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR simgap)
set(CPACK_PACKAGE_CONTACT "the simgap authors <simgap@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "openmpi-bin, python3-numpy, man-db, bash-completion")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "calibrates and diagnoses simulations of tendon-driven robots
 From stereo images to joint angles, from logs to friction and motor parameters, from recorded poses to a calibrated arm,
 every number with its uncertainty and judged on data that the fit has not seen.")
include(CPack)
