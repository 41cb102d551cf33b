// One fault of the file system in each flush and rename of a job, and in reads: the run ends well
// or says what went wrong, and the repeated command ends with the same bytes and leaves nothing
// behind.
#include "tests/faults/faulty_runs.h"

#include <catch2/catch.hpp>
#include <cstdint>

#include "tests/support/sanitized.h"

using orbweave::test::count_flushes;
using orbweave::test::kIsSanitized;
using orbweave::test::try_faults;

namespace {

/// Every call without a sanitizer; under one, which starts programs slowly, each fifth.
constexpr std::uint64_t kStep = kIsSanitized ? 5 : 1;

}  // namespace

TEST_CASE("OfANewWorkDirectoryNothingIsFlushedAtFirstButTheOutputs") {
  constexpr std::uint64_t kFarTooLong = 86400;
  const auto [in_new, in_older] = count_flushes(kFarTooLong);
  // The directory's identity; file and directory of mesh, report and page.
  CHECK(in_new <= 1 + 3 * 2);
  CHECK(in_older > 5 * in_new);
  CHECK(count_flushes(0).in_new > 5 * in_new);
}

TEST_CASE("OneFailedFlushIsToldAndTheRepeatedCommandMakesTheSameBytes", "[soak]") {
  try_faults("sync", "eio", 1, kStep);
}

TEST_CASE("OneRenameThatFailsIsToldAndTheRepeatedCommandMakesTheSameBytes", "[soak]") {
  try_faults("rename", "eio", 1, kStep);
}

TEST_CASE("OneRenameThatLeavesHalfAFileIsToldAndTheRepeatedCommandMakesTheSameBytes") {
  try_faults("rename", "torn", 1, kStep);
}

// Each fourth: a job reads several times as often as it flushes and renames.
TEST_CASE("OneReadThatFailsIsToldAndTheRepeatedCommandMakesTheSameBytes", "[soak]") {
  try_faults("read", "eio", 1, 4 * kStep);
}
