#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "io/system/hdf5_exit.h"

// Tests that damage stored results need this:
// HDF5 1.10 loses some hundred bytes whenever it refuses a damaged file; not ours to mend.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }

int main(int argc, char** argv) {
  orbweave::close_hdf5_at_exit();
  return Catch::Session().run(argc, argv);
}
