#include "io/system/memory_limit.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/support/data.h"
#include "tests/support/program.h"

using namespace orbweave;
namespace fs = std::filesystem;
using test::ScratchDirectory;
using test::write_text;

namespace {

void put(const ScratchDirectory& root, const fs::path& file, const std::string& text) {
  fs::create_directories((root / file).parent_path());
  write_text(root / file, text);
}

}  // namespace

TEST_CASE("TheLeastOfTheMachineAndOfAllControlGroupsIsWhatAProcessMayHave") {
  constexpr std::uint64_t kGibibyte = std::uint64_t{1} << 30;
  const ScratchDirectory root;
  CHECK_FALSE(memory_limit_bytes(root.path()));
  put(root, "proc/meminfo", "MemTotal:       16777216 kB\nMemFree:  1 kB\n");
  CHECK(memory_limit_bytes(root.path()) == 16 * kGibibyte);
  put(root, "proc/self/cgroup", "0::/batch/job\n");
  put(root, "sys/fs/cgroup/batch/job/memory.max", "max\n");
  CHECK(memory_limit_bytes(root.path()) == 16 * kGibibyte);
  put(root, "sys/fs/cgroup/batch/memory.max", "4294967296\n");
  CHECK(memory_limit_bytes(root.path()) == 4 * kGibibyte);
  put(root, "sys/fs/cgroup/batch/job/memory.max", "2147483648\n");
  CHECK(memory_limit_bytes(root.path()) == 2 * kGibibyte);
  put(root, "proc/self/cgroup", "9:cpu,cpuacct:/x\n4:memory:/batch\n0::/\n");
  put(root, "sys/fs/cgroup/memory/batch/memory.limit_in_bytes", "9223372036854771712\n");
  CHECK(memory_limit_bytes(root.path()) == 16 * kGibibyte);
  // A container whose group is the outermost one that it sees.
  put(root, "sys/fs/cgroup/memory/memory.limit_in_bytes", "1073741824\n");
  CHECK(memory_limit_bytes(root.path()) == kGibibyte);
}

TEST_CASE("TheMachineOfThisTestSaysHowMuchMemoryItHas") { CHECK(memory_limit_bytes() > 0); }
