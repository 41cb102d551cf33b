# Defines Proj::proj, the coordinate systems of PROJ. Its own package file asks for CURL as well, which
# only a static PROJ needs.
find_path(Proj_INCLUDE_DIR proj.h)
find_library(Proj_LIBRARY proj)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ProjCore DEFAULT_MSG Proj_LIBRARY Proj_INCLUDE_DIR)
if(ProjCore_FOUND AND NOT TARGET Proj::proj)
  add_library(Proj::proj UNKNOWN IMPORTED)
  set_target_properties(Proj::proj PROPERTIES IMPORTED_LOCATION ${Proj_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES ${Proj_INCLUDE_DIR})
endif()
mark_as_advanced(Proj_INCLUDE_DIR Proj_LIBRARY)
