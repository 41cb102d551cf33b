#include "bench/quality/fill_discs.h"

#include <algorithm>
#include <numeric>
#include <unordered_set>

#include "engine/geometry/disjoint_sets.h"
#include "engine/normals/normals_from_faces.h"

namespace orbweave::bench {
namespace {

double mean_edge_length(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      sum += norm(mesh.vertices.positions[t[(k + 1) % 3]] - mesh.vertices.positions[t[k]]);
    }
  }
  return sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

/// The corners of a triangle after a vertex.
std::array<std::uint32_t, 2> others(const Triangle& t, std::uint32_t vertex) {
  if (t[0] == vertex) return {t[1], t[2]};
  if (t[1] == vertex) return {t[2], t[0]};
  return {t[0], t[1]};
}

using DirectedEdge = std::array<std::uint32_t, 2>;

std::vector<DirectedEdge> directed_edges(const TriangleMesh& mesh,
                                         std::span<const std::uint32_t> faces) {
  std::vector<DirectedEdge> edges;
  for (const std::uint32_t f : faces) {
    const Triangle& t = mesh.triangles[f];
    for (int k = 0; k < 3; ++k) edges.push_back({t[k], t[(k + 1) % 3]});
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// The border of faces as one simple loop; empty when it is not one.
std::vector<std::uint32_t> simple_border(const std::vector<DirectedEdge>& edges) {
  std::vector<DirectedEdge> border;
  for (const auto& [a, b] : edges) {
    if (!std::binary_search(edges.begin(), edges.end(), DirectedEdge{b, a}))
      border.push_back({a, b});
  }
  std::vector<std::uint32_t> loop;
  if (border.empty()) return loop;
  std::uint32_t at = border[0][0];
  for (std::size_t step = 0; step < border.size(); ++step) {
    loop.push_back(at);
    const auto next = std::lower_bound(border.begin(), border.end(), DirectedEdge{at, 0});
    if (next == border.end() || (*next)[0] != at) return {};
    if (next + 1 != border.end() && (*(next + 1))[0] == at) return {};
    at = (*next)[1];
    if (at == loop[0] && step + 1 < border.size()) return {};
  }
  return at == loop[0] ? loop : std::vector<std::uint32_t>{};
}

std::vector<std::uint32_t> faces_at(const MeshIndex& index,
                                    std::span<const std::uint32_t> vertices) {
  std::vector<std::uint32_t> faces;
  for (const std::uint32_t v : vertices) {
    const auto at = index.triangles_at(v);
    faces.insert(faces.end(), at.begin(), at.end());
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

Cut cut_faces(const MeshIndex& index, std::span<const std::uint32_t> faces) {
  Cut cut;
  for (const std::uint32_t f : faces) {
    const Triangle& t = index.mesh().triangles[f];
    cut.vertices.insert(cut.vertices.end(), t.begin(), t.end());
  }
  std::sort(cut.vertices.begin(), cut.vertices.end());
  cut.vertices.erase(std::unique(cut.vertices.begin(), cut.vertices.end()), cut.vertices.end());
  for (const std::uint32_t v : cut.vertices) {
    cut.mesh.vertices.positions.push_back(index.mesh().vertices.positions[v]);
  }
  for (const std::uint32_t f : faces) {
    const Triangle& t = index.mesh().triangles[f];
    cut.mesh.triangles.push_back({cut.number_of(t[0]), cut.number_of(t[1]), cut.number_of(t[2])});
  }
  return cut;
}

}  // namespace

MeshIndex::MeshIndex(const TriangleMesh& mesh)
    : mesh_(mesh),
      first_(mesh.vertices.size() + 1, 0),
      inner_(mesh.vertices.size(), false),
      main_(mesh.vertices.size(), false),
      scanned_(mesh.vertices.size(), false),
      normals_(normals_from_faces(mesh)),
      spacing_(mean_edge_length(mesh)) {
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) ++first_[v + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  items_.resize(3 * mesh.triangles.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    for (const std::uint32_t v : mesh.triangles[f]) {
      items_[next[v]++] = f;
      if (mesh.hole.empty() || mesh.hole[f] == 0) scanned_[v] = true;
    }
  }
  for (std::uint32_t v = 0; v < inner_.size(); ++v) inner_[v] = has_closed_fan(v);
  find_main_component();
}

std::span<const std::uint32_t> MeshIndex::triangles_at(std::uint32_t vertex) const {
  return std::span(items_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
}

bool MeshIndex::has_closed_fan(std::uint32_t vertex) const {
  std::vector<DirectedEdge> spokes;
  for (const std::uint32_t f : triangles_at(vertex)) {
    spokes.push_back(others(mesh_.triangles[f], vertex));
  }
  if (spokes.empty()) return false;
  std::sort(spokes.begin(), spokes.end());
  std::uint32_t at = spokes[0][0];
  for (std::size_t step = 0; step < spokes.size(); ++step) {
    const auto next = std::lower_bound(spokes.begin(), spokes.end(), DirectedEdge{at, 0});
    if (next == spokes.end() || (*next)[0] != at) return false;
    if (next + 1 != spokes.end() && (*(next + 1))[0] == at) return false;
    at = (*next)[1];
    if (at == spokes[0][0]) return step + 1 == spokes.size();
  }
  return false;
}

void MeshIndex::find_main_component() {
  DisjointSets sets(mesh_.vertices.size());
  for (const Triangle& t : mesh_.triangles) {
    sets.unite(t[0], t[1]);
    sets.unite(t[0], t[2]);
  }
  std::vector<std::uint32_t> triangles(mesh_.vertices.size(), 0);
  for (const Triangle& t : mesh_.triangles) ++triangles[sets.find(t[0])];
  const auto largest = static_cast<std::uint32_t>(
      std::max_element(triangles.begin(), triangles.end()) - triangles.begin());
  for (std::uint32_t v = 0; v < main_.size(); ++v) main_[v] = sets.find(v) == largest;
}

std::vector<std::uint32_t> connected_within(const MeshIndex& index, std::uint32_t center,
                                            double reach) {
  const std::vector<Vec3>& positions = index.mesh().vertices.positions;
  std::unordered_set<std::uint32_t> seen{center};
  std::vector<std::uint32_t> found{center};
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (const std::uint32_t f : index.triangles_at(found[i])) {
      for (const std::uint32_t v : index.mesh().triangles[f]) {
        if (squared_norm(positions[v] - positions[center]) > reach * reach) continue;
        if (seen.insert(v).second) found.push_back(v);
      }
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::optional<Disc> clean_disc(const MeshIndex& index, std::uint32_t center, double radius) {
  if (!index.is_inner(center)) return std::nullopt;
  Disc disc{center, connected_within(index, center, radius), {}, {}};
  disc.faces = faces_at(index, disc.removed);
  const std::vector<DirectedEdge> edges = directed_edges(index.mesh(), disc.faces);
  if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return std::nullopt;
  disc.rim = simple_border(edges);
  std::vector<std::uint32_t> vertices = disc.removed;
  vertices.insert(vertices.end(), disc.rim.begin(), disc.rim.end());
  for (const std::uint32_t v : vertices) {
    if (!index.is_inner(v)) return std::nullopt;
  }
  const auto inside_edges = (edges.size() + disc.rim.size()) / 2;
  const bool is_disc = vertices.size() + disc.faces.size() == inside_edges + 1;
  if (disc.rim.empty() || !is_disc) return std::nullopt;
  return disc;
}

std::uint32_t Cut::number_of(std::uint32_t vertex) const {
  const auto at = std::lower_bound(vertices.begin(), vertices.end(), vertex);
  return static_cast<std::uint32_t>(at - vertices.begin());
}

Cut cut_part(const MeshIndex& index, std::span<const std::uint32_t> vertices,
             std::span<const std::uint32_t> without) {
  std::vector<std::uint32_t> faces = faces_at(index, vertices);
  std::erase_if(faces, [&](std::uint32_t f) {
    if (std::binary_search(without.begin(), without.end(), f)) return true;
    const Triangle& t = index.mesh().triangles[f];
    return !std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
      return std::binary_search(vertices.begin(), vertices.end(), v);
    });
  });
  return cut_faces(index, faces);
}

Cut cut_ball(const MeshIndex& index, Vec3 place, double reach,
             std::span<const std::uint32_t> without) {
  const std::vector<Vec3>& positions = index.mesh().vertices.positions;
  std::vector<std::uint32_t> near;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (squared_norm(positions[v] - place) <= reach * reach) near.push_back(v);
  }
  std::vector<std::uint32_t> faces = faces_at(index, near);
  std::erase_if(faces, [&](std::uint32_t f) {
    return std::binary_search(without.begin(), without.end(), f);
  });
  return cut_faces(index, faces);
}

}  // namespace orbweave::bench
