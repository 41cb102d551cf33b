# Defines Hdf5::hdf5, the serial C library. CMake's own FindHDF5 asks the compiler wrapper, which
# needs the C language enabled in every project that links orbweave.
find_path(Hdf5_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(Hdf5_LIBRARY NAMES hdf5_serial hdf5 PATH_SUFFIXES hdf5/serial)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Hdf5Core DEFAULT_MSG Hdf5_LIBRARY Hdf5_INCLUDE_DIR)
if(Hdf5Core_FOUND AND NOT TARGET Hdf5::hdf5)
  add_library(Hdf5::hdf5 UNKNOWN IMPORTED)
  set_target_properties(Hdf5::hdf5 PROPERTIES IMPORTED_LOCATION ${Hdf5_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES ${Hdf5_INCLUDE_DIR})
endif()
mark_as_advanced(Hdf5_INCLUDE_DIR Hdf5_LIBRARY)
