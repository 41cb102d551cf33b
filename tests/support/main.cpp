#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>

// Tests that damage stored results need this:
// HDF5 1.10 loses some hundred bytes whenever it refuses a damaged file; not ours to mend.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
