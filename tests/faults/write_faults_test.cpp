// One fault of the file system in each write of a job. The three effects take turns, so that every
// write has one and every kind of file has all.
#include "tests/faults/faulty_runs.h"

#include <catch2/catch.hpp>

using orbweave::test::try_faults;

TEST_CASE("OneShortWriteIsMadeUpForOrToldAndTheRepeatedCommandMakesTheSameBytes") {
  try_faults("write", "short", 1, 3);
}

TEST_CASE("ADiskThatIsFullFromAnyWriteOnIsToldAndTheRepeatedCommandMakesTheSameBytes") {
  try_faults("write", "full", 2, 3);
}

TEST_CASE("OneWriteThatFailsIsToldAndTheRepeatedCommandMakesTheSameBytes") {
  try_faults("write", "eio", 3, 3);
}
