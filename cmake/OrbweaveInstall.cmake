# Install and export: headers keep their folders below include/orbweave, so that a program outside
# the tree writes the same #include lines as the libraries themselves.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# orbweave_install_library(orbweave_io): the target of this folder becomes orbweave::io, inside the
# tree and out of it, and its headers are installed. Packages that only .cpp files include and that
# have nothing to link go to target_link_libraries as $<BUILD_INTERFACE:...>: users need not have them.
function(orbweave_install_library target)
  string(REGEX REPLACE "^orbweave_" "" name ${target})
  add_library(orbweave::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS ${target} EXPORT orbweaveTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/orbweave/${name}
          FILES_MATCHING PATTERN "*.h" PATTERN cli EXCLUDE PATTERN mpi_team.h EXCLUDE)
endfunction()

# The package files; called once, after all libraries.
function(orbweave_install_package)
  set(where ${CMAKE_INSTALL_LIBDIR}/cmake/orbweave)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/orbweaveConfig.cmake.in
    ${PROJECT_BINARY_DIR}/orbweaveConfig.cmake INSTALL_DESTINATION ${where})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/orbweaveConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(EXPORT orbweaveTargets NAMESPACE orbweave:: DESTINATION ${where})
  install(FILES ${PROJECT_BINARY_DIR}/orbweaveConfig.cmake
    ${PROJECT_BINARY_DIR}/orbweaveConfigVersion.cmake ${PROJECT_SOURCE_DIR}/cmake/FindHdf5Core.cmake
    ${PROJECT_SOURCE_DIR}/cmake/FindOpenVdbCore.cmake ${PROJECT_SOURCE_DIR}/cmake/FindXxHash.cmake
    DESTINATION ${where})
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md
          ${PROJECT_SOURCE_DIR}/docs/licence.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
endfunction()
