# Manual pages and completion of shells, written by the program of this build and installed with it.
# Called once, after the program. Not with sanitizers: what is instrumented is not for users.
function(orbweave_install_pages)
  if(CMAKE_CXX_FLAGS MATCHES "-fsanitize")
    return()
  endif()
  find_program(ORBWEAVE_GZIP gzip)
  set(to ${PROJECT_BINARY_DIR}/share)
  add_custom_command(OUTPUT ${to}/pages.stamp
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:orbweave> -DTO=${to} -DGZIP=$<$<BOOL:${ORBWEAVE_GZIP}>:${ORBWEAVE_GZIP}>
            -P ${PROJECT_SOURCE_DIR}/cmake/write_pages.cmake
    COMMAND ${CMAKE_COMMAND} -E touch ${to}/pages.stamp
    DEPENDS orbweave ${PROJECT_SOURCE_DIR}/cmake/write_pages.cmake
    COMMENT "Writing manual pages and completion" VERBATIM)
  add_custom_target(orbweave_pages ALL DEPENDS ${to}/pages.stamp)
  install(DIRECTORY ${to}/man/man1/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/man/man1 COMPONENT program
          PATTERN "orbweave-mpi.1*" EXCLUDE)
  if(TARGET MPI::MPI_CXX)
    install(DIRECTORY ${to}/man/man1/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/man/man1 COMPONENT mpi
            FILES_MATCHING PATTERN "orbweave-mpi.1*")
  endif()
  foreach(part bash-completion/completions zsh/vendor-completions fish/vendor_completions.d)
    install(DIRECTORY ${to}/${part}/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/${part} COMPONENT program)
  endforeach()
endfunction()
