// One fault of the file system in each flush and rename of a job: the run ends well or says what
// went wrong, and the repeated command ends with the same bytes and leaves nothing behind.
#include "tests/faults/faulty_runs.h"

#include <catch2/catch.hpp>

using orbweave::test::try_faults;

TEST_CASE("OneFailedFlushIsToldAndTheRepeatedCommandMakesTheSameBytes", "[soak]") {
  try_faults("sync", "eio");
}

TEST_CASE("OneRenameThatFailsIsToldAndTheRepeatedCommandMakesTheSameBytes", "[soak]") {
  try_faults("rename", "eio");
}

TEST_CASE("OneRenameThatLeavesHalfAFileIsToldAndTheRepeatedCommandMakesTheSameBytes") {
  try_faults("rename", "torn");
}
