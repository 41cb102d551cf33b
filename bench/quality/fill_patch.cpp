#include "bench/quality/fill_patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "bench/peers/fill_cgal.h"
#include "engine/holes/fill_mesh.h"
#include "engine/holes/patch/patch_confidence.h"

namespace orbweave::bench {
namespace {

double angle_deg(Vec3 a, Vec3 b) {
  return std::atan2(norm(cross(a, b)), dot(a, b)) * 180.0 / std::numbers::pi;
}

Vec3 face_normal(Vec3 a, Vec3 b, Vec3 c) { return normalized(cross(b - a, c - a)); }

using DirectedEdge = std::array<std::uint32_t, 2>;

/// Face of a list by its directed edges; -1 where an edge is used twice.
struct EdgeHash {
  std::size_t operator()(DirectedEdge e) const {
    return (std::uint64_t{e[0]} << 32 | e[1]) * 0x9e3779b97f4a7c15u;
  }
};
using FaceOfEdge = std::unordered_map<DirectedEdge, std::int64_t, EdgeHash>;

FaceOfEdge faces_of_edges(std::span<const Triangle> triangles) {
  FaceOfEdge faces;
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const auto [at, is_new] = faces.try_emplace({triangles[f][k], triangles[f][(k + 1) % 3]}, f);
      if (!is_new) at->second = -1;
    }
  }
  return faces;
}

/// Triangles of the mesh that touch the rim and stay.
std::vector<Triangle> sheet_at_rim(const MeshIndex& index, const Disc& disc) {
  std::vector<std::uint32_t> faces;
  for (const std::uint32_t v : disc.rim) {
    for (const std::uint32_t f : index.triangles_at(v)) {
      if (!std::binary_search(disc.faces.begin(), disc.faces.end(), f)) faces.push_back(f);
    }
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  std::vector<Triangle> sheet;
  for (const std::uint32_t f : faces) sheet.push_back(index.mesh().triangles[f]);
  return sheet;
}

/// Whether each edge of the patch has exactly one face on either side, counting the sheet's.
bool closes_rim(const Disc& disc, const FaceOfEdge& patch, const FaceOfEdge& sheet) {
  for (const auto& [edge, face] : patch) {
    const DirectedEdge back{edge[1], edge[0]};
    const auto other = patch.find(back);
    const bool has_sheet = sheet.contains(back);
    if (face < 0 || sheet.contains(edge)) return false;
    if ((other != patch.end()) == has_sheet) return false;
  }
  for (std::size_t i = 0; i < disc.rim.size(); ++i) {
    if (!patch.contains({disc.rim[i], disc.rim[(i + 1) % disc.rim.size()]})) return false;
  }
  return true;
}

double largest_rim_dihedral_deg(const MeshIndex& index, const Disc& disc, const Patch& patch,
                                std::span<const Triangle> sheet, const FaceOfEdge& patch_faces,
                                const FaceOfEdge& sheet_faces) {
  const auto normal = [&](const Triangle& t) {
    return face_normal(position_of(index, patch, t[0]), position_of(index, patch, t[1]),
                       position_of(index, patch, t[2]));
  };
  double largest = 0.0;
  for (std::size_t i = 0; i < disc.rim.size(); ++i) {
    const DirectedEdge edge{disc.rim[i], disc.rim[(i + 1) % disc.rim.size()]};
    const auto inside = patch_faces.find(edge);
    const auto outside = sheet_faces.find({edge[1], edge[0]});
    if (inside == patch_faces.end() || inside->second < 0 || outside == sheet_faces.end()) continue;
    largest = std::max(largest, angle_deg(normal(patch.triangles[inside->second]),
                                          normal(sheet[outside->second])));
  }
  return largest;
}

void measure_removed_points(const MeshIndex& index, const Disc& disc, const TriangleMesh& patch,
                            PatchQuality& quality) {
  const NearestFace nearest(patch);
  const std::vector<std::uint32_t> points = measured_points(index, disc);
  double squares = 0.0, degrees = 0.0;
  for (const std::uint32_t v : points) {
    const NearestFace::Found found = nearest(index.mesh().vertices.positions[v]);
    const Triangle& t = patch.triangles[found.face];
    const std::vector<Vec3>& corners = patch.vertices.positions;
    const double degree =
        angle_deg(index.normals()[v], face_normal(corners[t[0]], corners[t[1]], corners[t[2]]));
    squares += found.squared_distance;
    degrees += degree;
    quality.max = std::max(quality.max, std::sqrt(found.squared_distance));
    quality.normal_max_deg = std::max(quality.normal_max_deg, degree);
  }
  if (points.empty()) return;
  quality.rms = std::sqrt(squares / static_cast<double>(points.size()));
  quality.normal_mean_deg = degrees / static_cast<double>(points.size());
}

void measure_new_points(const MeshIndex& index, const Disc& disc, const Patch& patch,
                        PatchQuality& quality) {
  if (patch.positions.empty()) return;
  TriangleMesh removed;
  removed.vertices.positions = index.mesh().vertices.positions;
  for (const std::uint32_t f : disc.faces) removed.triangles.push_back(index.mesh().triangles[f]);
  const NearestFace nearest(removed);
  double squares = 0.0;
  for (const Vec3 place : patch.positions) {
    const double squared = nearest(place).squared_distance;
    squares += squared;
    quality.back_max = std::max(quality.back_max, std::sqrt(squared));
  }
  quality.back_rms = std::sqrt(squares / static_cast<double>(patch.positions.size()));
}

/// Enough of the mesh to meet the patch wherever it goes astray.
double reach_of(const MeshIndex& index, const Disc& disc, const Patch& patch) {
  const Vec3 center = index.mesh().vertices.positions[disc.center];
  double squared = 0.0;
  for (const Vec3 place : patch.positions) {
    squared = std::max(squared, squared_norm(place - center));
  }
  for (const std::uint32_t v : disc.rim) {
    squared = std::max(squared, squared_norm(index.mesh().vertices.positions[v] - center));
  }
  return std::sqrt(squared) + 4.0 * index.spacing();
}

}  // namespace

Vec3 position_of(const MeshIndex& index, const Patch& patch, std::uint32_t vertex) {
  const std::vector<Vec3>& given = index.mesh().vertices.positions;
  return vertex < given.size() ? given[vertex] : patch.positions[vertex - given.size()];
}

TriangleMesh patch_mesh(const MeshIndex& index, const Patch& patch) {
  TriangleMesh mesh;
  std::vector<std::uint32_t> used;
  for (const Triangle& t : patch.triangles) used.insert(used.end(), t.begin(), t.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (const std::uint32_t v : used) {
    mesh.vertices.positions.push_back(position_of(index, patch, v));
  }
  for (Triangle t : patch.triangles) {
    for (std::uint32_t& v : t) {
      v = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
    }
    mesh.triangles.push_back(t);
  }
  return mesh;
}

std::vector<std::uint32_t> measured_points(const MeshIndex& index, const Disc& disc) {
  std::vector<std::uint32_t> points = disc.removed;
  std::erase_if(points, [&](std::uint32_t v) { return !index.is_scanned(v); });
  return points;
}

/// Of the patch of an object, as the models are. The part of a model that is filled here is an open
/// sheet, of which the roughness of a rim would count.
double confidence_of(const HoleFacts& facts) {
  const double spacing = facts.perimeter / static_cast<double>(facts.edges);
  return patch_confidence({.width = 4.0 * facts.area / (facts.perimeter * spacing),
                           .rim_angle = facts.rim_mean_deg * std::numbers::pi / 180.0,
                           .in_object = true});
}

Patch fill_by_engine(const MeshIndex& index, const Disc& disc, const Cut& around,
                     const FillOptions& options) {
  const FilledMesh filled = fill_mesh(around.mesh, options);
  std::uint32_t first = around.number_of(disc.rim[0]);
  for (const std::uint32_t v : disc.rim) first = std::min(first, around.number_of(v));
  const auto facts = std::find_if(filled.holes.begin(), filled.holes.end(), [&](const auto& hole) {
    return hole.first_vertex == first && hole.edges == disc.rim.size();
  });
  Patch patch;
  if (facts == filled.holes.end()) {
    patch.reason = "the loop was not found";
    return patch;
  }
  patch.filled = facts->filled;
  patch.seconds = facts->seconds;
  patch.method = facts->method;
  patch.reason = facts->reason;
  patch.sites = facts->sites;
  patch.rim_mean_deg = facts->rim_mean_deg;
  patch.confidence = confidence_of(*facts);
  const auto given = static_cast<std::uint32_t>(around.vertices.size());
  const auto whole = static_cast<std::uint32_t>(index.mesh().vertices.size());
  std::unordered_map<std::uint32_t, std::uint32_t> numbers;
  // Where a closed object was mended, triangles of the scan are gone: no number tells which is
  // first.
  for (std::size_t f = 0; f < filled.mesh.triangles.size(); ++f) {
    if (filled.mesh.hole[f] != facts->id) continue;
    Triangle t = filled.mesh.triangles[f];
    for (std::uint32_t& v : t) {
      if (v < given) {
        v = around.vertices[v];
        continue;
      }
      const auto [at, is_new] = numbers.try_emplace(v, whole + patch.positions.size());
      if (is_new) patch.positions.push_back(filled.mesh.vertices.positions[v]);
      v = at->second;
    }
    patch.triangles.push_back(t);
  }
  return patch;
}

PatchQuality quality_of(const MeshIndex& index, const Disc& disc, const Patch& patch) {
  PatchQuality quality;
  if (patch.triangles.empty()) return quality;
  const std::vector<Triangle> sheet = sheet_at_rim(index, disc);
  const FaceOfEdge patch_faces = faces_of_edges(patch.triangles);
  const FaceOfEdge sheet_faces = faces_of_edges(sheet);
  quality.closed = closes_rim(disc, patch_faces, sheet_faces);
  quality.rim_dihedral_deg =
      largest_rim_dihedral_deg(index, disc, patch, sheet, patch_faces, sheet_faces);
  measure_removed_points(index, disc, patch_mesh(index, patch), quality);
  measure_new_points(index, disc, patch, quality);
  const Cut around = cut_ball(index, index.mesh().vertices.positions[disc.center],
                              reach_of(index, disc, patch), disc.faces);
  quality.self_intersections = count_self_intersections(index, around, patch);
  return quality;
}

}  // namespace orbweave::bench
