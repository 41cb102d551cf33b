// What jobs rely on: a committed result comes back as it was.
#include "io/store/chunk_store.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <random>
#include <thread>

#include "io/store/store_identity.h"
#include "io/store/work_directory.h"
#include "io/system/file_calls.h"
#include "tests/io/stored_arrays.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::Arrays;
using test::count_files;
using test::file_text;
using test::make_arrays;
using test::names_in;
using test::same;
using test::status_of;
using test::write_text;

}  // namespace

TEST_CASE("CommittedResultsComeBackAsTheyWere") {
  const test::ScratchDirectory scratch;
  const bool wait = GENERATE(false, true);
  const std::size_t rows = GENERATE(0, 1, 1023, 1024, 1025, 50'000);
  const Arrays arrays = make_arrays(rows, rows);
  {
    ChunkStore store(scratch / "work");
    CHECK_FALSE(store.begin_stage("points", "key"));
    CHECK_FALSE(store.has("points", 7));
    store.commit("points", 7, arrays.views(), wait);
    CHECK(store.has("points", 7));
    CHECK(same(*store.open("points", 7), arrays));
    store.finish_commits();
    CHECK(same(*store.open("points", 7), arrays));
    CHECK(store.bytes_written() >= rows * 29);
    CHECK(store.bytes_read() >= 2 * rows * 29);
  }
  ChunkStore store(scratch / "work");
  CHECK(store.begin_stage("points", "key"));
  CHECK(store.has("points", 7));
  CHECK_FALSE(store.has("points", 6));
  CHECK(same(*store.open("points", 7), arrays));
  CHECK(store.open("points", 7)->row_bytes("bytes") == 5);
  CHECK_FALSE(store.open("points", 7)->has("other"));
}

TEST_CASE("AnyRangeOfRowsIsReadAsWritten") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  store.set_compression(GENERATE(false, true));
  const Arrays arrays = make_arrays(39'500, 3);
  store.commit("points", 0, arrays.views());
  const auto stored = store.open("points", 0);
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 500; ++trial) {
    // Lengths of all sizes; ends near block borders among them.
    const std::size_t first = trial % 3 == 0 ? random() % 38 * 1024 : random() % 39'500;
    const std::size_t most = std::min<std::size_t>(39'500 - first, std::size_t{1} << random() % 16);
    const std::size_t count = trial % 5 == 0 ? most : random() % (most + 1);
    std::vector<std::uint8_t> bytes(count * 5);
    stored->read("bytes", first, count, bytes.data());
    REQUIRE(std::equal(bytes.begin(), bytes.end(), arrays.bytes.begin() + first * 5));
  }
  std::vector<std::uint8_t> bytes(5 * 2);
  CHECK_THROWS_AS(stored->read("bytes", 39'499, 2, bytes.data()), std::out_of_range);
}

TEST_CASE("CompressedResultsComeBackAsTheyWereAndTakeLessRoom") {
  const test::ScratchDirectory scratch;
  Arrays arrays = make_arrays(GENERATE(0, 1, 1023, 1024, 1025, 5000), 3);
  for (std::size_t i = 0; i < arrays.values.size(); ++i) arrays.values[i] = static_cast<double>(i);
  std::uintmax_t room[2] = {};
  for (const bool packed : {false, true}) {
    const fs::path work = scratch / (packed ? "packed" : "plain");
    {
      ChunkStore store(work);
      store.set_compression(packed);
      store.commit("points", 0, arrays.views());
      CHECK(same(*store.open("points", 0), arrays));
    }
    room[packed] = fs::file_size(work / "points/000000.h5");
    // Whoever reads does not need to know how it was written.
    CHECK(same(*ChunkStore(work).open("points", 0), arrays));
  }
  if (arrays.values.size() >= 3 * 1024) CHECK(room[true] < room[false]);
}

TEST_CASE("AChangedKeyInvalidatesTheStageAndNoOther") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(10, 1);
  {
    ChunkStore store(scratch / "work");
    store.begin_stage("points", "a");
    store.begin_stage("mesh", "b");
    store.commit("points", 0, arrays.views());
    store.commit("mesh", 0, arrays.views());
    store.commit_document("mesh", "radii", "[1]");
  }
  ChunkStore store(scratch / "work");
  CHECK(store.begin_stage("points", "a"));
  CHECK_FALSE(store.begin_stage("mesh", "c"));
  CHECK(store.has("points", 0));
  CHECK_FALSE(store.has("mesh", 0));
  CHECK_FALSE(store.document("mesh", "radii").has_value());
  CHECK(store.begin_stage("mesh", "c"));
}

TEST_CASE("KeysOfAnyBytesAreTold") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  CHECK_FALSE(store.begin_stage("points", "name \xff \"quoted\" \n"));
  CHECK(store.begin_stage("points", "name \xff \"quoted\" \n"));
  CHECK_FALSE(store.begin_stage("points", "name \xfe \"quoted\" \n"));
}

TEST_CASE("DocumentsComeBackOrAreAbsent") {
  const test::ScratchDirectory scratch;
  {
    ChunkStore store(scratch / "work");
    store.begin_stage("points", "a");
    CHECK_FALSE(store.document("points", "facts").has_value());
    store.commit_document("points", "facts", "{\"points\": 1}");
    store.commit_document("points", "facts", "{\"points\": 12}");
  }
  const fs::path path = scratch / "work/points/facts.json";
  {
    ChunkStore store(scratch / "work");
    CHECK(store.document("points", "facts") == "{\"points\": 12}");
    CHECK(file_text(path) == "{\"points\": 12}");
  }
  write_text(path, "{\"points\": 13}");
  CHECK_FALSE(ChunkStore(scratch / "work").document("points", "facts").has_value());
}

TEST_CASE("DiscardedResultsAreGoneAndCanBeCommittedAgain") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  const Arrays first = make_arrays(3000, 1);
  const Arrays second = make_arrays(2000, 2);
  for (int round = 0; round < 20; ++round) {
    store.commit("points", 4, first.views());
    CHECK(same(*store.open("points", 4), first));
    store.discard("points", 4);
    CHECK_FALSE(store.has("points", 4));
    CHECK_THROWS_AS(store.open("points", 4), CorruptResult);
    store.commit("points", 4, second.views());
    CHECK(same(*store.open("points", 4), second));
    store.commit("points", 4, first.views());
    CHECK(same(*store.open("points", 4), first));
  }
}

TEST_CASE("ASecondOpenerIsRefusedAndToldWhoHoldsIt") {
  const test::ScratchDirectory scratch;
  std::string message;
  {
    const ChunkStore store(scratch / "work");
    CHECK(status_of([&] { ChunkStore(scratch / "work"); }, &message) == ErrorKind::kResource);
    CHECK(message.find("process " + std::to_string(getpid())) != std::string::npos);
  }
  CHECK(status_of([&] { ChunkStore(scratch / "work"); }) == ErrorKind::kNone);
}

TEST_CASE("ManyThreadsCommitAndReadAtOnce") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  store.begin_stage("points", "key");
  constexpr ChunkId kChunks = 300;
  std::atomic<ChunkId> next{0};
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (ChunkId chunk = next++; chunk < kChunks; chunk = next++) {
        store.commit("points", chunk, make_arrays(300, chunk).views());
        const ChunkId other = chunk / 2;
        if (store.has("points", other))
          wrong += !same(*store.open("points", other), make_arrays(300, other));
      }
    });
  for (std::thread& thread : threads) thread.join();
  store.finish_commits();
  for (ChunkId chunk = 0; chunk < kChunks; ++chunk)
    wrong += !same(*store.open("points", chunk), make_arrays(300, chunk));
  CHECK(wrong == 0);
  CHECK(count_files(scratch / "work", ".h5") == kChunks);
}

TEST_CASE("ALogThatAKillLeftEmptyIsTheProgramsOnceItIsWritten") {
  const test::ScratchDirectory scratch;
  const fs::path log = scratch / "work" / "orbweave.log";
  {
    const ChunkStore store(scratch / "work");
    store.record()->announce(log);
    write_text(log, "");
  }
  ChunkStore store(scratch / "work");
  REQUIRE(store.claim(log));
  write_text(log, "begins");
  CHECK(store.remove_all().empty());
  CHECK_FALSE(fs::exists(scratch / "work"));
}

TEST_CASE("RemoveAllLeavesNothing") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  for (ChunkId chunk = 0; chunk < 50; ++chunk)
    store.commit("points", chunk, make_arrays(500, chunk).views());
  store.remove_all();
  CHECK_FALSE(fs::exists(scratch / "work"));
}

TEST_CASE("ADirectoryThatIsRemovedWhileItsLockIsWaitedForIsMadeAnew") {
  const test::ScratchDirectory scratch;
  const fs::path directory = scratch / "work";
  auto ending = std::make_unique<ChunkStore>(directory);
  ending->mark_team("1");  // the leader of a team is waited for
  std::thread end([&ending] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ending->remove_all();
    ending.reset();
  });
  std::unique_ptr<ChunkStore> next;
  CHECK_NOTHROW(next = std::make_unique<ChunkStore>(directory));
  end.join();
  REQUIRE(next);
  CHECK(next->is_made());
  next->commit_document("points", "note", "{}");
  CHECK(next->document("points", "note") == "{}");
}

#ifdef __linux__
TEST_CASE("AFileThatComesIntoTheWorkDirectoryAtTheLastMomentStaysUnderItsName") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  ChunkStore store(work);
  store.begin_stage("points", "key");
  const FileCalls before = file_calls;
  // The file comes when the directory has just been put aside.
  file_calls.renameat2 = [](int from_folder, const char* from, int to_folder, const char* to,
                            unsigned flags) {
    const int result = ::renameat2(from_folder, from, to_folder, to, flags);
    const fs::path note = fs::path(to) / "note.txt";
    if (result == 0 && fs::path(from).filename() == "work") write_text(note, "mine");
    return result;
  };
  const std::vector<std::string> strangers = store.remove_all();
  file_calls = before;
  CHECK(strangers == std::vector<std::string>{"note.txt"});
  CHECK(names_in(scratch) == std::vector<std::string>{"work"});
  CHECK(file_text(work / "note.txt") == "mine");
}
#endif

TEST_CASE("AnEmptyDirectoryIsTheUsersWhateverItsPermissions") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fs::create_directory(work);
  const fs::perms given = GENERATE(fs::perms::owner_all, fs::perms::all | fs::perms::sticky_bit,
                                   fs::perms::owner_all | fs::perms::sticky_bit);
  fs::permissions(work, given);
  ChunkStore(work).remove_all();
  CHECK(fs::is_directory(work));
  CHECK(fs::status(work).permissions() == given);
}

TEST_CASE("AWorkDirectoryThatIsMadeHasItsIdentityFromItsFirstMoment") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "above" / "work";
  const std::vector<MadeDirectory> made = make_work_directory(work);
  REQUIRE(made.size() == 2);
  CHECK(made[1].path == fs::canonical(work));
  const StoreIdentity identity = identify_store(work);
  CHECK(identity.state == StoreIdentity::State::kSound);
  CHECK(identity.made.size() == 2);
  ChunkStore(work).remove_all();
  CHECK(fs::is_empty(scratch.path()));
}

TEST_CASE("AKillWhileADirectoryIsMadeOrGoesLeavesNothingForGood") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  int beside = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const pid_t child = fork();
    if (child == 0)
      for (;;) ChunkStore(work).remove_all();
    usleep(static_cast<useconds_t>(1000 + trial * 97));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    for (const auto& entry : fs::directory_iterator(scratch.path()))
      beside += entry.path().filename() != "work" ? 1 : 0;
    ChunkStore(work).remove_all();
    CHECK_FALSE(fs::exists(work));
  }
  CAPTURE(beside);
  make_work_directory(work);
  CHECK(names_in(scratch) == std::vector<std::string>{"work"});
}

TEST_CASE("OnlyWhatWasPutAsideForThePlaceIsRemovedBesideIt") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  const fs::path other = scratch / "other";
  make_work_directory(work);
  make_work_directory(other);
  const fs::path aside = put_aside(work);
  const fs::path full = put_aside(other);
  REQUIRE(fs::exists(aside));
  write_text(full / "notes.txt", "mine");
  const fs::path named = scratch / ".orbweave.0123456789abcdef.part";
  fs::create_directory(named);
  make_work_directory(work);
  make_work_directory(other);
  CHECK_FALSE(fs::exists(aside));
  CHECK(file_text(full / "notes.txt") == "mine");
  CHECK(fs::exists(full / "orbweave-store.json"));
  CHECK(fs::exists(named));
}

TEST_CASE("ADirectoryThatStaysForAStrangersSakeHasItsPermissions") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  ChunkStore store(work);
  const fs::perms before = fs::status(work).permissions();
  fs::remove(work / "lock");
  write_text(work / "lock", "the user's own");
  CHECK(store.remove_all() == std::vector<std::string>{"lock"});
  CHECK(fs::status(work).permissions() == before);
  CHECK((before & fs::perms::sticky_bit) == fs::perms::none);
}

TEST_CASE("AMemberReadsWhatAnotherHasPutInAResultsPlace") {
  const test::ScratchDirectory scratch;
  ChunkStore leader(scratch / "work");
  leader.commit("mesh", 0, make_arrays(3000, 1).views(), true);
  const auto member = ChunkStore::join(scratch / "work", 1);
  REQUIRE(same(*member->open("mesh", 0), make_arrays(3000, 1)));
  leader.discard_stage("mesh");
  leader.commit("mesh", 0, make_arrays(2000, 2).views(), true);
  CHECK(same(*member->open("mesh", 0), make_arrays(2000, 2)));
}

TEST_CASE("DiscardedResultsLeaveKeyAndDocuments") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  store.begin_stage("raw", "key");
  for (ChunkId chunk = 0; chunk < 5; ++chunk)
    store.commit("raw", chunk, make_arrays(50, chunk).views());
  store.commit_document("raw", "facts", "{}");
  store.discard_results("raw");
  CHECK(count_files(scratch / "work", ".h5") == 0);
  CHECK(store.begin_stage("raw", "key"));
  CHECK(store.key("raw") == "key");
  CHECK(store.document("raw", "facts") == "{}");
  store.discard_results("never begun");
  CHECK_FALSE(store.key("never begun"));
}

TEST_CASE("TheWordThatAJobHasEndedIsOfThatJobAlone") {
  const test::ScratchDirectory scratch;
  {
    ChunkStore store(scratch / "work");
    CHECK_FALSE(store.has_ended("this job"));
    store.set_ended("this job");
  }
  // What the removal of the rest leaves when it is cut short.
  fs::remove(scratch / "work" / "orbweave-store.json");
  ChunkStore store(scratch / "work");
  CHECK(store.has_ended("this job"));
  CHECK_FALSE(store.has_ended("another job"));
  store.clear_ended();
  CHECK_FALSE(store.has_ended("this job"));
}

TEST_CASE("FilesAreBitwiseReproducible") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(1500, 1);
  const bool packed = GENERATE(false, true);
  ChunkStore store(scratch / "work");
  store.set_compression(packed);
  store.begin_stage("points", "key");
  store.commit("points", 0, arrays.views(), true);
  const std::string once = file_text(scratch / "work/points/000000.h5");
  store.discard("points", 0);
  store.commit("points", 0, arrays.views(), true);
  CHECK(file_text(scratch / "work/points/000000.h5") == once);
}

}  // namespace orbweave
