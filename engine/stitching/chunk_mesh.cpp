#include "engine/stitching/chunk_mesh.h"

#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/geometry/disjoint_sets.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kNoNode = 0xffffffffu;

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
  explicit ComponentNumbers(FanNodes& nodes)
      : nodes_(nodes), number_(nodes.sets().size(), kNoNode) {}
  std::uint64_t of(std::uint32_t node) {
    std::uint32_t& number = number_[nodes_.sets().find(node)];
    if (number == kNoNode) number = count_++;
    return number;
  }
  std::uint64_t count() const { return count_; }

 private:
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

/// Flags of the points that other chunks may share nodes of: owned ones near the border, and those
/// of others that are used.
std::vector<std::uint8_t> seam_points(const ChunkPoints& points, const ChunkMesh& mesh,
                                      const Box& box, double seam_width,
                                      std::vector<std::uint8_t> used) {
  for (std::uint32_t i = points.owned_begin; i < points.owned_end; ++i) {
    used[i] =
        mesh.fans[i - points.owned_begin] != 0 && near_border(points.positions[i], box, seam_width);
  }
  return used;
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

/// The components that the chunk owns triangles of, numbered by their first triangles.
void add_pieces(const ChunkPoints& points, const BallPivotingResult& result,
                std::span<const std::uint8_t> used, const FanNodes& nodes,
                ComponentNumbers& numbers, ChunkMesh& mesh) {
  std::uint32_t last_node = kNoNode;
  std::uint64_t number = 0;
  for (const Triangle& t : result.triangles) {  // ascending
    const std::uint32_t node = nodes.at(t[0], t[1]);
    if (node != last_node) number = numbers.of(node);
    last_node = node;
    if (number == mesh.pieces.size()) {
      mesh.pieces.emplace_back().first = {points.global[t[0]], points.global[t[1]],
                                          points.global[t[2]]};
    }
    ++mesh.pieces[number].triangles;
    if (result.fan_members.empty()) continue;
    for (const std::uint32_t vertex : t) {
      if (result.fans[vertex] > 1) mesh.pieces[number].box.extend(points.positions[vertex]);
    }
  }
  // All other vertices are of one piece each, and in the order of memory.
  for (std::uint32_t vertex = 0; vertex < used.size(); ++vertex) {
    if (used[vertex] == 0 || result.fans[vertex] > 1) continue;
    mesh.pieces[numbers.of(vertex)].box.extend(points.positions[vertex]);
  }
}

/// Joins the nodes of each triangle.
void join_triangles(std::span<const Triangle> triangles, FanNodes& nodes, const StopToken* stop) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (t % kStopBlock == 0) check_stop(stop);
    nodes.join(triangles[t]);
  }
}

/// Pieces, seam and boundary of a chunk whose nodes are joined.
void number_components(const ChunkPoints& points, const BallPivotingResult& result,
                       std::span<const std::uint8_t> used, std::span<const std::uint8_t> on_seam,
                       FanNodes& nodes, ChunkMesh& mesh, const StopToken* stop) {
  ComponentNumbers numbers(nodes);
  add_pieces(points, result, used, nodes, numbers, mesh);
  check_stop(stop);
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
}

double area_of(const ChunkPoints& points, const Triangle& t) {
  const Vec3 a = points.positions[t[0]];
  return 0.5 * norm(cross(points.positions[t[1]] - a, points.positions[t[2]] - a));
}

/// Flags of the points that the triangles use; their area as well, which takes the same corners.
std::vector<std::uint8_t> used_points(const ChunkPoints& points,
                                      std::span<const Triangle> triangles, double& area) {
  std::vector<std::uint8_t> used(points.positions.size(), 0);
  for (const Triangle& t : triangles) {
    area += area_of(points, t);
    for (const std::uint32_t vertex : t) used[vertex] = 1;
  }
  return used;
}

/// Lists the points of others and numbers all points as the chunk does; meaningless where neither
/// it owns a point nor its triangles use it.
std::vector<std::uint32_t> number_points(const ChunkPoints& points,
                                         std::span<const std::uint8_t> used, ChunkMesh& mesh) {
  std::vector<std::uint32_t> local(points.positions.size(), 0);
  const std::uint32_t own = points.owned_end - points.owned_begin;
  std::iota(local.begin() + points.owned_begin, local.begin() + points.owned_end, 0u);
  for (std::uint32_t i = 0; i < used.size(); ++i) {
    if (used[i] == 0 || points.is_owned(i)) continue;
    local[i] = own + static_cast<std::uint32_t>(mesh.outer_vertices.size());
    mesh.outer_vertices.push_back(points.global[i]);
    mesh.outer_positions.push_back(points.positions[i]);
  }
  return local;
}

}  // namespace

ChunkMesh make_chunk_mesh(const ChunkPoints& points, BallPivotingResult result, const Box& box,
                          double seam_width, const StopToken* stop) {
  ChunkMesh mesh;
  mesh.conflicts_lost = result.conflicts_lost;
  mesh.isolated_dropped = result.isolated_dropped;
  mesh.fans.assign(result.fans.begin() + points.owned_begin,
                   result.fans.begin() + points.owned_end);
  FanNodes nodes(result);
  std::vector<std::uint8_t> used, on_seam;
  std::vector<std::uint32_t> local;
  // A thread that waits here must not begin another chunk, whose memory is not free yet.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_invoke([&] { join_triangles(result.triangles, nodes, stop); },
                         [&] {
                           used = used_points(points, result.triangles, mesh.area);
                           check_stop(stop);
                           local = number_points(points, used, mesh);
                           on_seam = seam_points(points, mesh, box, seam_width, used);
                         });
  });
  number_components(points, result, used, on_seam, nodes, mesh, stop);
  mesh.triangles = std::move(result.triangles);
  for (Triangle& t : mesh.triangles) t = {local[t[0]], local[t[1]], local[t[2]]};
  return mesh;
}

}  // namespace orbweave
