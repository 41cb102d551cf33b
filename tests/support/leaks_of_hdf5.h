// Included once by a program: the leak sanitizer asks for these functions.
//
// HDF5 1.10 loses some hundred bytes whenever it refuses a damaged file; not ours to mend. Tests
// that damage stored results need this, and some look at all that the program says.
#pragma once

extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
