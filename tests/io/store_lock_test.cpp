// A work directory belongs to one run at a time, its members included.
#include "io/store/store_lock.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <thread>

#include "io/error.h"
#include "io/system/file_descriptor.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using std::chrono::milliseconds;

namespace {

const std::string kStore = "0123456789abcdef0123456789abcdef";
constexpr milliseconds kNotAtAll{0};
constexpr milliseconds kAsLongAsItTakes{600'000};

std::string own_process() { return "process " + std::to_string(getpid()); }

std::string refusal(const std::filesystem::path& directory) {
  try {
    lock_as_owner(directory, kStore, kNotAtAll);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kResource);
    return error.what();
  }
  return {};
}

/// Ends when the lock is gone, a while after the moment that nobody is refused for.
std::thread soon_released(std::optional<FileDescriptor>& lock) {
  return std::thread([&lock] {
    std::this_thread::sleep_for(milliseconds(200));
    lock.reset();
  });
}

}  // namespace

TEST_CASE("ASecondOwnerIsToldTheFirst") {
  const test::ScratchDirectory scratch;
  const FileDescriptor first = lock_as_owner(scratch.path(), kStore);
  CHECK_THAT(refusal(scratch.path()), Contains("in use by " + own_process()));
}

TEST_CASE("MembersThatOutliveTheirOwnerKeepOutTheNextAndAreNamed") {
  const test::ScratchDirectory scratch;
  std::optional<FileDescriptor> owner = lock_as_owner(scratch.path(), kStore);
  std::optional<FileDescriptor> one = lock_as_member(scratch.path(), 1, kStore);
  std::optional<FileDescriptor> two = lock_as_member(scratch.path(), 2, kStore);
  owner.reset();
  CHECK_THAT(refusal(scratch.path()), Contains("rank 1 (" + own_process() + " on ") &&
                                          Contains("rank 2 (" + own_process() + " on "));
  one.reset();
  CHECK_THAT(refusal(scratch.path()), !Contains("rank 1") && Contains("rank 2"));
  two.reset();
  CHECK(refusal(scratch.path()).empty());
}

TEST_CASE("AnOwnerWaitsForMembersThatAreEnding") {
  const test::ScratchDirectory scratch;
  std::optional<FileDescriptor> member = lock_as_member(scratch.path(), 1, kStore);
  std::thread end = soon_released(member);
  CHECK(lock_as_owner(scratch.path(), kStore, kAsLongAsItTakes).valid());
  end.join();
}

TEST_CASE("AnOwnerWaitsForTheLeaderOfATeamThatIsEnding") {
  const test::ScratchDirectory scratch;
  std::optional<FileDescriptor> leader = lock_as_owner(scratch.path(), kStore);
  test::write_text(scratch / kTeamMark, lock_text("1", kStore));
  std::thread end = soon_released(leader);
  CHECK_NOTHROW(lock_as_owner(scratch.path(), kStore, kAsLongAsItTakes));
  end.join();
}

TEST_CASE("AMemberWaitsForALateOneOfAnEarlierRun") {
  const test::ScratchDirectory scratch;
  std::optional<FileDescriptor> late = lock_as_member(scratch.path(), 1, kStore);
  std::thread end = soon_released(late);
  CHECK_NOTHROW(lock_as_member(scratch.path(), 1, kStore, kAsLongAsItTakes));
  end.join();
}

TEST_CASE("AnOwnersMembersJoinAfterThoseOfAnotherRunHaveEnded") {
  const test::ScratchDirectory scratch;
  lock_as_member(scratch.path(), 1, kStore);
  const FileDescriptor owner = lock_as_owner(scratch.path(), kStore, kNotAtAll);
  const FileDescriptor member = lock_as_member(scratch.path(), 1, kStore);
  CHECK(members_at_work(scratch.path()).size() == 1);
  CHECK_THROWS_AS(lock_as_member(scratch.path(), 1, kStore, kNotAtAll), Error);
}

TEST_CASE("ANewOwnerTakesAwayTheMarkThatMembersJoinBy") {
  const test::ScratchDirectory scratch;
  test::write_text(scratch / kTeamMark, lock_text("1", kStore));
  const FileDescriptor owner = lock_as_owner(scratch.path(), kStore);
  CHECK_FALSE(std::filesystem::exists(scratch / kTeamMark));
}

TEST_CASE("WhatOnlyLooksLikeALockStays") {
  const test::ScratchDirectory scratch;
  for (const char* name : {"team", "member.3", "member.csv"}) test::write_text(scratch / name, "");
  test::write_text(scratch / "member.4", "notes (orbweave)\n");
  test::write_text(scratch / "member.5", lock_text("4711 on node17", "another"));
  const auto is_on_record = [](const std::filesystem::path& path) {
    return path.filename() == "member.6";
  };
  test::write_text(scratch / "member.6", "");
  const FileDescriptor owner = lock_as_owner(scratch.path(), kStore, kNotAtAll, is_on_record);
  for (const char* name : {"team", "member.3", "member.csv", "member.4", "member.5"}) {
    INFO(name);
    CHECK(std::filesystem::exists(scratch / name));
  }
  CHECK_FALSE(std::filesystem::exists(scratch / "member.6"));
  CHECK_THROWS_AS(lock_as_member(scratch.path(), 3, kStore, kNotAtAll, is_on_record), Error);
}

TEST_CASE("MembersAtWorkAreThoseThatLive") {
  const test::ScratchDirectory scratch;
  lock_as_member(scratch.path(), 1, kStore);
  const FileDescriptor two = lock_as_member(scratch.path(), 2, kStore);
  const std::vector<std::string> members = members_at_work(scratch.path());
  REQUIRE(members.size() == 1);
  CHECK_THAT(members[0], Contains("rank 2 (" + own_process()));
}
