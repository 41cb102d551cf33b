# Defines OpenVdb::headers. Debian's FindOpenVDB lives outside the default module path. Only templates are
# used (partition/count_grid.cpp), not the library.
find_path(OpenVdb_INCLUDE_DIR openvdb/openvdb.h)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenVdbCore DEFAULT_MSG OpenVdb_INCLUDE_DIR)
if(OpenVdbCore_FOUND AND NOT TARGET OpenVdb::headers)
  find_package(TBB REQUIRED)
  add_library(OpenVdb::headers INTERFACE IMPORTED)
  set_target_properties(OpenVdb::headers PROPERTIES INTERFACE_LINK_LIBRARIES TBB::tbb
                        INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${OpenVdb_INCLUDE_DIR})
endif()
mark_as_advanced(OpenVdb_INCLUDE_DIR)
