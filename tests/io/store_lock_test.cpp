// A work directory belongs to one run at a time, its members included.
#include "io/store_lock.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <thread>

#include "io/error.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using std::chrono::milliseconds;

namespace {

constexpr milliseconds kNotAtAll{0};
constexpr milliseconds kAsLongAsItTakes{600'000};

std::string own_process() { return "process " + std::to_string(getpid()); }

std::string refusal(const std::filesystem::path& directory) {
  try {
    lock_as_owner(directory, kNotAtAll);
  } catch (const Error& error) {
    CHECK(error.status() == ExitStatus::kResource);
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
  const FileDescriptor first = lock_as_owner(scratch.path());
  CHECK_THAT(refusal(scratch.path()), Contains("in use by " + own_process()));
}

TEST_CASE("MembersThatOutliveTheirOwnerKeepOutTheNextAndAreNamed") {
  const test::ScratchDirectory scratch;
  std::optional<FileDescriptor> owner = lock_as_owner(scratch.path());
  std::optional<FileDescriptor> one = lock_as_member(scratch.path(), 1);
  std::optional<FileDescriptor> two = lock_as_member(scratch.path(), 2);
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
  std::optional<FileDescriptor> member = lock_as_member(scratch.path(), 1);
  std::thread end = soon_released(member);
  CHECK(lock_as_owner(scratch.path(), kAsLongAsItTakes).valid());
  end.join();
}

TEST_CASE("AnOwnerWaitsForTheLeaderOfATeamThatIsEnding") {
  const test::ScratchDirectory scratch;
  std::optional<FileDescriptor> leader = lock_as_owner(scratch.path());
  test::write_text(scratch / kTeamMark, "1\n");
  std::thread end = soon_released(leader);
  CHECK_NOTHROW(lock_as_owner(scratch.path(), kAsLongAsItTakes));
  end.join();
}

TEST_CASE("AMemberWaitsForALateOneOfAnEarlierRun") {
  const test::ScratchDirectory scratch;
  std::optional<FileDescriptor> late = lock_as_member(scratch.path(), 1);
  std::thread end = soon_released(late);
  CHECK_NOTHROW(lock_as_member(scratch.path(), 1, kAsLongAsItTakes));
  end.join();
}

TEST_CASE("AnOwnersMembersJoinAfterThoseOfAnotherRunHaveEnded") {
  const test::ScratchDirectory scratch;
  lock_as_member(scratch.path(), 1);
  const FileDescriptor owner = lock_as_owner(scratch.path(), kNotAtAll);
  const FileDescriptor member = lock_as_member(scratch.path(), 1);
  CHECK(members_at_work(scratch.path()).size() == 1);
  CHECK_THROWS_AS(lock_as_member(scratch.path(), 1, kNotAtAll), Error);
}

TEST_CASE("ANewOwnerTakesAwayTheMarkThatMembersJoinBy") {
  const test::ScratchDirectory scratch;
  test::write_text(scratch / kTeamMark, "1\n");
  const FileDescriptor owner = lock_as_owner(scratch.path());
  CHECK_FALSE(std::filesystem::exists(scratch / kTeamMark));
}

TEST_CASE("MembersAtWorkAreThoseThatLive") {
  const test::ScratchDirectory scratch;
  lock_as_member(scratch.path(), 1);
  const FileDescriptor two = lock_as_member(scratch.path(), 2);
  const std::vector<std::string> members = members_at_work(scratch.path());
  REQUIRE(members.size() == 1);
  CHECK_THAT(members[0], Contains("rank 2 (" + own_process()));
}
