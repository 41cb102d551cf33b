# Finds CGAL as ORBWEAVE_VORONOI says; where target CGAL::CGAL exists afterwards, orbweave_voronoi is
# built and the methods of the Voronoi family are there. CGAL's triangulations are under the GPL, and
# so is a program that holds them (docs/licence.md).
set(ORBWEAVE_HAS_VORONOI OFF)
if(ORBWEAVE_VORONOI)
  if(ORBWEAVE_VORONOI STREQUAL "AUTO")
    find_package(CGAL 5.4 QUIET)
  else()
    find_package(CGAL 5.4 REQUIRED)
  endif()
  if(TARGET CGAL::CGAL)
    set(ORBWEAVE_HAS_VORONOI ON)
    message(STATUS "orbweave: built with the Voronoi family, on CGAL ${CGAL_VERSION}")
  else()
    message(STATUS "orbweave: built without the Voronoi family, CGAL was not found")
  endif()
endif()
