// Binning gives back every point, in order, spilled or not.
#include "partition/binning.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <thread>

#include "io/disk_space.h"
#include "io/error.h"
#include "partition/published_bins.h"
#include "tests/partition/clouds.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

Octree cut(const PointCloud& cloud, std::uint64_t chunk_points) {
  CountGrid grid;
  grid.add(cloud.positions);
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  return cut_octree(grid, root, chunk_points);
}

void add_in_batches(Binner& binner, const PointCloud& cloud, std::size_t batch_points) {
  for (std::size_t first = 0; first < cloud.size(); first += batch_points) {
    PointCloud batch;
    batch.schema = cloud.schema;
    for (std::size_t i = first; i < std::min(first + batch_points, cloud.size()); ++i)
      batch.append(cloud, i);
    binner.add(batch);
  }
}

std::vector<PointCloud> expected_bins(const Octree& octree, const PointCloud& cloud) {
  std::vector<PointCloud> bins(octree.chunks().size());
  for (PointCloud& bin : bins) bin.schema = cloud.schema;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    bins[octree.chunk_of(cloud.positions[i])].append(cloud, i);
  return bins;
}

/// The open spill file, which has no name; -1 where the system does not show it.
int spill_file_of_this_process() {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", none)) {
    const auto target = std::filesystem::read_symlink(entry.path(), none);
    if (!none && target.string().find("orbweave-spill-") != std::string::npos)
      return ::open(entry.path().c_str(), O_RDWR | O_CLOEXEC);
  }
  return -1;
}

}  // namespace

TEST_CASE("BinsGiveBackEveryPointInOrder") {
  const test::ScratchDirectory scratch;
  const ScalarType normal_type = GENERATE(ScalarType::kFloat32, ScalarType::kFloat64);
  const std::size_t buffer_bytes =
      GENERATE(std::size_t{0}, std::size_t{300'000}, std::size_t{256} << 20);
  PointCloud cloud = test::dressed(test::shell(20'000, {}, 1.0, 1), 2, normal_type);
  const std::uint64_t chunk_points = GENERATE(20, 1000, 1'000'000);
  const Octree octree = cut(cloud, chunk_points);
  Binner binner(octree, cloud.schema, {buffer_bytes, scratch.path()});
  add_in_batches(binner, cloud, 999);
  const bool fits = buffer_bytes > std::size_t{100} << 20;
  CHECK((binner.spilled_bytes() == 0) == fits);
  const std::vector<PointCloud> expected = expected_bins(octree, cloud);
  for (ChunkId chunk = 0; chunk < expected.size(); ++chunk) {
    REQUIRE(binner.points(chunk) == expected[chunk].size());
    REQUIRE(test::same_bits(binner.take(chunk), expected[chunk]));
    REQUIRE(binner.points(chunk) == 0);
  }
  CHECK(std::filesystem::is_empty(scratch.path()));
}

TEST_CASE("CloudsOfBarePositionsAreBinned") {
  const test::ScratchDirectory scratch;
  PointCloud cloud;
  cloud.positions = test::shell(5000, {}, 1.0, 1);
  const Octree octree = cut(cloud, 100);
  Binner binner(octree, cloud.schema, {4096, scratch.path()});
  std::vector<ChunkId> chunks;
  for (const Vec3& p : cloud.positions) chunks.push_back(octree.chunk_of(p));
  binner.add(cloud, chunks);
  const std::vector<PointCloud> expected = expected_bins(octree, cloud);
  for (ChunkId chunk = 0; chunk < expected.size(); ++chunk)
    REQUIRE(test::same_bits(binner.take(chunk), expected[chunk]));
}

TEST_CASE("PublishedBinsOfSeveralMembersHoldEveryPoint") {
  const test::ScratchDirectory scratch;
  const std::size_t buffer_bytes = GENERATE(std::size_t{0}, std::size_t{256} << 20);
  const PointCloud cloud = test::dressed(test::shell(20'000, {}, 1.0, 1), 2);
  const Octree octree = cut(cloud, 500);
  std::vector<PublishedBins::File> files;
  std::vector<PointCloud> expected(octree.chunks().size());
  for (PointCloud& bin : expected) bin.schema = cloud.schema;
  for (std::size_t member = 0; member < 3; ++member) {
    PointCloud share;
    share.schema = cloud.schema;
    for (std::size_t i = member * 10'000;
         i < std::min<std::size_t>((member + 1) * 10'000, cloud.size()); ++i)
      share.append(cloud, i);
    const std::string name = "bins." + std::to_string(member);
    Binner binner(octree, cloud.schema, {buffer_bytes, scratch.path(), nullptr, name});
    add_in_batches(binner, share, 999);
    files.push_back({scratch.path() / name, binner.publish()});
    const std::vector<PointCloud> bins = expected_bins(octree, share);
    for (ChunkId chunk = 0; chunk < bins.size(); ++chunk) expected[chunk].append(bins[chunk]);
  }
  PublishedBins published(cloud.schema, files);
  const std::size_t piece_points = GENERATE(std::size_t{100}, std::size_t{1'000'000});
  for (ChunkId chunk = 0; chunk < expected.size(); ++chunk) {
    PointCloud taken;
    taken.schema = cloud.schema;
    published.take(chunk, piece_points, [&](PointCloud&& piece) { taken.append(piece); });
    REQUIRE(test::same_bits(taken, expected[chunk]));
  }
  SECTION("a changed byte is noticed") {
    std::fstream file(files[0].path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(files[0].extents[0].offset) + 5);
    file.put('\x5a');
    file.close();
    const auto chunk = static_cast<ChunkId>(files[0].extents[0].chunk);
    CHECK_THROWS_AS(published.take(chunk, 1000, [](PointCloud&&) {}), Error);
  }
}

TEST_CASE("SpilledPointsThatComeBackChangedAreNoticed") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = test::dressed(test::shell(20'000, {}, 1.0, 7), 2);
  const Octree octree = cut(cloud, 1000);
  Binner binner(octree, cloud.schema, {0, scratch.path()});
  binner.add(cloud);
  REQUIRE(binner.spilled_bytes() > 100'000);
  const int file = spill_file_of_this_process();
  if (file < 0) {
    WARN("SKIPPED: /proc/self/fd");
    return;
  }
  char byte = 0;
  REQUIRE(pread(file, &byte, 1, 5000) == 1);
  byte = static_cast<char>(byte ^ 1);
  REQUIRE(pwrite(file, &byte, 1, 5000) == 1);
  ::close(file);
  int changed = 0;
  for (ChunkId chunk = 0; chunk < octree.chunks().size(); ++chunk) {
    try {
      binner.take(chunk);
    } catch (const Error& error) {
      ++changed;
      const std::string words = error.what();
      CHECK(error.status() == ExitStatus::kResource);
      CHECK(words.find(scratch.path().string()) != std::string::npos);
      CHECK(words.find("checksum") != std::string::npos);
    }
  }
  CHECK(changed == 1);
}

TEST_CASE("WhatIsTakenFromTheSpillFileGivesItsRoomBack") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = test::dressed(test::shell(60'000, {}, 1.0, 7), 2);
  const Octree octree = cut(cloud, 5000);
  DiskUsage disk;
  {
    Binner binner(octree, cloud.schema, {std::size_t{1} << 20, scratch.path(), &disk});
    binner.add(cloud);
    REQUIRE(disk.now() == binner.spilled_bytes());
    REQUIRE(disk.now() > 1'000'000);
    const std::uint64_t spilled = disk.now();
    for (ChunkId chunk = 0; chunk < octree.chunks().size(); ++chunk) binner.take(chunk);
    if (disk.now() == spilled) WARN("the file system cannot punch holes");
    CHECK((disk.now() < spilled / 3 || disk.now() == spilled));
    CHECK(disk.most() == spilled);
  }
  CHECK(disk.now() == 0);
}

TEST_CASE("BinsCanBeTakenByManyThreads") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = test::dressed(test::shell(40'000, {}, 1.0, 5), 2);
  const Octree octree = cut(cloud, 100);
  Binner binner(octree, cloud.schema, {std::size_t{1} << 20, scratch.path()});
  add_in_batches(binner, cloud, 4096);
  const std::vector<PointCloud> expected = expected_bins(octree, cloud);
  std::atomic<ChunkId> next{0};
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (ChunkId chunk = next++; chunk < expected.size(); chunk = next++)
        wrong += !test::same_bits(binner.take(chunk), expected[chunk]);
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
}

TEST_CASE("ADiskThatCannotTakeTheSpillIsAResourceError") {
  const PointCloud cloud = test::dressed(test::shell(5000, {}, 1.0, 5), 2);
  const Octree octree = cut(cloud, 100);
  Binner binner(octree, cloud.schema, {0, "/nowhere/at/all"});
  try {
    binner.add(cloud);
    FAIL("spilled to nowhere");
  } catch (const Error& error) {
    CHECK(error.status() == ExitStatus::kResource);
    CHECK(std::string(error.what()).find("/nowhere/at/all") != std::string::npos);
    CHECK(std::string(error.what()).find("No such file or directory") != std::string::npos);
  }
}

TEST_CASE("AFullDiskIsAResourceErrorWithTheSystemsReason") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = test::dressed(test::shell(20'000, {}, 1.0, 5), 2);
  const Octree octree = cut(cloud, 1000);
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit low{100'000, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &low);
    try {
      Binner binner(octree, cloud.schema, {0, scratch.path()});
      binner.add(cloud);
    } catch (const Error& error) {
      const bool named = std::string(error.what()).find("File too large") != std::string::npos;
      _exit(error.status() == ExitStatus::kResource && named ? 0 : 1);
    }
    _exit(2);
  }
  int status = 0;
  waitpid(child, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}

}  // namespace orbweave
