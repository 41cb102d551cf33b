// Temporary files without a name.
#include "io/system/spool_file.h"

#include <fcntl.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "io/meshes/mesh_writer.h"
#include "io/system/file_descriptor.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using namespace orbweave;
using test::ScratchDirectory;

namespace {

/// To ask which files are made in a directory from now on; invalid, with a word, where its file
/// system has no files without a name.
FileDescriptor watch_new_files(const ScratchDirectory& scratch) {
  if (!FileDescriptor(::open(scratch.path().c_str(), O_TMPFILE | O_RDWR, 0600)).valid()) {
    WARN("the file system has no files without a name");
    return FileDescriptor();
  }
  FileDescriptor watch(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
  REQUIRE(::inotify_add_watch(watch.get(), scratch.path().c_str(), IN_CREATE) >= 0);
  return watch;
}

/// Names of the files that were made in a directory since it is watched.
std::vector<std::string> made_names(const FileDescriptor& watch) {
  std::vector<std::string> names;
  alignas(inotify_event) std::array<char, 4096> events{};
  for (;;) {
    const ssize_t count = ::read(watch.get(), events.data(), events.size());
    if (count <= 0) return names;
    for (std::size_t at = 0; at < static_cast<std::size_t>(count);) {
      inotify_event event{};
      std::memcpy(&event, events.data() + at, sizeof(event));
      names.emplace_back(events.data() + at + sizeof(event));
      at += sizeof(event) + event.len;
    }
  }
}

}  // namespace

TEST_CASE("ASpoolFileHasNoNameAtAnyTimeSoThatAKillLeavesNone") {
  const ScratchDirectory scratch;
  const FileDescriptor watch = watch_new_files(scratch);
  if (!watch.valid()) return;
  SpoolFile file(scratch.path());
  const std::array<int, 3> values = {4, 5, 6};
  const std::uint64_t offset = file.append_values(std::span<const int>(values));
  std::array<int, 3> back{};
  file.read_values(offset, std::span<int>(back));
  CHECK(back == values);
  CHECK(made_names(watch).empty());
  CHECK(test::names_in(scratch).empty());
}

TEST_CASE("AnStlFileIsWrittenBesideNothingElseSoThatAKillLeavesNone") {
  const ScratchDirectory scratch;
  const FileDescriptor watch = watch_new_files(scratch);
  if (!watch.valid()) return;
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  write_mesh(scratch / "mesh.stl", mesh);
  const std::vector<std::string> names = made_names(watch);
  CHECK_FALSE(names.empty());  // of the file itself
  for (const std::string& name : names)
    CHECK_THAT(name, Catch::StartsWith(".mesh.stl.") && Catch::EndsWith(".part"));
  CHECK(test::names_in(scratch) == std::vector<std::string>{"mesh.stl"});
}
