# Defines OpenVdb::openvdb. Debian's FindOpenVDB lives outside the default module path.
find_path(OpenVdb_INCLUDE_DIR openvdb/openvdb.h)
find_library(OpenVdb_LIBRARY openvdb)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenVdbCore DEFAULT_MSG OpenVdb_LIBRARY OpenVdb_INCLUDE_DIR)
if(OpenVdbCore_FOUND AND NOT TARGET OpenVdb::openvdb)
  find_package(TBB REQUIRED)
  add_library(OpenVdb::openvdb UNKNOWN IMPORTED)
  set_target_properties(OpenVdb::openvdb PROPERTIES IMPORTED_LOCATION ${OpenVdb_LIBRARY}
                        INTERFACE_LINK_LIBRARIES TBB::tbb)
  set_property(TARGET OpenVdb::openvdb APPEND PROPERTY
               INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${OpenVdb_INCLUDE_DIR})
endif()
mark_as_advanced(OpenVdb_INCLUDE_DIR OpenVdb_LIBRARY)
