# Install and export. Two components: "core" (points in memory to meshes in memory; needs TBB) and
# "pipeline" (files, jobs; needs all packages). Their public headers are listed here, each with the
# name that programs include it by: <orbweave/NAME>. No other header is installed. CMake's install
# components are the packages (cmake/OrbweavePackages.cmake): program, library, mpi, python.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(ORBWEAVE_CORE_HEADERS
  engine/reconstruct.h              reconstruct.h
  io/box.h                          box.h
  io/error.h                        error.h
  io/surface_options.h              surface_options.h
  io/point_cloud.h                  point_cloud.h
  io/points/dropped_points.h        dropped_points.h
  io/hole_facts.h                   hole_facts.h
  io/mesh_facts.h                   mesh_facts.h
  io/open_reason.h                  open_reason.h
  io/scalar_types.h                 scalar_types.h
  io/stop_token.h                   stop_token.h
  io/triangle_mesh.h                triangle_mesh.h
  io/vec3.h                         vec3.h
)
set(ORBWEAVE_PIPELINE_HEADERS
  engine/run_job.h                  run_job.h
  io/clouds/open_point_source.h     open_point_source.h
  io/clouds/scan_source.h           scan_source.h
  io/clouds/text_layout.h           text_layout.h
  io/job/job.h                      job.h
  io/meshes/mesh_reader.h           mesh_reader.h
  io/meshes/mesh_writer.h           mesh_writer.h
  io/points/point_source.h          point_source.h
  io/points/scan_pose.h             scan_pose.h
  io/report/progress.h              progress.h
  io/report/machine.h               machine.h
  io/report/report_facts.h          report_facts.h
  io/report/report.h                report.h
)

# Copies public headers to the build tree's include/orbweave, with their #include lines as programs
# outside the tree have to write them, and installs them from there. A public header that includes a
# private one ends the configuration.
function(orbweave_install_headers)
  set(headers ${ORBWEAVE_CORE_HEADERS})
  if(ORBWEAVE_PIPELINE)
    list(APPEND headers ${ORBWEAVE_PIPELINE_HEADERS})
  endif()
  set(pairs ${headers})
  while(pairs)
    list(POP_FRONT pairs source name)
    file(READ ${PROJECT_SOURCE_DIR}/${source} text)
    set(known ${headers})
    while(known)
      list(POP_FRONT known other other_name)
      string(REPLACE "#include \"${other}\"" "#include <orbweave/${other_name}>" text "${text}")
    endwhile()
    if(text MATCHES "#include \"([^\"]*)\"")
      message(FATAL_ERROR "the public header ${source} includes ${CMAKE_MATCH_1}, which is not public")
    endif()
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/include/orbweave/${name} CONTENT "${text}" @ONLY)
    set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    install(FILES ${PROJECT_BINARY_DIR}/include/orbweave/${name}
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/orbweave COMPONENT library)
  endwhile()
endfunction()

# orbweave_install_library(orbweave_engine pipeline pipeline): the target becomes orbweave::pipeline,
# inside the tree and out of it, in that component. Packages that only .cpp files include and that
# have nothing to link go to target_link_libraries as $<BUILD_INTERFACE:...>: users need not have them.
function(orbweave_install_library target name component)
  add_library(orbweave::${name} ALIAS ${target})
  # With BUILD_SHARED_LIBS: versions that may differ in their interface differ in their soname.
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  if(ORBWEAVE_HAS_PYTHON)
    # The module is a shared object. No function is replaced at load time, so that calls and inlining
    # stay what they are in a program.
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_compile_options(${target} PRIVATE -fno-semantic-interposition)
  endif()
  install(TARGETS ${target} EXPORT orbweave_${component}_targets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
endfunction()

# The package files; called once, after all libraries.
function(orbweave_install_package)
  orbweave_install_headers()
  set(where ${CMAKE_INSTALL_LIBDIR}/cmake/orbweave)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/orbweaveConfig.cmake.in
    ${PROJECT_BINARY_DIR}/orbweaveConfig.cmake INSTALL_DESTINATION ${where})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/orbweaveConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/orbweaveConfig.cmake
    ${PROJECT_BINARY_DIR}/orbweaveConfigVersion.cmake DESTINATION ${where} COMPONENT library)
  install(EXPORT orbweave_core_targets NAMESPACE orbweave:: FILE orbweaveCoreTargets.cmake
          DESTINATION ${where} COMPONENT library)
  if(ORBWEAVE_PIPELINE)
    install(EXPORT orbweave_pipeline_targets NAMESPACE orbweave:: FILE orbweavePipelineTargets.cmake
            DESTINATION ${where} COMPONENT library)
    install(FILES ${PROJECT_SOURCE_DIR}/cmake/FindHdf5Core.cmake
      ${PROJECT_SOURCE_DIR}/cmake/FindOpenVdbCore.cmake ${PROJECT_SOURCE_DIR}/cmake/FindXxHash.cmake
      ${PROJECT_SOURCE_DIR}/cmake/FindProjCore.cmake
      DESTINATION ${where} COMPONENT library)
  endif()
  orbweave_install_documents()
endfunction()

# The README and all that it points to, side by side as in the source tree.
function(orbweave_install_documents)
  foreach(document README.md CHANGELOG.md CITATION.cff CONTRIBUTING.md LICENSE SECURITY.md)
    install(FILES ${PROJECT_SOURCE_DIR}/${document} DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
  endforeach()
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DOCDIR}
          COMPONENT program)
endfunction()
