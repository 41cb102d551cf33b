// The stitched mesh, read back chunk by chunk.
#include "engine/pipeline/surface/stored_surface.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <iterator>
#include <vector>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stages.h"
#include "io/error.h"
#include "io/sort_unique.h"
#include "io/stop_token.h"
#include "io/store/chunk_store.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

using test::job_for;
using test::NamedCloud;
using test::run;
using test::ScratchDirectory;

/// A job's chunks, as its hole pass finds them.
struct Chunks {
  ScratchDirectory scratch;
  double reach = 0.0;
  std::string work_dir;

  Chunks() {
    const NamedCloud named = test::painted_torus(6000, 0.3, 7);
    Job job = job_for(scratch, named);
    job.partition.chunk_points = 400;
    job.run.keep_work_dir = true;
    job.run.work_dir = (scratch / "kept").string();
    const RunReport report = run(job);
    REQUIRE(report.chunks > 8);
    reach = longest_edge(report.radii);
    work_dir = job.run.work_dir;
  }
};

std::vector<TriangleAt> one_by_one(const StoredSurface& surface,
                                   const std::vector<std::uint64_t>& vertices) {
  std::vector<TriangleAt> found;
  for (const std::uint64_t vertex : vertices) {
    std::vector<Triangle64> around;
    surface.triangles_at(vertex, around);
    for (const Triangle64& t : around) found.push_back({vertex, t});
  }
  return found;
}

TEST_CASE("TrianglesAtVerticesAllOverAreThoseAtEachVertex") {
  const Chunks chunks;
  const ChunkStore store(chunks.work_dir);
  const Partition partition = expected_partition(store, kPointsStage);
  constexpr std::size_t kRoom = std::size_t{64} << 20;
  StoredSurface surface(store, partition, chunks.reach, kRoom, false);
  std::vector<std::uint64_t> all, some;
  for (std::uint64_t v = 0; v < partition.points(); ++v) {
    all.push_back(v);
    if (v % 7 == 3) some.push_back(v);
  }
  const StopToken stop;
  const std::vector<TriangleAt> found = surface.collect_triangles_at(all, stop);
  REQUIRE(found.size() > all.size());
  CHECK((found == one_by_one(surface, all)));
  CHECK((surface.collect_triangles_at(some, stop) == one_by_one(surface, some)));
  CHECK(surface.collect_triangles_at({}, stop).empty());

  // Without triangles that were removed.
  std::vector<Triangle64> removed;
  for (std::size_t i = 0; i < found.size(); i += 50) removed.push_back(found[i].triangle);
  std::sort(removed.begin(), removed.end());
  surface.remove(removed);
  const std::vector<TriangleAt> left = surface.collect_triangles_at(all, stop);
  CHECK(left.size() < found.size());
  CHECK((left == one_by_one(surface, all)));
}

/// The triangles at vertices, each once, sorted.
std::vector<Triangle64> all_at(const StoredSurface& surface,
                               const std::vector<std::uint64_t>& vertices) {
  std::vector<Triangle64> all;
  for (const TriangleAt& each : one_by_one(surface, vertices)) all.push_back(each.triangle);
  sort_unique(all);
  return all;
}

TEST_CASE("TrianglesThatWereMetAreNotGivenAgain") {
  const Chunks chunks;
  const ChunkStore store(chunks.work_dir);
  const Partition partition = expected_partition(store, kPointsStage);
  StoredSurface surface(store, partition, chunks.reach, std::size_t{64} << 20, false);
  REQUIRE_FALSE(surface.is_at_hand());
  std::vector<std::uint64_t> some, more;
  for (std::uint64_t v = 0; v < partition.points(); ++v) {
    if (v % 5 == 2) some.push_back(v);
    if (v % 3 == 1) more.push_back(v);
  }
  const auto check = [&] {
    TriangleMarks met;
    std::vector<Triangle64> first, second;
    surface.new_triangles_at(some, met, first);
    surface.new_triangles_at(more, met, second);
    std::sort(first.begin(), first.end());
    std::sort(second.begin(), second.end());
    const std::vector<Triangle64> at_some = all_at(surface, some), at_more = all_at(surface, more);
    CHECK((first == at_some));
    std::vector<Triangle64> expected;
    std::set_difference(at_more.begin(), at_more.end(), at_some.begin(), at_some.end(),
                        std::back_inserter(expected));
    REQUIRE(expected.size() < at_more.size());
    CHECK((second == expected));
    return first;
  };
  std::vector<Triangle64> removed = check();
  for (std::size_t i = 0; i < removed.size() / 40; ++i) removed[i] = removed[40 * i];
  removed.resize(removed.size() / 40);
  surface.remove(removed);
  const std::vector<Triangle64> left = check();
  CHECK(std::ranges::none_of(
      removed, [&](const Triangle64& t) { return std::ranges::binary_search(left, t); }));
}

TEST_CASE("TrianglesAtVerticesAllOverAreReadOnceWithoutMemoryForChunks") {
  const Chunks chunks;
  const ChunkStore store(chunks.work_dir);
  const Partition partition = expected_partition(store, kPointsStage);
  const StoredSurface surface(store, partition, chunks.reach, 0, false);
  std::vector<std::uint64_t> vertices;
  for (std::uint64_t v = 0; v < partition.points(); v += 3) vertices.push_back(v);
  std::uint64_t stored = 0;
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk) {
    const auto result = store.open(kMeshStage, chunk);
    stored += result->rows("triangles") * sizeof(Triangle) +
              result->rows("outer_vertices") * sizeof(std::uint64_t);
  }
  const std::uint64_t before = store.bytes_read();
  REQUIRE_FALSE(surface.collect_triangles_at(vertices, StopToken()).empty());
  CHECK(store.bytes_read() - before <= stored + stored / 4);
}

TEST_CASE("GatheringTrianglesEndsWhenTheJobIsStopped") {
  const Chunks chunks;
  const ChunkStore store(chunks.work_dir);
  const Partition partition = expected_partition(store, kPointsStage);
  const StoredSurface surface(store, partition, chunks.reach, 0, false);
  const std::vector<std::uint64_t> vertices = {0, partition.points() - 1};
  StopToken stop;
  stop.request();
  CHECK_THROWS_AS(surface.collect_triangles_at(vertices, stop), Error);
}

}  // namespace
}  // namespace orbweave
