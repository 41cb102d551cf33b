// Of results that are damaged, half there or in no place for them, nothing wrong comes back.
#include <hdf5.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <functional>
#include <random>

#include "io/report/machine.h"
#include "io/store/chunk_store.h"
#include "io/store/chunk_store_file.h"
#include "io/system/hdf5_calls.h"
#include "tests/io/stored_arrays.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::Arrays;
using test::count_files;
using test::file_text;
using test::make_arrays;
using test::put;
using test::same;
using test::status_of;
using test::succeeds_in_child;
using test::write_text;

}  // namespace

TEST_CASE("UncommittedResultsAreInvisible") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(2000, 1);
  // A process that ends in the middle of writing leaves a part file at most.
  CHECK(succeeds_in_child([&] {
    ChunkStore store(scratch / "work");
    store.begin_stage("points", "key");
    store.commit("points", 1, arrays.views(), true);
    const fs::path part = scratch / "work/points/.000002.h5.part";
    store.record()->create(part);
    write_text(part, file_text(scratch / "work/points/000001.h5"));
    return true;
  }));
  ChunkStore store(scratch / "work");
  CHECK(store.begin_stage("points", "key"));
  CHECK(store.has("points", 1));
  CHECK_FALSE(store.has("points", 2));
  CHECK_THROWS_AS(store.open("points", 2), CorruptResult);
  CHECK(count_files(scratch / "work", ".part") == 0);
}

TEST_CASE("ResultsThatPromiseMoreThanTheirFileHoldsAreRefused") {
  const test::ScratchDirectory scratch;
  {
    ChunkStore store(scratch / "work");
    store.commit("points", 0, make_arrays(5000, 9).views());
  }
  const fs::path path = scratch / "work/points/000000.h5";
  const std::string good = file_text(path);
  struct Promise {
    hsize_t rows, columns;
    hsize_t chunk_rows = 0;  ///< 0: the array lies in one piece
  };
  constexpr hsize_t kHuge = hsize_t{1} << 60;
  for (const Promise& promise :
       {Promise{kHuge, 3}, Promise{kHuge, 3, kRowsPerChecksum}, Promise{5000, kHuge},
        Promise{5000, hsize_t{1} << 31}, Promise{~hsize_t{0} - 4000, 3},
        Promise{hsize_t{1} << 36, 3, kRowsPerChecksum}}) {
    INFO(promise.rows << " x " << promise.columns << ", " << promise.chunk_rows);
    write_text(path, good);
    {
      const Hdf5Calls calls;
      const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
      const auto replace = [&](const char* name, std::vector<hsize_t> shape, hid_t type,
                               hsize_t chunk_rows) {
        REQUIRE(H5Ldelete(file.get(), name, H5P_DEFAULT) >= 0);
        const Hdf5Handle space(
            H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
        const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        const hsize_t chunk[2] = {chunk_rows, shape.back()};
        if (chunk_rows > 0) H5Pset_chunk(creation.get(), 2, chunk);
        const Hdf5Handle made(H5Dcreate2(file.get(), name, type, space.get(), H5P_DEFAULT,
                                         creation.get(), H5P_DEFAULT),
                              H5Dclose);
        return made.valid();
      };
      REQUIRE(file.valid());
      const hsize_t blocks = promise.rows / kRowsPerChecksum + 1;
      // HDF5 itself refuses some.
      if (!replace("values", {promise.rows, promise.columns}, H5T_NATIVE_DOUBLE,
                   promise.chunk_rows))
        continue;
      REQUIRE(replace("values.xxh3", {blocks}, H5T_NATIVE_UINT64, 0));
    }
    const std::uint64_t before = peak_memory_bytes();
    const ChunkStore store(scratch / "work");
    CHECK_THROWS_AS(store.open("points", 0), CorruptResult);
    CHECK(peak_memory_bytes() - before < 50'000'000);
  }
}

TEST_CASE("ResultsOfAKilledProcessAreWholeOrAbsent", "[costly]") {
  const test::ScratchDirectory scratch;
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 8; ++trial) {
    const std::size_t wanted = test::results_in(scratch / "work") + 1 + random() % 60;
    const pid_t child = fork();
    if (child == 0) {
      ChunkStore store(scratch / "work");
      store.begin_stage("points", "key");
      for (ChunkId chunk = 0; chunk < 100'000; ++chunk)
        store.commit("points", chunk % 500, make_arrays(700, chunk % 500).views(), chunk % 7 == 0);
      _exit(0);
    }
    while (test::results_in(scratch / "work") < wanted) {
      REQUIRE(waitpid(child, nullptr, WNOHANG) == 0);
      usleep(1000);
    }
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    ChunkStore store(scratch / "work");
    store.begin_stage("points", "key");
    for (ChunkId chunk = 0; chunk < 500; ++chunk)
      if (store.has("points", chunk))
        REQUIRE(same(*store.open("points", chunk), make_arrays(700, chunk)));
  }
}

TEST_CASE("AFlippedByteNeverGivesWrongData", "[soak]") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(1500, 9);
  const bool packed = GENERATE(false, true);
  {
    ChunkStore store(scratch / "work");
    store.set_compression(packed);
    store.commit("points", 0, arrays.views());
  }
  const fs::path path = scratch / "work/points/000000.h5";
  const std::string good = file_text(path);
  int detected = 0;
  int harmless = 0;
  int step = 1;
  for (std::size_t at = 0; at < good.size(); at += static_cast<std::size_t>(step)) {
    // HDF5's own structures lie at the ends: every fifth byte there, in turn in both forms of a
    // file, and a sample of the data.
    step = at < 6000 || at + 3000 > good.size() ? (packed ? 7 : 5) : 61;
    put(path, at, good[at] ^ (1 << at % 8));
    try {
      const ChunkStore store(scratch / "work");
      const bool right = same(*store.open("points", 0), arrays);
      REQUIRE(right);
      ++harmless;
    } catch (const CorruptResult& corrupt) {
      REQUIRE(corrupt.path() == path);
      REQUIRE(corrupt.kind() == ErrorKind::kResource);
      ++detected;
    }
    put(path, at, good[at]);
  }
  CHECK(detected > 200);
  CHECK(harmless < 300);  // padding between HDF5's structures
}

TEST_CASE("AFlippedByteInAnyArrayIsDetected") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(5000, 9);
  ChunkStore store(scratch / "work");
  store.commit("points", 0, arrays.views(), true);
  const fs::path path = scratch / "work/points/000000.h5";
  const std::string good = file_text(path);
  const auto find = [&](const void* bytes, std::size_t size) {
    const std::string needle(static_cast<const char*>(bytes), size);
    return good.find(needle);
  };
  const std::size_t values_at = find(arrays.values.data(), 64);
  const std::size_t bytes_at = find(arrays.bytes.data(), 64);
  REQUIRE(values_at != std::string::npos);
  REQUIRE(bytes_at != std::string::npos);
  const auto damaged = [&](std::size_t at) {
    write_text(path, good);
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

TEST_CASE("ADirectoryOfOtherThingsIsLeftAlone") {
  const test::ScratchDirectory scratch;
  write_text(scratch / "photo.jpg", "precious");
  CHECK(status_of([&] { ChunkStore(scratch.path()); }) == ErrorKind::kUsage);
  CHECK(file_text(scratch / "photo.jpg") == "precious");
  CHECK(count_files(scratch.path(), "") == 1);
}

TEST_CASE("AnotherLayoutVersionIsRefused") {
  const test::ScratchDirectory scratch;
  { const ChunkStore store(scratch / "work"); }
  const fs::path path = scratch / "work/orbweave-store.json";
  write_text(path, "{\"format\": \"orbweave chunk store\", \"layout_version\": 1}");
  CHECK(status_of([&] { ChunkStore(scratch / "work"); }) == ErrorKind::kUsage);
  CHECK(file_text(path) == "{\"format\": \"orbweave chunk store\", \"layout_version\": 1}");
}

TEST_CASE("AnUnusableDirectoryIsAResourceError") {
  const test::ScratchDirectory scratch;
  write_text(scratch / "file", "");
  std::string message;
  CHECK(status_of([&] { ChunkStore(scratch / "file/work"); }, &message) == ErrorKind::kResource);
  CHECK(message.find("file/work") != std::string::npos);
  CHECK(status_of([&] { ChunkStore(scratch / "file"); }) == ErrorKind::kResource);
  CHECK(status_of([&] { ChunkStore("/proc/orbweave.work"); }) == ErrorKind::kResource);
}

TEST_CASE("AVanishedDirectoryIsAResourceError") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(100, 1);
  ChunkStore store(scratch / "work");
  store.begin_stage("points", "key");
  store.commit("points", 0, arrays.views(), true);
  fs::remove_all(scratch / "work");
  CHECK(status_of([&] { store.open("points", 0); }) == ErrorKind::kResource);
  CHECK(status_of([&] { store.commit("points", 1, arrays.views(), true); }) ==
        ErrorKind::kResource);
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
                                     &message) == ErrorKind::kResource;
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

TEST_CASE("ADocumentThatHasToBeThereIsADamagedResultWhereItIsNot") {
  const test::ScratchDirectory scratch;
  ChunkStore store(scratch / "work");
  store.begin_stage("points", "key");
  CHECK_THROWS_AS(store.expected_document("points", "partition"), CorruptResult);
  store.commit_document("points", "partition", "{}");
  CHECK(store.expected_document("points", "partition") == "{}");
}

}  // namespace orbweave
