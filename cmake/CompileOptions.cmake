# Warnings, optimisation and sanitizers in one interface target, so that third-party code keeps its own flags.
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
add_library(simgap_options INTERFACE)
# Who only builds the program (scripts/demo) needs no warnings, which cost a compiler some of its time, too.
if(SIMGAP_WERROR)
  target_compile_options(simgap_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    -Werror)
else()
  target_compile_options(simgap_options INTERFACE -w)
endif()
# libstdc++ silences what GCC 12 invents about std::string (bug 105651) by pragmas, which precompiled headers forget; about
# Eigen's expressions it invents the last two where several files are compiled as one. clang-tidy and the sanitizers look
# for the same faults.
target_compile_options(simgap_options INTERFACE
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-array-bounds;-Wno-free-nonheap-object;-Wno-use-after-free>)
# GCC tidies up its memory hundreds of times where several files are compiled as one: a sixth of its time, for 10 % less.
add_compile_options($<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=600000>)
# Results must be bit-identical on every machine of an architecture: no contraction into fused multiply-adds.
target_compile_options(simgap_options INTERFACE -ffp-contract=off)
if(SIMGAP_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
  # Asked at every reference, these keep Eigen's expressions from being inlined (a loop of small ones takes 25 times as
  # long); what goes wrong with such a reference the address sanitizer sees where it is used. Fuzzing keeps them.
  if(NOT SIMGAP_FUZZ)
    add_compile_options(-fno-sanitize=null,alignment,object-size,pointer-overflow)
  endif()
  # Eigen brings an aligned malloc of its own where it sees this sanitizer; pagmo and DART, compiled without, would free
  # what ours allocated. The sanitizer's malloc aligns to 16 bytes.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
  # What GCC 12 invents about std::regex between instrumented instructions.
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()
if(SIMGAP_FUZZ)  # coverage everywhere, the fuzzer itself in its targets
  set(third_party ${CMAKE_SOURCE_DIR}/tests/fuzz/third_party.txt)
  add_compile_options(-fsanitize=fuzzer-no-link -fsanitize-ignorelist=${third_party}
    -fsanitize-coverage-ignorelist=${third_party})
endif()
# Third-party headers are not ours to warn about.
foreach(target Eigen3::Eigen fmt::fmt spdlog::spdlog nlohmann_json::nlohmann_json yaml-cpp CLI11::CLI11 TBB::tbb)
  get_target_property(directories ${target} INTERFACE_INCLUDE_DIRECTORIES)
  if(directories)
    set_target_properties(${target} PROPERTIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${directories}")
  endif()
endforeach()
include_directories(SYSTEM ${bullet_INCLUDE_DIRS} ${OpenCV_INCLUDE_DIRS})
