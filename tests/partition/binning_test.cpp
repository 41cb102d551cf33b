// Binning gives back every point, in order, spilled or not.
#include "partition/binning.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <memory>
#include <thread>

#include "io/error.h"
#include "io/system/disk_space.h"
#include "partition/count_grid.h"
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

/// The bins of a cloud that was added in batches, from memory or, where they spilled, from the
/// file.
std::unique_ptr<BinSource> published(std::unique_ptr<Binner> binner, const PointSchema& schema,
                                     const std::filesystem::path& file, DiskUsage* disk = nullptr) {
  if (binner->spilled_bytes() == 0) return binner;
  return std::make_unique<PublishedBins>(
      schema, std::vector<PublishedBins::File>{{file, binner->publish()}}, disk);
}

PointCloud take(BinSource& bins, ChunkId chunk, const PointSchema& schema) {
  PointCloud taken;
  taken.schema = schema;
  bins.take(chunk, 1000, [&](PointCloud&& piece) { taken.append(piece); });
  return taken;
}

}  // namespace

TEST_CASE("BinsGiveBackEveryPointInOrder", "[costly]") {
  const test::ScratchDirectory scratch;
  const ScalarType normal_type = GENERATE(ScalarType::kFloat32, ScalarType::kFloat64);
  const std::size_t buffer_bytes =
      GENERATE(std::size_t{0}, std::size_t{300'000}, std::size_t{256} << 20);
  PointCloud cloud = test::dressed(test::shell(20'000, {}, 1.0, 1), 2, normal_type);
  const std::uint64_t chunk_points = GENERATE(20, 1000, 1'000'000);
  const Octree octree = cut(cloud, chunk_points);
  const std::filesystem::path file = scratch / "bins";
  auto binner = std::make_unique<Binner>(octree, cloud.schema, Binner::Options{buffer_bytes, file});
  add_in_batches(*binner, cloud, 999);
  const bool fits = buffer_bytes > std::size_t{100} << 20;
  CHECK((binner->spilled_bytes() == 0) == fits);
  CHECK(std::filesystem::exists(file) == !fits);
  const std::vector<PointCloud> expected = expected_bins(octree, cloud);
  for (ChunkId chunk = 0; chunk < expected.size(); ++chunk)
    REQUIRE(binner->points(chunk) == expected[chunk].size());
  const auto bins = published(std::move(binner), cloud.schema, file);
  for (ChunkId chunk = 0; chunk < expected.size(); ++chunk)
    REQUIRE(test::same_bits(take(*bins, chunk, cloud.schema), expected[chunk]));
}

TEST_CASE("CloudsOfBarePositionsAreBinned") {
  const test::ScratchDirectory scratch;
  PointCloud cloud;
  cloud.positions = test::shell(5000, {}, 1.0, 1);
  const Octree octree = cut(cloud, 100);
  auto binner =
      std::make_unique<Binner>(octree, cloud.schema, Binner::Options{4096, scratch / "bins"});
  std::vector<ChunkId> chunks;
  for (const Vec3& p : cloud.positions) chunks.push_back(octree.chunk_of(p));
  binner->add(cloud, chunks);
  const std::vector<PointCloud> expected = expected_bins(octree, cloud);
  const auto bins = published(std::move(binner), cloud.schema, scratch / "bins");
  for (ChunkId chunk = 0; chunk < expected.size(); ++chunk)
    REQUIRE(test::same_bits(take(*bins, chunk, cloud.schema), expected[chunk]));
}

TEST_CASE("PublishedBinsOfSeveralMembersHoldEveryPoint", "[costly]") {
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
    const auto file = scratch / ("bins." + std::to_string(member));
    Binner binner(octree, cloud.schema, {buffer_bytes, file});
    add_in_batches(binner, share, 999);
    files.push_back({file, binner.publish()});
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
    CHECK_THROWS_AS(published.take(chunk, 1000, [](PointCloud&&) {}), CorruptResult);
  }
  SECTION("a lost end is noticed") {
    std::filesystem::resize_file(files[1].path, std::filesystem::file_size(files[1].path) - 1);
    const auto last = std::max_element(
        files[1].extents.begin(), files[1].extents.end(),
        [](const BinExtent& a, const BinExtent& b) { return a.offset < b.offset; });
    const auto chunk = static_cast<ChunkId>(last->chunk);
    CHECK_THROWS_AS(published.take(chunk, 1000, [](PointCloud&&) {}), CorruptResult);
  }
  SECTION("a file that is gone is noticed") {
    std::filesystem::remove(files[1].path);
    CHECK_THROWS_AS(PublishedBins(cloud.schema, files), CorruptResult);
  }
}

TEST_CASE("ABinnerGoesOnWhereAnEarlierOneHadWrittenEverything") {
  const test::ScratchDirectory scratch;
  const std::filesystem::path file = scratch / "bins";
  const PointCloud cloud = test::dressed(test::shell(20'000, {}, 1.0, 1), 2);
  const Octree octree = cut(cloud, 500);
  const auto rows = [&](std::size_t first, std::size_t last) {
    PointCloud part;
    part.schema = cloud.schema;
    for (std::size_t i = first; i < last; ++i) part.append(cloud, i);
    return part;
  };
  DiskUsage disk;
  std::vector<BinExtent> extents;
  std::uint64_t kept = 0;
  {
    Binner killed(octree, cloud.schema, {0, file, &disk});
    killed.add(rows(0, 9'000));
    extents = killed.write_out();
    kept = killed.spilled_bytes();
    killed.add(rows(9'000, 15'000));  // not told to anybody
    CHECK(killed.spilled_bytes() > kept);
  }
  int before = 0;
  Binner next(octree, cloud.schema, {0, file, &disk, [&] { ++before; }, kept});
  CHECK(before == 0);
  next.add(rows(9'000, 20'000));
  CHECK(before == 1);
  for (const BinExtent& extent : next.publish()) extents.push_back(extent);
  CHECK(disk.now() == std::filesystem::file_size(file));
  PublishedBins bins(cloud.schema, {{file, extents}});
  const std::vector<PointCloud> expected = expected_bins(octree, cloud);
  for (ChunkId chunk = 0; chunk < expected.size(); ++chunk)
    REQUIRE(test::same_bits(take(bins, chunk, cloud.schema), expected[chunk]));
}

TEST_CASE("ABinThatIsGivenBackTakesNoRoomAndTheOthersAreWhole") {
  const test::ScratchDirectory scratch;
  const std::filesystem::path file = scratch / "bins";
  const PointCloud cloud = test::dressed(test::shell(60'000, {}, 1.0, 7), 2);
  const Octree octree = cut(cloud, 5000);
  DiskUsage disk;
  auto binner = std::make_unique<Binner>(octree, cloud.schema,
                                         Binner::Options{std::size_t{1} << 20, file, &disk});
  binner->add(cloud);
  const auto bins = published(std::move(binner), cloud.schema, file, &disk);
  const std::uint64_t spilled = disk.now();
  REQUIRE(spilled == std::filesystem::file_size(file));
  REQUIRE(spilled > 1'000'000);
  const std::vector<PointCloud> expected = expected_bins(octree, cloud);
  for (ChunkId chunk = 1; chunk < expected.size(); chunk += 2) bins->give_back(chunk);
  for (ChunkId chunk = 0; chunk < expected.size(); chunk += 2)
    REQUIRE(test::same_bits(take(*bins, chunk, cloud.schema), expected[chunk]));
  if (disk.now() == spilled) WARN("the file system cannot punch holes");
  CHECK((disk.now() < spilled * 3 / 4 || disk.now() == spilled));
  CHECK(disk.most() == spilled);
  // What was given back is nobody's any more.
  if (disk.now() < spilled) CHECK_THROWS_AS(take(*bins, 1, cloud.schema), CorruptResult);
  for (ChunkId chunk = 0; chunk < expected.size(); chunk += 2) bins->give_back(chunk);
  CHECK((disk.now() < spilled / 3 || disk.now() == spilled));
  CHECK((room_of_directory(scratch.path()) < spilled / 2 || disk.now() == spilled));
}

TEST_CASE("BinsCanBeTakenByManyThreads") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = test::dressed(test::shell(40'000, {}, 1.0, 5), 2);
  const Octree octree = cut(cloud, 100);
  const std::size_t buffer_bytes = GENERATE(std::size_t{1} << 20, std::size_t{64} << 20);
  auto binner = std::make_unique<Binner>(octree, cloud.schema,
                                         Binner::Options{buffer_bytes, scratch / "bins"});
  add_in_batches(*binner, cloud, 4096);
  const auto bins = published(std::move(binner), cloud.schema, scratch / "bins");
  const std::vector<PointCloud> expected = expected_bins(octree, cloud);
  std::atomic<ChunkId> next{0};
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (ChunkId chunk = next++; chunk < expected.size(); chunk = next++) {
        wrong += !test::same_bits(take(*bins, chunk, cloud.schema), expected[chunk]);
        bins->give_back(chunk);
      }
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
    CHECK(error.kind() == ErrorKind::kResource);
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
      Binner binner(octree, cloud.schema, {0, scratch / "bins"});
      binner.add(cloud);
    } catch (const Error& error) {
      const bool named = std::string(error.what()).find("File too large") != std::string::npos;
      _exit(error.kind() == ErrorKind::kResource && named ? 0 : 1);
    }
    _exit(2);
  }
  int status = 0;
  waitpid(child, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}

}  // namespace orbweave
