#include "engine/stitching/chunk_mesh.h"

#include <algorithm>

#include "engine/validation/disjoint_sets.h"

namespace orbweave {
namespace {

/// Nodes of a chunk: one per point, and one more per fan where several meet.
class FanNodes {
 public:
  explicit FanNodes(const BallPivotingResult& result) : result_(result), sets_(result.fans.size()) {
    const auto& members = result.fan_members;
    nodes_.resize(members.size());
    for (std::size_t i = 0; i < members.size(); ++i) {
      const bool same_fan_before = [&] {
        for (std::size_t k = i; k-- > 0 && members[k].vertex == members[i].vertex;) {
          if (members[k].fan != members[i].fan) continue;
          nodes_[i] = nodes_[k];
          return true;
        }
        return false;
      }();
      if (!same_fan_before) nodes_[i] = sets_.add();
    }
  }

  /// The node of the corner (vertex, first, .) of a triangle.
  std::uint32_t at(std::uint32_t vertex, std::uint32_t first) const {
    if (result_.fans[vertex] < 2) return vertex;
    const auto& members = result_.fan_members;
    const auto found =
        std::lower_bound(members.begin(), members.end(), FanMember{vertex, first, 0});
    const bool known = found != members.end() && found->vertex == vertex && found->first == first;
    return known ? nodes_[static_cast<std::size_t>(found - members.begin())] : vertex;
  }
  std::uint32_t of_member(std::size_t member) const { return nodes_[member]; }
  void join(const Triangle& t) {
    const std::uint32_t a = at(t[0], t[1]);
    sets_.unite(a, at(t[1], t[2]));
    sets_.unite(a, at(t[2], t[0]));
  }
  DisjointSets& sets() { return sets_; }

 private:
  const BallPivotingResult& result_;
  DisjointSets sets_;
  std::vector<std::uint32_t> nodes_;  // per fan member
};

/// Numbers the components that matter from 0.
class ComponentNumbers {
 public:
  explicit ComponentNumbers(FanNodes& nodes) : nodes_(nodes), number_(nodes.sets().size(), kNone) {}
  std::uint64_t of(std::uint32_t node) {
    std::uint32_t& number = number_[nodes_.sets().find(node)];
    if (number == kNone) number = count_++;
    return number;
  }
  std::uint64_t count() const { return count_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  FanNodes& nodes_;
  std::vector<std::uint32_t> number_;
  std::uint32_t count_ = 0;
};

bool near_border(Vec3 p, const Box& box, double width) {
  for (int axis = 0; axis < 3; ++axis) {
    if (p[axis] < box.min[axis] + width || p[axis] > box.max[axis] - width) return true;
  }
  return false;
}

/// Points whose nodes other chunks may share: owned ones near the border, and those of others.
std::vector<std::uint8_t> seam_points(const ChunkPoints& points, const ChunkMesh& mesh,
                                      const Box& box, double seam_width) {
  std::vector<std::uint8_t> on_seam(points.positions.size(), 0);
  for (std::uint32_t i = points.owned_begin; i < points.owned_end; ++i) {
    on_seam[i] =
        mesh.fans[i - points.owned_begin] != 0 && near_border(points.positions[i], box, seam_width);
  }
  for (const std::uint64_t vertex : mesh.outer_vertices) {
    const auto at = std::lower_bound(points.global.begin(), points.global.end(), vertex);
    on_seam[static_cast<std::size_t>(at - points.global.begin())] = 1;
  }
  return on_seam;
}

void add_boundary(const ChunkPoints& points, const BallPivotingResult& result,
                  const FanNodes& nodes, ComponentNumbers& numbers, ChunkMesh& mesh) {
  for (const BoundaryFan& fan : result.boundary) {
    if (points.owned[fan.vertex] == 0) continue;
    mesh.boundary.push_back({points.global[fan.previous], points.global[fan.vertex],
                             points.global[fan.next], numbers.of(nodes.at(fan.vertex, fan.next))});
    mesh.boundary_vertices.push_back(
        {points.global[fan.vertex], points.positions[fan.vertex], points.normals[fan.vertex]});
  }
  const auto by_vertex = [](const BoundaryVertex& a, const BoundaryVertex& b) {
    return a.vertex < b.vertex;
  };
  const auto same_vertex = [](const BoundaryVertex& a, const BoundaryVertex& b) {
    return a.vertex == b.vertex;
  };
  auto& list = mesh.boundary_vertices;
  std::sort(list.begin(), list.end(), by_vertex);
  list.erase(std::unique(list.begin(), list.end(), same_vertex), list.end());
}

void add_to_piece(const ChunkPoints& points, const Triangle& t, ChunkPiece& piece) {
  // Triangles come in ascending order.
  if (piece.triangles++ == 0) {
    piece.first = {points.global[t[0]], points.global[t[1]], points.global[t[2]]};
  }
  for (const std::uint32_t vertex : t) piece.box.extend(points.positions[vertex]);
}

void find_components(const ChunkPoints& points, const BallPivotingResult& result, const Box& box,
                     double seam_width, ChunkMesh& mesh) {
  FanNodes nodes(result);
  for (const Triangle& t : result.triangles) nodes.join(t);
  ComponentNumbers numbers(nodes);
  for (const Triangle& t : result.triangles) numbers.of(nodes.at(t[0], t[1]));
  const std::vector<std::uint8_t> on_seam = seam_points(points, mesh, box, seam_width);
  for (std::uint32_t i = 0; i < on_seam.size(); ++i) {
    if (on_seam[i] == 0 || result.fans[i] > 1) continue;
    mesh.seam.push_back({points.global[i], SeamNode::kWhole, numbers.of(i)});
  }
  for (std::size_t m = 0; m < result.fan_members.size(); ++m) {
    const FanMember& member = result.fan_members[m];
    if (on_seam[member.vertex] == 0) continue;
    mesh.seam.push_back(
        {points.global[member.vertex], points.global[member.fan], numbers.of(nodes.of_member(m))});
  }
  std::sort(mesh.seam.begin(), mesh.seam.end());
  mesh.seam.erase(std::unique(mesh.seam.begin(), mesh.seam.end()), mesh.seam.end());
  add_boundary(points, result, nodes, numbers, mesh);
  mesh.pieces.resize(numbers.count());
  for (const Triangle& t : result.triangles) {
    add_to_piece(points, t, mesh.pieces[numbers.of(nodes.at(t[0], t[1]))]);
  }
}

double area_of(const ChunkPoints& points, const Triangle& t) {
  const Vec3 a = points.positions[t[0]];
  return 0.5 * norm(cross(points.positions[t[1]] - a, points.positions[t[2]] - a));
}

}  // namespace

ChunkMesh make_chunk_mesh(const ChunkPoints& points, const BallPivotingResult& result,
                          const Box& box, double seam_width) {
  ChunkMesh mesh;
  mesh.conflicts_lost = result.conflicts_lost;
  mesh.isolated_dropped = result.isolated_dropped;
  mesh.fans.assign(result.fans.begin() + points.owned_begin,
                   result.fans.begin() + points.owned_end);
  mesh.triangles.reserve(result.triangles.size());
  for (const Triangle& t : result.triangles) {
    mesh.triangles.push_back({points.global[t[0]], points.global[t[1]], points.global[t[2]]});
    mesh.area += area_of(points, t);
    for (const std::uint32_t vertex : t) {
      if (points.owned[vertex] == 0) mesh.outer_vertices.push_back(vertex);
    }
  }
  std::sort(mesh.outer_vertices.begin(), mesh.outer_vertices.end());
  mesh.outer_vertices.erase(std::unique(mesh.outer_vertices.begin(), mesh.outer_vertices.end()),
                            mesh.outer_vertices.end());
  for (std::uint64_t& vertex : mesh.outer_vertices) {
    mesh.outer_positions.push_back(points.positions[vertex]);
    vertex = points.global[vertex];
  }
  find_components(points, result, box, seam_width, mesh);
  return mesh;
}

}  // namespace orbweave
