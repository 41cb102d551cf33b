# orbweave_fuzz(NAME SOURCES...): a libFuzzer target in <build>/bin/fuzz, part of "fuzz_targets".
# Nothing unless ORBWEAVE_BUILD_FUZZ is on (preset "fuzz": Clang, everything instrumented). Seeds,
# where there are any, lie in tests/fuzz/seeds/NAME.
function(orbweave_fuzz name)
  if(NOT ORBWEAVE_BUILD_FUZZ)
    return()
  endif()
  add_executable(${name} ${ARGN})
  orbweave_target(${name})
  target_link_options(${name} PRIVATE -fsanitize=fuzzer)
  target_link_libraries(${name} PRIVATE orbweave_engine)
  set_target_properties(${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/fuzz)
  if(NOT TARGET fuzz_targets)
    add_custom_target(fuzz_targets)
  endif()
  add_dependencies(fuzz_targets ${name})
endfunction()
