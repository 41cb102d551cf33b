#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "io/system/hdf5_exit.h"
#include "tests/support/leaks_of_hdf5.h"

int main(int argc, char** argv) {
  orbweave::close_hdf5_at_exit();
  return Catch::Session().run(argc, argv);
}
