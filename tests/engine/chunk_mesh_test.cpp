// What a chunk owns of the mesh, in numbers of its own, and what these are in the whole cloud.
#include "engine/stitching/chunk_mesh.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <set>

#include "engine/stitching/local_numbers.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

using test::NamedCloud;

/// The whole cloud, of which the chunk owns points [begin, end).
ChunkPoints owning(const NamedCloud& named, std::size_t begin, std::size_t end) {
  ChunkPoints points;
  points.positions = named.cloud.positions;
  points.normals = named.cloud.normals;
  points.global.resize(named.cloud.size());
  std::iota(points.global.begin(), points.global.end(), std::uint64_t{0});
  points.owned.assign(named.cloud.size(), 0);
  for (std::size_t i = begin; i < end; ++i) points.owned[i] = 1;
  points.owned_begin = static_cast<std::uint32_t>(begin);
  points.owned_end = static_cast<std::uint32_t>(end);
  return points;
}

ChunkMesh mesh_of(const NamedCloud& named, const ChunkPoints& points) {
  const std::vector<double> radii = {named.ball_radius};
  return make_chunk_mesh(points,
                         ball_pivoting(points.positions, points.normals, points.owned, {radii, {}}),
                         named.cloud.bounds(), 2.0 * radii.back());
}

struct ChunkOfACloud {
  std::size_t first = 0;
  std::size_t points = 0;
  ChunkMesh mesh;

  LocalNumbers numbers() const { return {first, points, mesh.outer_vertices}; }
  std::vector<Triangle64> triangles() const {
    std::vector<Triangle64> all;
    for (const Triangle& t : mesh.triangles) all.push_back(numbers().global(t));
    return all;
  }
};

std::vector<ChunkOfACloud> in_chunks(const NamedCloud& named, std::size_t chunks) {
  std::vector<ChunkOfACloud> all;
  for (std::size_t i = 0; i < chunks; ++i) {
    const std::size_t begin = named.cloud.size() * i / chunks;
    const std::size_t end = named.cloud.size() * (i + 1) / chunks;
    all.push_back({begin, end - begin, mesh_of(named, owning(named, begin, end))});
  }
  return all;
}

std::vector<NamedCloud> clouds() {
  return {test::noisy_torus(3000, 0.0, 5), test::noisy_torus(3000, 0.7, 6),
          test::random_sphere(2000, 7)};
}

}  // namespace

TEST_CASE("ChunksInTheirOrderAreTheTrianglesOfTheWholeMeshInTheirs") {
  for (const NamedCloud& named : clouds()) {
    INFO(named.name);
    const std::vector<Triangle64> whole = in_chunks(named, 1).front().triangles();
    REQUIRE(whole.size() > 1000);
    CHECK(std::is_sorted(whole.begin(), whole.end()));
    std::vector<Triangle64> joined;
    for (const ChunkOfACloud& chunk : in_chunks(named, 5)) {
      const std::vector<Triangle64> part = chunk.triangles();
      joined.insert(joined.end(), part.begin(), part.end());
    }
    CHECK((joined == whole));
  }
}

TEST_CASE("AChunkKnowsTheOtherVerticesOfItsTrianglesAndNoMore") {
  for (const NamedCloud& named : clouds()) {
    INFO(named.name);
    for (const ChunkOfACloud& chunk : in_chunks(named, 4)) {
      std::set<std::uint64_t> others;
      for (const Triangle64& t : chunk.triangles()) {
        CHECK(t[0] - chunk.first < chunk.points);
        for (const std::uint64_t vertex : t) {
          if (vertex - chunk.first >= chunk.points) others.insert(vertex);
        }
      }
      const std::vector<std::uint64_t>& outer = chunk.mesh.outer_vertices;
      REQUIRE(outer == std::vector<std::uint64_t>(others.begin(), others.end()));
      REQUIRE(chunk.mesh.outer_positions.size() == outer.size());
      for (std::size_t i = 0; i < outer.size(); ++i) {
        CHECK(chunk.mesh.outer_positions[i] == named.cloud.positions[outer[i]]);
      }
    }
  }
}

TEST_CASE("NumbersWithinAChunkAndInTheCloudLeadToEachOther") {
  const std::vector<std::uint64_t> outer = {3, 9, 31, std::uint64_t{1} << 40};
  const LocalNumbers numbers(10, 20, outer);
  REQUIRE(numbers.count() == 24);
  for (std::uint32_t local = 0; local < numbers.count(); ++local) {
    CHECK(numbers.local(numbers.global(local)) == local);
  }
  CHECK(numbers.global(Triangle{0, 20, 23}) == Triangle64{10, 3, std::uint64_t{1} << 40});
  for (const std::uint64_t unknown : {0u, 4u, 30u, 32u}) {
    CHECK(numbers.local(unknown) == numbers.count());
  }
}

TEST_CASE("PiecesOfAChunkHoldItsTriangles") {
  for (const NamedCloud& named : clouds()) {
    INFO(named.name);
    for (const ChunkOfACloud& chunk : in_chunks(named, 3)) {
      const std::vector<Triangle64> triangles = chunk.triangles();
      Box box, of_pieces;
      for (const Triangle64& t : triangles) {
        for (const std::uint64_t vertex : t) box.extend(named.cloud.positions[vertex]);
      }
      std::uint64_t count = 0;
      for (const ChunkPiece& piece : chunk.mesh.pieces) {
        count += piece.triangles;
        of_pieces.extend(piece.box);
        if (piece.triangles == 0) continue;
        CHECK(std::binary_search(triangles.begin(), triangles.end(), piece.first));
      }
      CHECK(count == triangles.size());
      CHECK(of_pieces.min == box.min);
      CHECK(of_pieces.max == box.max);
    }
  }
}

}  // namespace orbweave
