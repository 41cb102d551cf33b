# Debian packages, one for each component of the installation; .ci/packages configures, packs and tries
# them. Packages are made where ORBWEAVE_PACKAGES is on, with /usr as the prefix. A program that holds the
# Voronoi family is under the GPL, and a package of its own name.
option(ORBWEAVE_PACKAGES "Make Debian packages (cpack)" OFF)
if(NOT ORBWEAVE_PACKAGES)
  return()
endif()
set(ORBWEAVE_PACKAGE_VERSION ${PROJECT_VERSION} CACHE STRING "Version of the Debian packages")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME orbweave)
set(CPACK_PACKAGE_VENDOR orbweave)
set(CPACK_PACKAGE_CONTACT "The orbweave authors <orbweave@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VERSION ${ORBWEAVE_PACKAGE_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_VERSION ${ORBWEAVE_PACKAGE_VERSION})
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)

# orbweave_package(COMPONENT NAME SUMMARY TEXT): copyright and changelog lie where Debian looks.
function(orbweave_package component name summary text)
  set(license MPL-2.0)
  if(name STREQUAL "orbweave-voronoi")
    set(license "MPL-2.0, and as a whole with CGAL GPL-3.0-or-later")
  endif()
  string(TIMESTAMP year "%Y" UTC)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  set(dir ${PROJECT_BINARY_DIR}/packages/${name})
  file(CONFIGURE OUTPUT ${dir}/copyright CONTENT [[
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: orbweave

Files: *
Copyright: @year@ The orbweave authors
License: MPL-2.0
Comment: This package is distributed under @license@.

License: MPL-2.0
 On Debian systems the text is in /usr/share/common-licenses/MPL-2.0; that of the GPL is in
 /usr/share/common-licenses/GPL-3.
]] @ONLY)
  file(CONFIGURE OUTPUT ${dir}/changelog CONTENT [[
orbweave (@ORBWEAVE_PACKAGE_VERSION@) unstable; urgency=medium

  * CHANGELOG.md of the package orbweave says what changed.

 -- @CPACK_PACKAGE_CONTACT@  @date@
]] @ONLY)
  find_program(ORBWEAVE_GZIP gzip REQUIRED)
  execute_process(COMMAND ${ORBWEAVE_GZIP} -9nfk ${dir}/changelog COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${dir}/copyright ${dir}/changelog.gz DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${name}
          COMPONENT ${component})
  string(TOUPPER ${component} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} PARENT_SCOPE)
endfunction()

set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS proj-data)
if(ORBWEAVE_HAS_VORONOI)
  # One program: everything else is the same in both builds.
  orbweave_package(program orbweave-voronoi "surface reconstruction, with the Voronoi family"
    "Turns point clouds of any size into one seamless triangle mesh. This build\nhas the methods of the Voronoi family, on CGAL, and is under the GPL.")
  foreach(relation PROVIDES CONFLICTS REPLACES)
    set(CPACK_DEBIAN_PROGRAM_PACKAGE_${relation} orbweave)
  endforeach()
  include(CPack)
  return()
endif()
orbweave_package(program orbweave "parallel, out-of-core surface reconstruction"
  "Turns point clouds of any size into one seamless triangle mesh, in parallel\nand in bounded memory.")

orbweave_package(library liborbweave-dev "surface reconstruction, libraries and headers"
  "Points in memory to a mesh in memory, and jobs on files of any size, from C++.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "libtbb-dev, libhdf5-dev, libopenvdb-dev, libboost-dev, libproj-dev, libpugixml-dev, libpng-dev, zlib1g-dev, libspdlog-dev, libxxhash-dev, libmeshoptimizer-dev")

if(TARGET MPI::MPI_CXX)
  orbweave_package(mpi orbweave-mpi "surface reconstruction by several machines"
    "The program orbweave for jobs that several processes share through MPI.")
  set(CPACK_DEBIAN_MPI_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS openmpi-bin)
endif()

if(ORBWEAVE_HAS_PYTHON)
  orbweave_package(python python3-orbweave "surface reconstruction from Python"
    "Arrays of numpy to a mesh, and jobs on files of any size.")
  math(EXPR next "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next}), python3-numpy")
endif()
include(CPack)
