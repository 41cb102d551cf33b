// How HDF5 ends with the program.
#pragma once

namespace orbweave {

/// Takes HDF5's end from HDF5: it would try for ever to close a file on a full disk. Changes HDF5's
/// global state, so it is for main() alone; call it before anything else uses HDF5.
void close_hdf5_at_exit();

}  // namespace orbweave
