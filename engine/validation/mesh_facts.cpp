#include "engine/validation/mesh_facts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/geometry/disjoint_sets.h"
#include "engine/validation/boundary_loops.h"
#include "engine/validation/edge_table.h"
#include "io/error.h"
#include "io/mesh_size.h"
#include "io/meshes/mesh_checksum.h"

namespace orbweave {
namespace {

/// Position of a vertex in a triangle that has it.
std::uint32_t corner_of(const Triangle& t, std::uint32_t vertex) {
  return t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
}

std::uint32_t third_vertex(const Triangle& t, std::uint32_t a, std::uint32_t b) {
  for (const std::uint32_t v : t)
    if (v != a && v != b) return v;
  return a;
}

/// Where the triangles at an edge repeat each other or run the same way.
struct EdgeConflicts {
  std::uint64_t forward = 0;   ///< uses from lower to upper
  std::uint64_t backward = 0;  ///< uses from upper to lower
  std::uint64_t repeats = 0;   ///< triangles whose smallest edge this is and that came before
};

EdgeConflicts edge_conflicts(std::span<const Triangle> triangles, std::uint32_t lower,
                             std::uint32_t upper, std::span<const EdgeTable::Use> uses) {
  EdgeConflicts conflicts;
  for (const EdgeTable::Use& use : uses)
    ++(runs_along(triangles[use.triangle], lower, upper) ? conflicts.forward : conflicts.backward);
  if (uses.size() < 2) return conflicts;
  std::vector<std::uint32_t> thirds;
  for (const EdgeTable::Use& use : uses) {
    const std::uint32_t third = third_vertex(triangles[use.triangle], lower, upper);
    if (third > upper) thirds.push_back(third);
  }
  std::sort(thirds.begin(), thirds.end());
  for (std::size_t i = 1; i < thirds.size(); ++i) conflicts.repeats += thirds[i] == thirds[i - 1];
  return conflicts;
}

void check_indices(const TriangleMesh& mesh) {
  require_mesh_in_core({}, mesh.vertices.size(), mesh.triangles.size());
  const std::size_t vertices = mesh.vertices.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const std::uint32_t index : mesh.triangles[i])
      if (index >= vertices)
        throw_bad_input("triangle " + std::to_string(i) + " has a vertex that does not exist",
                        {.file = {},
                         .place = {},
                         .found = "index " + std::to_string(index),
                         .expected = "less than " + std::to_string(vertices),
                         .advice = {}});
}

double triangle_area(std::span<const Vec3> positions, const Triangle& t) {
  const Vec3 a = positions[t[0]];
  return 0.5 * norm(cross(positions[t[1]] - a, positions[t[2]] - a));
}

/// 0 where a corner is not finite.
double finite_area(std::span<const Vec3> positions, const Triangle& t) {
  const double area = triangle_area(positions, t);
  return std::isfinite(area) ? area : 0.0;
}

/// Summed in blocks: the error does not grow with the number of triangles.
double total_area(const TriangleMesh& mesh, const StopToken* stop) {
  constexpr std::size_t kBlock = 4096;
  double total = 0.0;
  for (std::size_t first = 0; first < mesh.triangles.size(); first += kBlock) {
    check_stop(stop);
    double sum = 0.0;
    const std::size_t last = std::min(first + kBlock, mesh.triangles.size());
    for (std::size_t i = first; i < last; ++i)
      sum += finite_area(mesh.vertices.positions, mesh.triangles[i]);
    total += sum;
  }
  return total;
}

/// Of triangles that fill holes, as far as the mesh says which do.
double area_of_patches(const TriangleMesh& mesh) {
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.hole.size(); ++t)
    if (mesh.hole[t] > 0) area += finite_area(mesh.vertices.positions, mesh.triangles[t]);
  return area;
}

/// Whether all vertices that triangles use are finite.
bool has_finite_surface(const TriangleMesh& mesh, std::span<const std::uint8_t> used) {
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0 && !is_finite(mesh.vertices.positions[v])) return false;
  return true;
}

/// Fans as sets of corners (3 * triangle + position), and what hangs on them.
class Fans {
 public:
  Fans(std::span<const Triangle> triangles)
      : triangles_(triangles), corners_(static_cast<std::uint32_t>(3 * triangles.size())) {}

  /// Links the fans at both ends of an edge of exactly two triangles.
  void link(std::uint32_t lower, std::uint32_t upper, std::uint32_t t, std::uint32_t u) {
    corners_.unite(corner(t, lower), corner(u, lower));
    corners_.unite(corner(t, upper), corner(u, upper));
  }
  std::uint64_t vertices_of_several_fans(std::size_t vertices) {
    std::vector<std::uint8_t> fans(vertices, 0);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (is_degenerate(triangles_[t])) continue;
      for (std::uint32_t k = 0; k < 3; ++k) {
        std::uint8_t& count = fans[triangles_[t][k]];
        if (corners_.find(3 * t + k) == 3 * t + k && count < 2) ++count;
      }
    }
    return static_cast<std::uint64_t>(std::count(fans.begin(), fans.end(), 2));
  }
  /// The edge's fans, known once all edges are linked.
  void label(BoundaryEdge& edge, std::uint32_t t) {
    for (int end = 0; end < 2; ++end) edge.fans[end] = corners_.find(corner(t, edge.vertices[end]));
  }

 private:
  std::uint32_t corner(std::uint32_t t, std::uint32_t vertex) const {
    return 3 * t + corner_of(triangles_[t], vertex);
  }
  std::span<const Triangle> triangles_;
  DisjointSets corners_;
};

/// Everything that follows from which triangles meet at which edges.
void add_topology(const TriangleMesh& mesh, MeshFacts& facts, const StopToken* stop) {
  const std::span<const Triangle> triangles = mesh.triangles;
  const EdgeTable table(triangles, mesh.vertices.size(), stop);
  DisjointSets components(static_cast<std::uint32_t>(triangles.size()));
  Fans fans(triangles);
  std::vector<BoundaryEdge> boundary;
  std::vector<std::uint32_t> boundary_triangles;
  std::uint64_t edges = 0;
  StopLooks looks(stop, kStopBlock);
  table.for_each_edge(
      [&](std::uint32_t lower, std::uint32_t upper, std::span<const EdgeTable::Use> uses) {
        looks.after(1);
        ++edges;
        for (std::size_t i = 1; i < uses.size(); ++i)
          components.unite(uses[0].triangle, uses[i].triangle);
        if (uses.size() == 1) {
          boundary.push_back({{lower, upper}, {}});
          boundary_triangles.push_back(uses[0].triangle);
        }
        if (uses.size() == 2) fans.link(lower, upper, uses[0].triangle, uses[1].triangle);
        facts.nonmanifold_edges += uses.size() > 2;
        const EdgeConflicts conflicts = edge_conflicts(triangles, lower, upper, uses);
        facts.inconsistent_edges += (conflicts.forward > 1) + (conflicts.backward > 1);
        facts.duplicate_triangles += conflicts.repeats;
      });
  facts.boundary_edges = boundary.size();
  for (std::size_t e = 0; e < boundary.size(); ++e) fans.label(boundary[e], boundary_triangles[e]);
  check_stop(stop);
  facts.boundary_loops = count_boundary_loops(boundary);
  check_stop(stop);
  facts.nonmanifold_vertices = fans.vertices_of_several_fans(mesh.vertices.size());

  std::vector<std::uint8_t> in_surface(mesh.vertices.size(), 0);
  std::int64_t faces = 0;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (is_degenerate(triangles[t])) continue;
    ++faces;
    facts.components += components.find(t) == t;
    for (const std::uint32_t index : triangles[t]) in_surface[index] = 1;
  }
  facts.degenerate_triangles = triangles.size() - static_cast<std::uint64_t>(faces);
  facts.euler_characteristic = std::count(in_surface.begin(), in_surface.end(), 1) -
                               static_cast<std::int64_t>(edges) + faces;
}

}  // namespace

std::vector<std::uint8_t> used_vertices(std::size_t vertices, std::span<const Triangle> triangles) {
  std::vector<std::uint8_t> used(vertices, 0);
  for (const Triangle& t : triangles)
    for (const std::uint32_t index : t) used[index] = 1;
  return used;
}

double vertex_spacing(const TriangleMesh& mesh) {
  constexpr std::size_t kSample = std::size_t{1} << 16;
  const std::vector<Vec3>& at = mesh.vertices.positions;
  const std::size_t step = std::max<std::size_t>(1, mesh.triangles.size() / kSample);
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += step) {
    const Triangle& t = mesh.triangles[i];
    area += 0.5 * norm(cross(at[t[1]] - at[t[0]], at[t[2]] - at[t[0]]));
  }
  area *= static_cast<double>(step);
  const bool is_surface = std::isfinite(area) && area > 0.0;
  return is_surface ? std::sqrt(area / static_cast<double>(at.size())) : 0.0;
}

std::string mesh_checksum(std::span<const Vec3> positions, std::span<const Triangle> triangles,
                          const StopToken* stop) {
  StopLooks looks(stop, kStopBlock);
  const std::vector<std::uint8_t> used = used_vertices(positions.size(), triangles);
  MeshChecksum checksum;
  std::vector<std::uint32_t> rank(positions.size());
  std::uint32_t next = 0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    looks.after(1);
    if (used[v] == 0) continue;
    checksum.add_vertices(positions.subspan(v, 1), next);
    rank[v] = next++;
  }
  std::uint64_t number = 0;
  for (const Triangle& t : triangles) {
    looks.after(1);
    const Triangle64 ranked{rank[t[0]], rank[t[1]], rank[t[2]]};
    checksum.add_triangles(std::span(&ranked, 1), number++);
  }
  return checksum.hex();
}

MeshFacts mesh_facts(const TriangleMesh& mesh, const StopToken* stop) {
  check_indices(mesh);
  MeshFacts facts;
  facts.vertices = mesh.vertices.size();
  facts.triangles = mesh.triangles.size();
  add_topology(mesh, facts, stop);
  const auto used = used_vertices(mesh.vertices.size(), mesh.triangles);
  facts.unreferenced_vertices = static_cast<std::uint64_t>(std::count(used.begin(), used.end(), 0));
  facts.area = total_area(mesh, stop);
  facts.patch_area = area_of_patches(mesh);
  facts.bounds = mesh.vertices.bounds();
  facts.checksum = mesh_checksum(mesh.vertices.positions, mesh.triangles, stop);
  facts.watertight = facts.triangles > 0 && facts.boundary_edges == 0 &&
                     facts.nonmanifold_edges == 0 && facts.nonmanifold_vertices == 0 &&
                     facts.inconsistent_edges == 0 && facts.degenerate_triangles == 0 &&
                     facts.duplicate_triangles == 0 && has_finite_surface(mesh, used);
  return facts;
}

namespace {

std::string edge_text(std::uint32_t a, std::uint32_t b) {
  return "edge " + std::to_string(a) + "-" + std::to_string(b);
}

/// A violated guarantee: how often, and where first.
struct Violation {
  std::uint64_t count = 0;
  std::string example;

  void add(bool violated, auto&& describe) {
    if (violated && count++ == 0) example = describe();
  }
  void append_to(std::vector<std::string>& lines, const std::string& what) const {
    if (count > 0)
      lines.push_back(what + " (" + std::to_string(count) + " in all, the first: " + example + ")");
  }
};

void validate_arrays(const TriangleMesh& mesh, std::vector<std::string>& lines) {
  const PointCloud& vertices = mesh.vertices;
  if (vertices.schema.has_normals && vertices.normals.size() != vertices.size())
    lines.emplace_back("number of normals differs from number of vertices");
  if (vertices.attributes.size() != vertices.size() * vertices.schema.attribute_bytes())
    lines.emplace_back("attribute rows differ from number of vertices");
  if (!mesh.hole.empty() && mesh.hole.size() != mesh.triangles.size())
    lines.emplace_back("number of hole ids differs from number of triangles");
  Violation infinite, outside;
  for (std::size_t v = 0; v < vertices.size(); ++v)
    infinite.add(!is_finite(vertices.positions[v]), [&] { return "vertex " + std::to_string(v); });
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const std::uint32_t index : mesh.triangles[i])
      outside.add(index >= vertices.size(), [&] {
        return "triangle " + std::to_string(i) + " has index " + std::to_string(index);
      });
  infinite.append_to(lines, "vertex that is not finite");
  outside.append_to(lines, "index outside the vertices");
}

void validate_edges(const TriangleMesh& mesh, std::vector<std::string>& lines) {
  Violation degenerate, crowded, repeated_direction, duplicate;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    degenerate.add(is_degenerate(mesh.triangles[i]),
                   [&] { return "triangle " + std::to_string(i); });
  const EdgeTable table(mesh.triangles, mesh.vertices.size());
  table.for_each_edge(
      [&](std::uint32_t lower, std::uint32_t upper, std::span<const EdgeTable::Use> uses) {
        const EdgeConflicts conflicts = edge_conflicts(mesh.triangles, lower, upper, uses);
        crowded.add(uses.size() > 2, [&] { return edge_text(lower, upper); });
        repeated_direction.add(conflicts.forward > 1, [&] { return edge_text(lower, upper); });
        repeated_direction.add(conflicts.backward > 1, [&] { return edge_text(upper, lower); });
        duplicate.add(conflicts.repeats > 0, [&] { return "at " + edge_text(lower, upper); });
      });
  degenerate.append_to(lines, "triangle with two equal vertices");
  crowded.append_to(lines, "edge of more than two triangles");
  repeated_direction.append_to(lines, "directed edge used twice");
  duplicate.append_to(lines, "triangle that is there twice");
}

}  // namespace

std::vector<std::string> validate_mesh(const TriangleMesh& mesh) {
  std::vector<std::string> lines;
  validate_arrays(mesh, lines);
  // Without valid indices there are no edges to speak of.
  for (const Triangle& t : mesh.triangles)
    if (*std::max_element(t.begin(), t.end()) >= mesh.vertices.size()) return lines;
  validate_edges(mesh, lines);
  return lines;
}

}  // namespace orbweave
