#include "engine/levels/node_mesh.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "engine/levels/corner_groups.h"

namespace orbweave {
namespace {

void sort_and_keep_each_once(std::vector<std::uint64_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

std::uint32_t place_of(const std::vector<std::uint64_t>& numbers, std::uint64_t number) {
  const auto at = std::lower_bound(numbers.begin(), numbers.end(), number);
  return static_cast<std::uint32_t>(at - numbers.begin());
}

template <class T>
std::size_t put_values(std::span<const T> values, std::vector<std::byte>& bytes, std::size_t at) {
  const auto from = std::as_bytes(values);
  std::copy(from.begin(), from.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  return at + from.size();
}

}  // namespace

NodeMesh bare_leaf(std::span<const CodedTriangle> triangles) {
  NodeMesh mesh;
  mesh.vertices.reserve(3 * triangles.size());
  for (const CodedTriangle& t : triangles)
    mesh.vertices.insert(mesh.vertices.end(), t.corners.begin(), t.corners.end());
  sort_and_keep_each_once(mesh.vertices);
  mesh.triangles.reserve(triangles.size());
  mesh.tags.reserve(triangles.size());
  for (const CodedTriangle& t : triangles) {
    mesh.tags.push_back({t.patch.hole, t.patch.confidence, 0});
    mesh.triangles.push_back({place_of(mesh.vertices, t.corners[0]),
                              place_of(mesh.vertices, t.corners[1]),
                              place_of(mesh.vertices, t.corners[2])});
  }
  return mesh;
}

NodeMesh leaf_mesh(const VertexTable& table, std::span<const CodedTriangle> triangles) {
  NodeMesh mesh = bare_leaf(triangles);
  mesh.rows = table.rows(mesh.vertices);
  return mesh;
}

NodeMesh merged_mesh(std::span<const NodeMesh> parts, std::size_t row_bytes) {
  NodeMesh mesh;
  std::size_t triangles = 0;
  for (const NodeMesh& part : parts) {
    mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
    triangles += part.triangles.size();
  }
  sort_and_keep_each_once(mesh.vertices);
  mesh.rows.resize(mesh.vertices.size() * row_bytes);
  mesh.triangles.reserve(triangles);
  for (const NodeMesh& part : parts) {
    std::vector<std::uint32_t> places(part.vertices.size());
    std::uint32_t place = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      while (mesh.vertices[place] != part.vertices[i]) ++place;
      places[i] = place;
      std::memcpy(mesh.rows.data() + place * row_bytes, part.rows.data() + i * row_bytes,
                  row_bytes);
    }
    for (const Triangle& t : part.triangles)
      mesh.triangles.push_back({places[t[0]], places[t[1]], places[t[2]]});
    mesh.tags.insert(mesh.tags.end(), part.tags.begin(), part.tags.end());
  }
  return mesh;
}

NodeMesh used_part(const NodeMesh& mesh, std::vector<Triangle> triangles, std::size_t row_bytes) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> places(mesh.vertices.size(), kUnused);
  for (const Triangle& t : triangles)
    for (const std::uint32_t corner : t) places[corner] = 0;
  NodeMesh part;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] == kUnused) continue;
    places[i] = static_cast<std::uint32_t>(part.vertices.size());
    part.vertices.push_back(mesh.vertices[i]);
    const auto row = mesh.rows.begin() + static_cast<std::ptrdiff_t>(i * row_bytes);
    part.rows.insert(part.rows.end(), row, row + static_cast<std::ptrdiff_t>(row_bytes));
  }
  part.triangles = std::move(triangles);
  for (Triangle& t : part.triangles)
    for (std::uint32_t& corner : t) corner = places[corner];
  return part;
}

std::vector<Vec3> positions_of(const NodeMesh& mesh, std::size_t row_bytes) {
  std::vector<Vec3> positions;
  positions.reserve(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    positions.push_back(position_of_row(mesh.rows.data() + i * row_bytes));
  return positions;
}

std::vector<std::byte> packed(const NodeMesh& mesh) {
  const std::array<std::uint64_t, 3> counts = {mesh.vertices.size(), mesh.triangles.size(),
                                               mesh.tags.size()};
  std::vector<std::byte> bytes(sizeof counts + mesh.vertices.size() * sizeof(std::uint64_t) +
                               mesh.rows.size() + mesh.triangles.size() * sizeof(Triangle) +
                               mesh.tags.size() * sizeof(FaceTag));
  std::size_t at = put_values(std::span<const std::uint64_t>(counts), bytes, 0);
  at = put_values(std::span<const std::uint64_t>(mesh.vertices), bytes, at);
  at = put_values(std::span<const Triangle>(mesh.triangles), bytes, at);
  at = put_values(std::span<const FaceTag>(mesh.tags), bytes, at);
  put_values(std::span<const std::byte>(mesh.rows), bytes, at);
  return bytes;
}

NodeMesh unpacked(std::span<const std::byte> bytes, std::size_t row_bytes) {
  const auto take = [&](auto& values, std::size_t count) {
    const std::size_t size = count * sizeof values[0];
    if (size > bytes.size()) throw std::logic_error("a stored node is too short");
    values.resize(count);
    if (size > 0) std::memcpy(values.data(), bytes.data(), size);
    bytes = bytes.subspan(size);
  };
  std::vector<std::uint64_t> counts;
  take(counts, 3);
  NodeMesh mesh;
  take(mesh.vertices, counts[0]);
  take(mesh.triangles, counts[1]);
  take(mesh.tags, counts[2]);
  take(mesh.rows, counts[0] * row_bytes);
  return mesh;
}

std::vector<OpenEdge> open_edges(const NodeMesh& mesh) {
  /// An edge but for its lower vertex.
  struct Edge {
    std::uint32_t high = 0;
    std::uint32_t triangle = 0;
    auto operator<=>(const Edge&) const = default;
  };
  const auto ends = [&](std::uint32_t t, std::size_t c) {
    return std::minmax(mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3]);
  };
  const CornerGroups<Edge> edges_of(
      mesh.triangles, [&](std::uint32_t t, std::size_t c) { return ends(t, c).first; },
      [&](std::uint32_t t, std::size_t c) {
        return Edge{ends(t, c).second, t};
      });
  std::vector<OpenEdge> open;
  for (std::uint32_t low = 0; low < edges_of.size(); ++low) {
    const std::span<const Edge> edges = edges_of[low];
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const bool is_shared = (i > 0 && edges[i].high == edges[i - 1].high) ||
                             (i + 1 < edges.size() && edges[i].high == edges[i + 1].high);
      if (!is_shared) open.push_back({low, edges[i].high, edges[i].triangle});
    }
  }
  return open;
}

std::uint64_t triangles_at(std::span<const OpenEdge> edges) {
  std::vector<std::uint64_t> triangles;
  triangles.reserve(edges.size());
  for (const OpenEdge& edge : edges) triangles.push_back(edge.triangle);
  sort_and_keep_each_once(triangles);
  return triangles.size();
}

MeshEdge mesh_edge(const NodeMesh& mesh, const OpenEdge& edge) {
  return {mesh.vertices[edge.low], mesh.vertices[edge.high]};
}

}  // namespace orbweave
