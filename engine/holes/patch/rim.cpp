#include "engine/holes/patch/rim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engine/holes/rbf/bending_energy.h"

namespace orbweave {
namespace {

using Edge = std::array<std::uint32_t, 2>;

/// The loop's edges as the sheet's triangles run along them, and where they are in the loop.
struct RimEdge {
  Edge in_sheet{};
  std::uint32_t corner = 0;
  friend auto operator<=>(const RimEdge&, const RimEdge&) = default;
};

std::vector<RimEdge> sorted_rim_edges(const HoleProblem& problem) {
  const auto n = static_cast<std::uint32_t>(problem.loop.size());
  std::vector<RimEdge> edges(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    edges[i] = {{problem.loop[(i + 1) % n], problem.loop[i]}, i};
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// Calls visit(corner, triangle) where an edge of the triangle is the rim's edge after `corner`.
template <class Visit>
void for_each_rim_face(const HoleProblem& problem, std::span<const Triangle> triangles,
                       bool of_patch, const Visit& visit) {
  const std::vector<RimEdge> edges = sorted_rim_edges(problem);
  std::vector<std::uint8_t> on_rim(problem.positions.size(), 0);
  for (const std::uint32_t v : problem.loop) on_rim[v] = 1;
  const auto is_on_rim = [&](std::uint32_t v) { return v < on_rim.size() && on_rim[v] != 0; };
  for (const Triangle& t : triangles) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      Edge edge = {t[k], t[(k + 1) % 3]};
      if (!is_on_rim(edge[0]) || !is_on_rim(edge[1])) continue;
      if (of_patch) std::swap(edge[0], edge[1]);
      const auto at = std::lower_bound(edges.begin(), edges.end(), RimEdge{edge, 0});
      if (at != edges.end() && at->in_sheet == edge) visit(at->corner, t);
    }
  }
}

void find_faces(const HoleProblem& problem, Rim& rim) {
  for_each_rim_face(problem, rim.faces, false, [&](std::uint32_t i, const Triangle& t) {
    const Vec3 a = problem.positions[t[0]];
    rim.face_normals[i] =
        normalized(cross(problem.positions[t[1]] - a, problem.positions[t[2]] - a));
  });
}

}  // namespace

Vec3 center_of_loop(const HoleProblem& problem) {
  const Vec3 first = problem.positions[problem.loop[0]];
  Vec3 sum;
  for (const std::uint32_t v : problem.loop) sum = sum + (problem.positions[v] - first);
  return first + sum / static_cast<double>(problem.loop.size());
}

Rim find_rim(const HoleProblem& problem) {
  Rim rim;
  const std::size_t n = problem.loop.size();
  rim.spacing = rim_spacing(problem);
  rim.center = center_of_loop(problem);
  rim.corners.reserve(n);
  for (const std::uint32_t v : problem.loop) {
    rim.corners.push_back(problem.positions[v] - rim.center);
    rim.radius = std::max(rim.radius, norm(rim.corners.back()));
  }
  rim.face_normals.resize(n);
  rim.faces = faces_at_rim(problem);
  find_faces(problem, rim);
  return rim;
}

RimSheet sheet_at_rim(const HoleProblem& problem, const Rim& rim) {
  constexpr std::uint32_t kNone = UINT32_MAX;
  const auto corners = static_cast<std::uint32_t>(problem.loop.size());
  RimSheet sheet{{}, {}, std::vector<char>(corners, 1)};
  std::vector<std::uint32_t> number(problem.positions.size(), kNone);
  for (std::uint32_t i = 0; i < corners; ++i) {
    const std::uint32_t v = problem.loop[i];
    if (number[v] != kNone) sheet.is_whole[i] = sheet.is_whole[number[v]] = 0;
    number[v] = i;
  }
  const std::vector<std::uint32_t> corner = number;
  for (const Triangle& t : problem.sheet) {
    if (corner[t[0]] == kNone && corner[t[1]] == kNone && corner[t[2]] == kNone) continue;
    CornerTriangle moved{};
    for (int k = 0; k < 3; ++k) {
      std::uint32_t& v = number[t[k]];
      if (v == kNone) {
        v = corners + static_cast<std::uint32_t>(sheet.positions.size());
        sheet.positions.push_back(problem.positions[t[k]] - rim.center);
      }
      moved[k] = v;
    }
    sheet.triangles.push_back(moved);
  }
  return sheet;
}

namespace {

/// A patch without normals.
HolePatch shape_of(const HoleProblem& problem, const Rim& rim, std::span<const Vec3> positions,
                   std::span<const CornerTriangle> triangles) {
  constexpr std::uint32_t kUnused = UINT32_MAX;
  const auto corners = static_cast<std::uint32_t>(problem.loop.size());
  const auto given = static_cast<std::uint32_t>(problem.positions.size());
  std::vector<std::uint32_t> number(positions.size(), kUnused);
  std::copy(problem.loop.begin(), problem.loop.end(), number.begin());
  for (const CornerTriangle& t : triangles) {
    for (const std::uint32_t v : t) {
      if (number[v] == kUnused) number[v] = 0;
    }
  }
  HolePatch patch;
  for (std::uint32_t v = corners; v < positions.size(); ++v) {
    if (number[v] == kUnused) continue;
    number[v] = given + static_cast<std::uint32_t>(patch.positions.size());
    patch.positions.push_back(rim.center + positions[v]);
  }
  patch.triangles.reserve(triangles.size());
  for (const CornerTriangle& t : triangles) {
    patch.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  }
  return patch;
}

}  // namespace

HolePatch patch_of_disc(const HoleProblem& problem, const Rim& rim, std::span<const Vec3> positions,
                        std::span<const CornerTriangle> triangles) {
  HolePatch patch = shape_of(problem, rim, positions, triangles);
  patch.normals = normals_of_patch(problem, patch);
  return patch;
}

HolePatch patch_of_disc(const HoleProblem& problem, const Rim& rim, const PatchMesh& disc) {
  return patch_of_disc(problem, rim, disc.positions(), disc.triangles());
}

HolePatch shape_of_disc(const HoleProblem& problem, const Rim& rim, const PatchMesh& disc) {
  return shape_of(problem, rim, disc.positions(), disc.triangles());
}

std::vector<Vec3> normals_of_patch(const HoleProblem& problem, const HolePatch& patch) {
  const std::size_t given = problem.positions.size();
  std::vector<Vec3> normals(patch.positions.size());
  for (const Triangle& t : patch.triangles) {
    const Vec3 area = doubled_area(problem, patch, t);
    for (const std::uint32_t v : t) {
      if (v >= given) normals[v - given] = normals[v - given] + area;
    }
  }
  for (Vec3& normal : normals) normal = normalized(normal);
  return normals;
}

RimAngles rim_angles(const HoleProblem& problem, const HolePatch& patch) {
  return rim_angles(problem, problem.sheet, patch);
}

RimAngles rim_angles(const HoleProblem& problem, std::span<const Triangle> rim_faces,
                     const HolePatch& patch) {
  if (patch.triangles.empty()) return {};
  const auto area_of = [&](const Triangle& t) { return doubled_area(problem, patch, t); };
  std::vector<Vec3> behind(problem.loop.size());
  for_each_rim_face(problem, rim_faces, false,
                    [&](std::uint32_t i, const Triangle& t) { behind[i] = area_of(t); });
  RimAngles angles;
  double sum = 0.0;
  std::size_t count = 0;
  for_each_rim_face(problem, patch.triangles, true, [&](std::uint32_t i, const Triangle& t) {
    const Vec3 area = area_of(t);
    const double angle = std::atan2(norm(cross(area, behind[i])), dot(area, behind[i]));
    angles.largest = std::max(angles.largest, angle);
    sum += angle;
    ++count;
  });
  if (count > 0) angles.mean = sum / static_cast<double>(count);
  return angles;
}

}  // namespace orbweave
