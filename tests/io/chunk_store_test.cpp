// What jobs rely on: a committed result comes back as it was, or not at all.
#include "io/chunk_store.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include "tests/support/data.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

struct Arrays {
  std::vector<double> values;
  std::vector<std::uint8_t> bytes;
  std::vector<ArrayView> views() const {
    return {{"values", ScalarType::kFloat64, 3, values.size() / 3, values.data()},
            {"bytes", ScalarType::kUint8, 5, bytes.size() / 5, bytes.data()},
            {"nothing", ScalarType::kInt32, 2, 0, nullptr}};
  }
};

Arrays make_arrays(std::size_t rows, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Arrays arrays;
  for (std::size_t i = 0; i < rows * 3; ++i)
    arrays.values.push_back(static_cast<double>(random() >> 11));
  for (std::size_t i = 0; i < rows * 5; ++i)
    arrays.bytes.push_back(static_cast<std::uint8_t>(random()));
  return arrays;
}

bool same(const StoredResult& stored, const Arrays& arrays) {
  return stored.read_all<double>("values") == arrays.values &&
         stored.read_all<std::uint8_t>("bytes") == arrays.bytes && stored.rows("nothing") == 0;
}

std::string slurp(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void spill(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Overwrites one byte in place.
void put(const fs::path& path, std::size_t at, int byte) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(byte));
}

ExitStatus status_of(const std::function<void()>& action, std::string* message = nullptr) {
  try {
    action();
  } catch (const Error& error) {
    if (message != nullptr) *message = error.what();
    return error.status();
  }
  return ExitStatus::kDone;
}

/// Files that end like this, anywhere below.
int count_files(const fs::path& directory, const std::string& ending) {
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(directory))
    count += entry.path().filename().string().ends_with(ending);
  return count;
}

/// Runs `action` in a child process; true when it ends with status 0.
bool succeeds_in_child(const std::function<bool()>& action) {
  const pid_t child = fork();
  if (child == 0) {
    bool good = false;
    try {
      good = action();
    } catch (...) {
    }
    _exit(good ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

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

TEST_CASE("UncommittedResultsAreInvisible") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(2000, 1);
  // A process that ends in the middle of writing leaves a part file at most.
  CHECK(succeeds_in_child([&] {
    ChunkStore store(scratch / "work");
    store.begin_stage("points", "key");
    store.commit("points", 1, arrays.views(), true);
    spill(scratch / "work/points/.000002.h5.part", slurp(scratch / "work/points/000001.h5"));
    return true;
  }));
  ChunkStore store(scratch / "work");
  CHECK(store.begin_stage("points", "key"));
  CHECK(store.has("points", 1));
  CHECK_FALSE(store.has("points", 2));
  CHECK_THROWS_AS(store.open("points", 2), CorruptResult);
  CHECK(count_files(scratch / "work", ".part") == 0);
}

TEST_CASE("ResultsOfAKilledProcessAreWholeOrAbsent") {
  const test::ScratchDirectory scratch;
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 8; ++trial) {
    const pid_t child = fork();
    if (child == 0) {
      ChunkStore store(scratch / "work");
      store.begin_stage("points", "key");
      for (ChunkId chunk = 0; chunk < 100'000; ++chunk)
        store.commit("points", chunk % 500, make_arrays(700, chunk % 500).views(), chunk % 7 == 0);
      _exit(0);
    }
    usleep(static_cast<useconds_t>(20'000 + random() % 60'000));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    ChunkStore store(scratch / "work");
    store.begin_stage("points", "key");
    for (ChunkId chunk = 0; chunk < 500; ++chunk)
      if (store.has("points", chunk))
        REQUIRE(same(*store.open("points", chunk), make_arrays(700, chunk)));
  }
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
    CHECK(slurp(path) == "{\"points\": 12}");
  }
  spill(path, "{\"points\": 13}");
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

TEST_CASE("AFlippedByteNeverGivesWrongData") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(1500, 9);
  {
    ChunkStore store(scratch / "work");
    store.set_compression(GENERATE(false, true));
    store.commit("points", 0, arrays.views());
  }
  const fs::path path = scratch / "work/points/000000.h5";
  const std::string good = slurp(path);
  int detected = 0;
  int harmless = 0;
  int step = 1;
  for (std::size_t at = 0; at < good.size(); at += static_cast<std::size_t>(step)) {
    // Every byte of HDF5's own structures (they lie at the ends), a sample of the data.
    step = at < 6000 || at + 3000 > good.size() ? 1 : 61;
    put(path, at, good[at] ^ (1 << at % 8));
    try {
      const ChunkStore store(scratch / "work");
      const bool right = same(*store.open("points", 0), arrays);
      REQUIRE(right);
      ++harmless;
    } catch (const CorruptResult& corrupt) {
      REQUIRE(corrupt.path() == path);
      REQUIRE(corrupt.status() == ExitStatus::kResource);
      ++detected;
    }
    put(path, at, good[at]);
  }
  CHECK(detected > 1000);
  CHECK(harmless < 1500);  // padding between HDF5's structures
}

TEST_CASE("AFlippedByteInAnyArrayIsDetected") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(5000, 9);
  ChunkStore store(scratch / "work");
  store.commit("points", 0, arrays.views(), true);
  const fs::path path = scratch / "work/points/000000.h5";
  const std::string good = slurp(path);
  const auto find = [&](const void* bytes, std::size_t size) {
    const std::string needle(static_cast<const char*>(bytes), size);
    return good.find(needle);
  };
  const std::size_t values_at = find(arrays.values.data(), 64);
  const std::size_t bytes_at = find(arrays.bytes.data(), 64);
  REQUIRE(values_at != std::string::npos);
  REQUIRE(bytes_at != std::string::npos);
  const auto damaged = [&](std::size_t at) {
    spill(path, good);
    put(path, at, good[at] ^ 0x10);
    return store.open("points", 0);
  };
  for (std::size_t row = 0; row < 5000; row += 499) {
    CHECK_THROWS_AS(damaged(values_at + row * 24)->read_all<double>("values"), CorruptResult);
    CHECK(damaged(values_at + row * 24)->read_all<std::uint8_t>("bytes") == arrays.bytes);
    CHECK_THROWS_AS(damaged(bytes_at + row * 5)->read_all<std::uint8_t>("bytes"), CorruptResult);
  }
  // Only the blocks that are touched are judged.
  std::vector<double> rows(3 * 1024);
  CHECK_THROWS_AS(damaged(values_at + 1030 * 24)->read("values", 1100, 1, rows.data()),
                  CorruptResult);
  CHECK_NOTHROW(damaged(values_at + 1030 * 24)->read("values", 0, 1024, rows.data()));
}

TEST_CASE("ATruncatedFileIsDetected") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(3000, 9);
  const fs::path path = scratch / "work/points/000000.h5";
  const bool packed = GENERATE(false, true);
  {
    ChunkStore store(scratch / "work");
    store.set_compression(packed);
    store.commit("points", 0, arrays.views());
  }
  const std::uintmax_t size = fs::file_size(path);
  for (const std::uintmax_t kept :
       {size - 1, size - 5000, size / 2, std::uintmax_t{100}, std::uintmax_t{0}}) {
    fs::resize_file(path, kept);
    const ChunkStore store(scratch / "work");
    CHECK_THROWS_AS(same(*store.open("points", 0), arrays), CorruptResult);
  }
  SECTION("also by the process that wrote it") {
    ChunkStore store(scratch / "work");
    store.commit("points", 0, arrays.views(), true);
    fs::resize_file(path, size / 2);
    CHECK_THROWS_AS(same(*store.open("points", 0), arrays), CorruptResult);
  }
}

TEST_CASE("ASecondOpenerIsRefusedAndToldWhoHoldsIt") {
  const test::ScratchDirectory scratch;
  std::string message;
  {
    const ChunkStore store(scratch / "work");
    CHECK(status_of([&] { ChunkStore(scratch / "work"); }, &message) == ExitStatus::kResource);
    CHECK(message.find("process " + std::to_string(getpid())) != std::string::npos);
  }
  CHECK(status_of([&] { ChunkStore(scratch / "work"); }) == ExitStatus::kDone);
}

TEST_CASE("ADirectoryOfOtherThingsIsLeftAlone") {
  const test::ScratchDirectory scratch;
  spill(scratch / "photo.jpg", "precious");
  CHECK(status_of([&] { ChunkStore(scratch.path()); }) == ExitStatus::kUsage);
  CHECK(slurp(scratch / "photo.jpg") == "precious");
  CHECK(count_files(scratch.path(), "") == 1);
}

TEST_CASE("AnotherLayoutVersionIsRefused") {
  const test::ScratchDirectory scratch;
  { const ChunkStore store(scratch / "work"); }
  const fs::path path = scratch / "work/orbweave-store.json";
  spill(path, "{\"format\": \"orbweave chunk store\", \"layout_version\": 1}");
  CHECK(status_of([&] { ChunkStore(scratch / "work"); }) == ExitStatus::kUsage);
  spill(path, "{\"format\": \"orbw");
  CHECK(status_of([&] { ChunkStore(scratch / "work"); }) == ExitStatus::kUsage);
}

TEST_CASE("AnUnusableDirectoryIsAResourceError") {
  const test::ScratchDirectory scratch;
  spill(scratch / "file", "");
  std::string message;
  CHECK(status_of([&] { ChunkStore(scratch / "file/work"); }, &message) == ExitStatus::kResource);
  CHECK(message.find("file/work") != std::string::npos);
  CHECK(status_of([&] { ChunkStore(scratch / "file"); }) == ExitStatus::kResource);
  CHECK(status_of([&] { ChunkStore("/proc/orbweave.work"); }) == ExitStatus::kResource);
}

TEST_CASE("AVanishedDirectoryIsAResourceError") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(100, 1);
  ChunkStore store(scratch / "work");
  store.begin_stage("points", "key");
  store.commit("points", 0, arrays.views(), true);
  fs::remove_all(scratch / "work");
  CHECK(status_of([&] { store.open("points", 0); }) == ExitStatus::kResource);
  CHECK(status_of([&] { store.commit("points", 1, arrays.views(), true); }) ==
        ExitStatus::kResource);
}

TEST_CASE("AFullDiskIsAResourceErrorThatLeavesNoPart") {
  const test::ScratchDirectory scratch;
  // File size limits stand in for a full disk: some stop HDF5's structures, some the data.
  for (const rlim_t limit : {rlim_t{0}, rlim_t{40}, rlim_t{1000}, rlim_t{5000}, rlim_t{100'000}}) {
    const bool good = succeeds_in_child([&] {
      const Arrays arrays = make_arrays(10'000, 1);
      ChunkStore store(scratch / "work");
      store.begin_stage("points", "key");
      store.commit("points", 0, make_arrays(100, 2).views(), true);
      signal(SIGXFSZ, SIG_IGN);
      const rlimit low{limit, RLIM_INFINITY};
      setrlimit(RLIMIT_FSIZE, &low);
      std::string message;
      const bool refused = status_of([&] { store.commit("points", 1, arrays.views(), true); },
                                     &message) == ExitStatus::kResource;
      const rlimit high{RLIM_INFINITY, RLIM_INFINITY};
      setrlimit(RLIMIT_FSIZE, &high);
      const bool named = message.find("File too large") != std::string::npos;
      // With room again the same store goes on.
      const bool kept = same(*store.open("points", 0), make_arrays(100, 2));
      store.commit("points", 1, arrays.views(), true);
      return refused && named && kept && same(*store.open("points", 1), arrays);
    });
    INFO("limit " << limit);
    CHECK(good);
    CHECK(count_files(scratch.path(), ".part") == 0);
  }
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

TEST_CASE("RemoveAllLeavesNothing") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  for (ChunkId chunk = 0; chunk < 50; ++chunk)
    store.commit("points", chunk, make_arrays(500, chunk).views());
  store.remove_all();
  CHECK_FALSE(fs::exists(scratch / "work"));
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

TEST_CASE("ADocumentThatHasToBeThereIsADamagedResultWhereItIsNot") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  store.begin_stage("points", "key");
  CHECK_THROWS_AS(store.expected_document("points", "partition"), CorruptResult);
  store.commit_document("points", "partition", "{}");
  CHECK(store.expected_document("points", "partition") == "{}");
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
  for (const char* name : {"a", "b"}) {
    ChunkStore store(scratch / name);
    store.set_compression(packed);
    store.commit("points", 0, arrays.views());
  }
  CHECK(slurp(scratch / "a/points/000000.h5") == slurp(scratch / "b/points/000000.h5"));
}

}  // namespace orbweave
