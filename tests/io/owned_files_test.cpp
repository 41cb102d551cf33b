// What is on the record of a work directory, and what is not, is told apart at every moment.
#include "io/system/owned_files.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <functional>
#include <memory>

#include "io/error.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using namespace orbweave;
using test::file_text;
using test::ScratchDirectory;
using test::write_text;

namespace {

namespace fs = std::filesystem;
using Removal = OwnedFiles::Removal;

const std::string kStore = "0123456789abcdef";

void make(OwnedFiles& record, const fs::path& path, const std::string& text) {
  REQUIRE(record.try_create(path).valid());
  write_text(path, text);
}

/// Another file of that name, with an inode of its own.
void replace(const fs::path& path, const std::string& text) {
  write_text(path.string() + ".new", text);
  fs::rename(path.string() + ".new", path);
}

}  // namespace

TEST_CASE("ANameWithItsInodeIsTheProgramsAndNothingElseIs") {
  const ScratchDirectory scratch;
  const bool reopened = GENERATE(false, true);
  auto record = std::make_unique<OwnedFiles>(scratch.path(), kStore, 0);
  REQUIRE(record->make_directory(scratch / "mesh"));
  for (const char* name : {"a", "b", "c", "mesh/000001.h5"}) make(*record, scratch / name, "ours");
  make(*record, scratch / "from", "ours");
  REQUIRE(record->rename(scratch / "from", scratch / "to"));
  write_text(scratch / "mine", "mine");
  write_text(scratch / "empty", "");
  replace(scratch / "b", "mine");
  fs::rename(scratch / "c", scratch / "moved");
  fs::create_hard_link(scratch / "a", scratch / "linked");
  fs::create_symlink("a", scratch / "link");
  if (reopened) record = std::make_unique<OwnedFiles>(scratch.path(), kStore, 0);
  for (const char* name : {"b", "moved", "linked", "link", "mine", "empty"}) {
    INFO(name);
    CHECK_FALSE(record->owns(scratch / name));
    CHECK(record->remove(scratch / name) == Removal::kStranger);
    CHECK(fs::exists(fs::symlink_status(scratch / name)));
  }
  CHECK(record->remove(scratch / "c") == Removal::kAbsent);
  CHECK(record->remove(scratch / "mesh") == Removal::kStranger);  // it is not empty
  for (const char* name : {"a", "to", "mesh/000001.h5", "mesh"}) {
    INFO(name);
    CHECK(record->owns(scratch / name));
    CHECK(record->remove(scratch / name) == Removal::kRemoved);
    CHECK_FALSE(fs::exists(scratch / name));
  }
}

TEST_CASE("NothingThatIsNotTheProgramsIsReplaced") {
  const ScratchDirectory scratch;
  OwnedFiles record(scratch.path(), kStore, 0);
  make(record, scratch / "ours", "ours");
  write_text(scratch / "mine", "mine");
  CHECK_FALSE(record.try_create(scratch / "mine").valid());
  for (const auto& replacing : std::vector<std::function<void()>>{
           [&] { record.create(scratch / "mine"); },
           [&] { record.rename(scratch / "ours", scratch / "mine"); },
           [&] { record.remove_or_refuse(scratch / "mine"); }}) {
    try {
      replacing();
      FAIL("replaced");
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kUsage);
      CHECK(error.parts().file == (scratch / "mine").string());
      CHECK_THAT(error.what(), Catch::Contains("not on its record"));
    }
    CHECK(file_text(scratch / "mine") == "mine");
  }
  CHECK(record.create(scratch / "ours").valid());
  CHECK(file_text(scratch / "ours").empty());
  // An output is replaced by its name, which the user gave.
  CHECK(record.rename(scratch / "ours", scratch / "mine", true));
}

TEST_CASE("AProcessThatIsKilledLeavesNothingThatTheNextOneDoesNotKnow") {
  const ScratchDirectory scratch;
  for (int trial = 0; trial < 40; ++trial) {
    const fs::path directory = scratch / std::to_string(trial);
    fs::create_directory(directory);
    const pid_t child = fork();
    if (child == 0) {
      OwnedFiles record(directory, kStore, 0);
      for (int i = 0;; ++i) {
        const std::string stage = "stage" + std::to_string(i / 50);
        record.make_directory(directory / stage);
        const fs::path part = directory / stage / (".00" + std::to_string(i) + ".h5.part");
        if (record.try_create(part).valid()) std::ofstream(part) << "content";
        if (i % 2 == 0) record.rename(part, directory / stage / ("00" + std::to_string(i) + ".h5"));
      }
    }
    usleep(static_cast<useconds_t>(2000 + trial * 137));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    OwnedFiles record(directory, kStore, 0);
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(directory))
      if (entry.path().filename() != "orbweave-record.0") found.push_back(entry.path());
    for (auto path = found.rbegin(); path != found.rend(); ++path) {
      INFO(path->string() << " of " << found.size());
      if (!fs::is_directory(*path)) CHECK(record.remove(*path) == Removal::kRemoved);
    }
    for (const fs::path& path : found) {
      INFO(path.string() << "\n" << file_text(directory / "orbweave-record.0").substr(0, 400));
      if (fs::is_directory(path)) CHECK(record.remove(path) == Removal::kRemoved);
    }
  }
}

TEST_CASE("WhatOtherRanksMakeIsKnownAtOnce") {
  const ScratchDirectory scratch;
  OwnedFiles leader(scratch.path(), kStore, 0);
  OwnedFiles member(scratch.path(), kStore, 3);
  make(member, scratch / "first", "ours");
  CHECK(leader.owns(scratch / "first"));
  make(member, scratch / "second", "ours");
  CHECK(leader.owns(scratch / "second"));
  CHECK(member.owns(scratch / "second"));
}

TEST_CASE("ARecordOfAnotherStoreCountsForNothing") {
  const ScratchDirectory scratch;
  { make(*std::make_unique<OwnedFiles>(scratch.path(), "another", 0), scratch / "a", "text"); }
  CHECK_FALSE(OwnedFiles(scratch.path(), kStore, 0).owns(scratch / "a"));
  CHECK(store_of_record(scratch / "orbweave-record.0").first == kStore);
}

TEST_CASE("ARecordThatIsCutAnywhereOwnsNothingButWhatItNames") {
  const ScratchDirectory scratch;
  {
    OwnedFiles record(scratch.path(), kStore, 0);
    for (const char* name : {"a", "b", "c"}) make(record, scratch / name, "ours");
  }
  write_text(scratch / "mine", "mine");
  const fs::path file = scratch / "orbweave-record.0";
  const std::string whole = file_text(file);
  for (std::size_t bytes = 0; bytes < whole.size(); bytes += 3) {
    fs::resize_file(file, 0);  // the inode stays
    std::ofstream(file) << whole.substr(0, bytes);
    if (!is_record(file)) {
      CHECK_THROWS_AS(OwnedFiles(scratch.path(), kStore, 0), Error);
      continue;
    }
    OwnedFiles record(scratch.path(), kStore, 0);
    CHECK_FALSE(record.owns(scratch / "mine"));
    make(record, scratch / "later", "ours");
    CHECK(OwnedFiles(scratch.path(), kStore, 0).owns(scratch / "later"));
    CHECK(record.remove(scratch / "later") == Removal::kRemoved);
  }
}

TEST_CASE("SomethingElseInTheRecordsPlaceIsRefused") {
  const ScratchDirectory scratch;
  const fs::path file = scratch / "orbweave-record.0";
  SECTION("a file") { write_text(file, "mine\n"); }
  SECTION("a directory") { fs::create_directory(file); }
  SECTION("a link") { fs::create_symlink("elsewhere", file); }
  try {
    const OwnedFiles record(scratch.path(), kStore, 0);
    FAIL("taken");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    CHECK_THAT(error.what(), Catch::Contains("orbweave-record.0") && Catch::Contains("Move it"));
  }
  CHECK_FALSE(fs::exists(scratch / "elsewhere"));
}

TEST_CASE("WhatWasOnItsWayBesideOutputsGoesByNameAndInode") {
  const ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fs::create_directory(work);
  const fs::path strange = scratch / ".a%0A\nb.0123456789abcdef.part";
  const fs::path part = scratch / ".mesh.ply.0123456789abcdef.part";
  const fs::path output = scratch / "mesh.ply";
  const fs::path tiles = scratch / ".mesh.tiles.0123456789abcdef.part";
  {
    OwnedFiles record(work, kStore, 0);
    for (const fs::path& path : {strange, part}) make(record, path, "half");
    make(record, scratch / ".mesh.ply.1.part", "whole");
    REQUIRE(record.rename(scratch / ".mesh.ply.1.part", output, true));
    REQUIRE(record.make_directory(tiles));
    make(record, tiles / "000000.ply", "half");
  }
  const bool notes = GENERATE(false, true);
  if (notes) write_text(tiles / "notes.txt", "mine");
  write_text(scratch / ".mesh.ply.fedcba9876543210.part", "mine");
  OwnedFiles(work, kStore, 0).remove_abandoned();
  CHECK_FALSE(fs::exists(strange));
  CHECK_FALSE(fs::exists(part));
  CHECK(file_text(output) == "whole");
  CHECK(file_text(scratch / ".mesh.ply.fedcba9876543210.part") == "mine");
  CHECK_FALSE(fs::exists(tiles / "000000.ply"));
  CHECK(fs::exists(tiles) == notes);
}

TEST_CASE("InACopyOfTheDirectoryNamesCount") {
  const ScratchDirectory scratch;
  const fs::path first = scratch / "first";
  fs::create_directory(first);
  {
    OwnedFiles record(first, kStore, 0);
    make(record, first / "ours", "ours");
  }
  write_text(first / "mine", "mine");
  fs::copy(first, scratch / "copy");
  for (int opening = 0; opening < 2; ++opening) {
    OwnedFiles record(scratch / "copy", kStore, 0);
    CHECK(record.owns(scratch / "copy" / "ours"));
    CHECK_FALSE(record.owns(scratch / "copy" / "mine"));
  }
}

TEST_CASE("ACopyOfTheDirectoryLeavesWhatTheOriginalIsWriting") {
  const ScratchDirectory scratch;
  const fs::path first = scratch / "first";
  const fs::path part = scratch / ".mesh.ply.0123456789abcdef.part";
  fs::create_directory(first);
  OwnedFiles original(first, kStore, 0);
  make(original, part, "half");
  fs::copy(first, scratch / "copy");
  for (int opening = 0; opening < 2; ++opening) {
    OwnedFiles record(scratch / "copy", kStore, 0);
    record.remove_abandoned();
    CHECK_FALSE(record.owns(part));
    CHECK(record.directories_outside().empty());
    CHECK(file_text(part) == "half");
  }
  CHECK(original.remove(part) == Removal::kRemoved);
}

TEST_CASE("AFinishedOutputIsNoTemporaryWhateverItsName") {
  const ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fs::create_directory(work);
  {
    OwnedFiles record(work, kStore, 0);
    make(record, scratch / ".r.part.0123456789abcdef.part", "whole");
    REQUIRE(record.rename(scratch / ".r.part.0123456789abcdef.part", scratch / "r.part", true));
  }
  OwnedFiles(work, kStore, 0).remove_abandoned();
  CHECK(file_text(scratch / "r.part") == "whole");
}

TEST_CASE("OnlyWhatHasTheNameAndTheLinesOfARecordIsOne") {
  const ScratchDirectory scratch;
  { const OwnedFiles record(scratch.path(), kStore, 0); }
  const std::string text = file_text(scratch / "orbweave-record.0");
  for (const char* name : {"orbweave-record.notes", "orbweave-record.", "orbweave-record.1x"}) {
    write_text(scratch / name, text);
    CHECK_FALSE(is_record(scratch / name));
  }
  write_text(scratch / "orbweave-record.1", "run 3 took five minutes\n");
  CHECK_FALSE(is_record(scratch / "orbweave-record.1"));
  write_text(scratch / "orbweave-record.2", text);
  CHECK(is_record_of(scratch / "orbweave-record.2", kStore));
  CHECK_FALSE(is_record_of(scratch / "orbweave-record.2", "another"));
  OwnedFiles other(scratch.path(), "another", 5);
  other.remove_record(scratch / "orbweave-record.2");
  CHECK(fs::exists(scratch / "orbweave-record.2"));
}

TEST_CASE("ManyHashesAreKeptAndNoOthersAre") {
  HashSet set;
  for (std::uint64_t i = 0; i < 30'000; ++i) set.insert(i * 0x9e3779b97f4a7c15 + i % 7);
  for (std::uint64_t i = 0; i < 30'000; ++i) {
    REQUIRE(set.contains(i * 0x9e3779b97f4a7c15 + i % 7));
    REQUIRE_FALSE(set.contains(i * 0x9e3779b97f4a7c15 + 8));
  }
}
