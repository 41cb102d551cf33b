// Temporary files without a name.
#include "io/system/spool_file.h"

#include <fcntl.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>

#include "io/system/file_descriptor.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using namespace orbweave;
using test::ScratchDirectory;

namespace {

bool has_nameless_files(const ScratchDirectory& scratch) {
  return FileDescriptor(::open(scratch.path().c_str(), O_TMPFILE | O_RDWR, 0600)).valid();
}

}  // namespace

TEST_CASE("ASpoolFileHasNoNameAtAnyTimeSoThatAKillLeavesNone") {
  const ScratchDirectory scratch;
  if (!has_nameless_files(scratch)) {
    WARN("the file system has no files without a name");
    return;
  }
  const FileDescriptor watch(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
  REQUIRE(::inotify_add_watch(watch.get(), scratch.path().c_str(), IN_CREATE) >= 0);
  SpoolFile file(scratch.path());
  const std::array<int, 3> values = {4, 5, 6};
  const std::uint64_t offset = file.append_values(std::span<const int>(values));
  std::array<int, 3> back{};
  file.read_values(offset, std::span<int>(back));
  CHECK(back == values);
  std::array<char, 4096> events{};
  CHECK(::read(watch.get(), events.data(), events.size()) == -1);
  CHECK(test::names_in(scratch).empty());
}
