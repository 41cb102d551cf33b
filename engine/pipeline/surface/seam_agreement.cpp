#include "engine/pipeline/surface/seam_agreement.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

#include "io/sort_unique.h"
#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

bool has(const std::vector<std::uint64_t>& sorted, std::uint64_t vertex) {
  return std::binary_search(sorted.begin(), sorted.end(), vertex);
}

std::vector<std::uint64_t> vertices_of(std::span<const Triangle64> triangles) {
  std::vector<std::uint64_t> vertices;
  for (const Triangle64& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
  sort_unique(vertices);
  return vertices;
}

/// Those that a vertex of the list belongs to.
std::vector<Triangle64> touching(const std::vector<Triangle64>& triangles,
                                 const std::vector<std::uint64_t>& vertices) {
  std::vector<Triangle64> found;
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(found),
               [&](const Triangle64& t) {
                 return has(vertices, t[0]) || has(vertices, t[1]) || has(vertices, t[2]);
               });
  return found;
}

}  // namespace

Vec3 SeamAgreement::Places::of(std::uint64_t vertex) const {
  const auto at = std::lower_bound(vertices.begin(), vertices.end(), vertex);
  return positions[static_cast<std::size_t>(at - vertices.begin())];
}

SeamAgreement::Places SeamAgreement::places_of(std::vector<std::uint64_t> vertices) const {
  Places places;
  places.vertices = std::move(vertices);
  for (std::size_t i = 0; i < places.vertices.size();) {
    const ChunkId chunk = partition_.chunk_of(places.vertices[i]);
    const std::uint64_t first = partition_.first_vertex[chunk];
    std::vector<Vec3> positions(partition_.points_in(chunk)), normals(positions.size());
    load_oriented_points(store_, chunk, partition_.schema, positions, normals);
    for (; i < places.vertices.size() && is_owned(places.vertices[i], chunk); ++i) {
      places.positions.push_back(positions[places.vertices[i] - first]);
      places.normals.push_back(normals[places.vertices[i] - first]);
    }
  }
  return places;
}

const std::vector<Triangle64>& SeamAgreement::seam_of(ChunkId chunk) {
  const auto found = seams_.find(chunk);
  if (found != seams_.end()) return found->second;
  return seams_.emplace(chunk, load_seam_triangles(store_, chunk)).first->second;
}

std::vector<ChunkId> SeamAgreement::chunks_of(const Triangle64& triangle) const {
  std::vector<ChunkId> chunks;
  for (const std::uint64_t vertex : triangle) chunks.push_back(partition_.chunk_of(vertex));
  sort_unique(chunks);
  return chunks;
}

bool SeamAgreement::all_have(const Triangle64& triangle, const Places& places) {
  for (std::size_t k = 0; k < 3; ++k)
    if (norm(places.of(triangle[k]) - places.of(triangle[(k + 1) % 3])) > longest_) return false;
  const std::vector<ChunkId> chunks = chunks_of(triangle);
  return std::all_of(chunks.begin(), chunks.end(), [&](ChunkId chunk) {
    const std::vector<Triangle64>& seam = seam_of(chunk);
    return std::binary_search(seam.begin(), seam.end(), triangle);
  });
}

AgreedTriangles SeamAgreement::of(ChunkId chunk, const ChunkCells& cells) {
  AgreedTriangles agreed;
  agreed.all = cells.inner;
  const Places places = places_of(vertices_of(cells.seam));
  for (const Triangle64& t : cells.seam) {
    if (all_have(t, places)) {
      agreed.all.push_back(t);
      agreed.seam += is_owned(t[0], chunk) ? 1 : 0;
      continue;
    }
    for (const ChunkId other : chunks_of(t)) {
      const std::vector<Triangle64>& seam = seam_of(other);
      if (!std::binary_search(seam.begin(), seam.end(), t)) continue;
      agreed.contested += other == chunk ? 1 : 0;
      break;  // the first that has it counts it
    }
  }
  add_around(chunk, agreed.all);
  sort_unique(agreed.all);
  return agreed;
}

/// Adds the triangles of others at the vertices that they own of these.
void SeamAgreement::add_around(ChunkId chunk, std::vector<Triangle64>& triangles) {
  std::vector<std::uint64_t> outer = vertices_of(triangles);
  std::erase_if(outer, [&](std::uint64_t vertex) { return is_owned(vertex, chunk); });
  std::vector<Triangle64> across;
  for (std::size_t i = 0; i < outer.size();) {
    const ChunkId owner = partition_.chunk_of(outer[i]);
    const std::vector<Triangle64> inner = touching(load_inner_triangles(store_, owner), outer);
    triangles.insert(triangles.end(), inner.begin(), inner.end());
    const std::vector<Triangle64> seam = touching(seam_of(owner), outer);
    across.insert(across.end(), seam.begin(), seam.end());
    while (i < outer.size() && is_owned(outer[i], owner)) ++i;
  }
  sort_unique(across);
  const Places places = places_of(vertices_of(across));
  std::copy_if(across.begin(), across.end(), std::back_inserter(triangles),
               [&](const Triangle64& t) { return all_have(t, places); });
}

ChunkPoints SeamAgreement::points_of(ChunkId chunk,
                                     const std::vector<Triangle64>& triangles) const {
  std::vector<std::uint64_t> outer = vertices_of(triangles);
  std::erase_if(outer, [&](std::uint64_t vertex) { return is_owned(vertex, chunk); });
  const std::uint64_t first = partition_.first_vertex[chunk];
  const auto before =
      static_cast<std::size_t>(std::lower_bound(outer.begin(), outer.end(), first) - outer.begin());
  const std::size_t own = partition_.points_in(chunk);
  const Places places = places_of(std::move(outer));
  ChunkPoints points;
  points.origin = partition_.bounds.center();
  points.positions = places.positions;
  points.normals = places.normals;
  points.global = places.vertices;
  points.owned.assign(points.global.size(), 0);
  const auto make_room = [&](auto& list, auto value) {
    list.insert(list.begin() + static_cast<std::ptrdiff_t>(before), own, value);
  };
  make_room(points.positions, Vec3{});
  make_room(points.normals, Vec3{});
  make_room(points.global, std::uint64_t{0});
  make_room(points.owned, std::uint8_t{1});
  load_oriented_points(store_, chunk, partition_.schema,
                       std::span(points.positions).subspan(before, own),
                       std::span(points.normals).subspan(before, own));
  const auto begin = points.global.begin() + static_cast<std::ptrdiff_t>(before);
  std::iota(begin, begin + static_cast<std::ptrdiff_t>(own), first);
  points.owned_begin = static_cast<std::uint32_t>(before);
  points.owned_end = static_cast<std::uint32_t>(before + own);
  return points;
}

}  // namespace orbweave
