// Bins of teams with more members than a process may have files open.
#include "partition/published_bins.h"
#include "partition/count_grid.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <iterator>

#include "tests/partition/clouds.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

constexpr std::size_t kMembers = 300;

std::size_t open_files() {
  std::error_code none;
  const auto all = std::filesystem::directory_iterator("/proc/self/fd", none);
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

}  // namespace

TEST_CASE("BinsOfAManyHeadedTeamAreReadWithFewFilesOpen") {
  const test::ScratchDirectory scratch;
  const PointCloud cloud = test::dressed(test::shell(3 * kMembers, {}, 1.0, 1), 2);
  CountGrid grid;
  grid.add(cloud.positions);
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  const Octree octree = cut_octree(grid, root, 100);
  std::vector<PublishedBins::File> files;
  for (std::size_t member = 0; member < kMembers; ++member) {
    PointCloud share;
    share.schema = cloud.schema;
    for (std::size_t i = 3 * member; i < 3 * member + 3; ++i) share.append(cloud, i);
    const auto file = scratch / ("bins." + std::to_string(member));
    Binner binner(octree, cloud.schema, {std::size_t{1} << 20, file});
    binner.add(share);
    files.push_back({file, binner.publish()});
  }
  const std::size_t before = open_files();
  PublishedBins published(cloud.schema, files);
  CHECK(open_files() < before + kMembers / 2);
  std::size_t wrong = 0;
  for (ChunkId chunk = 0; chunk < octree.chunks().size(); ++chunk) {
    PointCloud expected, taken;
    expected.schema = taken.schema = cloud.schema;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (octree.chunk_of(cloud.positions[i]) == chunk) expected.append(cloud, i);
    published.take(chunk, 1000, [&](PointCloud&& piece) { taken.append(piece); });
    wrong += !test::same_bits(taken, expected);
  }
  CHECK(wrong == 0);
}

}  // namespace orbweave
