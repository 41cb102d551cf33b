# Flags every target shares. FP contraction is off everywhere: the same decision must fall on
# every machine, whatever its vector width (docs/dev/canonical-order.md).
function(orbweave_target target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                         -Wno-sign-conversion -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC 12 warns about its own std::string (bug 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  if(PROJECT_IS_TOP_LEVEL)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                             $<INSTALL_INTERFACE:include>)
endfunction()

# The standard headers that most sources include, for builds that CI makes again and again with
# Clang: a third of the time of such a build goes to reading and instantiating them. GCC gains too
# little, and GCC 12 warns inside its own headers then.
option(ORBWEAVE_PRECOMPILED_HEADERS "Read standard headers once per build (Clang)" OFF)
set(orbweave_standard_headers <algorithm> <array> <atomic> <chrono> <cmath> <filesystem> <fstream>
    <functional> <iostream> <map> <memory> <mutex> <numbers> <optional> <random> <span> <sstream>
    <string> <thread> <unordered_map> <variant> <vector>)

# orbweave_precompile(NAME HEADERS...): a target for orbweave_precompiled, with headers of its own.
function(orbweave_precompile name)
  if(ORBWEAVE_PRECOMPILED_HEADERS)
    file(WRITE ${PROJECT_BINARY_DIR}/${name}.cpp "")
    add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/${name}.cpp)
    orbweave_target(${name})
    target_precompile_headers(${name} PRIVATE ${orbweave_standard_headers} ${ARGN})
  endif()
endfunction()

# orbweave_precompiled(TARGET NAME): the target's sources use the headers of NAME. Both have the
# same compile options.
function(orbweave_precompiled target name)
  if(ORBWEAVE_PRECOMPILED_HEADERS)
    target_precompile_headers(${target} REUSE_FROM ${name})
  endif()
endfunction()
