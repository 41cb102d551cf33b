// For the program that tests run, in builds with the address sanitizer.
#include "tests/support/leaks_of_hdf5.h"
