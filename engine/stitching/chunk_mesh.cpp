#include "engine/stitching/chunk_mesh.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/geometry/concurrent_sets.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kNoNode = 0xffffffffu;

/// Nodes of a chunk: one per point, and one more per fan where several meet.
class FanNodes {
 public:
  explicit FanNodes(const BallPivotingResult& result)
      : result_(result), nodes_(result.fan_members.size()), sets_(number_members()) {}

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
  /// Thread-safe.
  void join(const Triangle& t) {
    const std::uint32_t a = at(t[0], t[1]);
    sets_.unite(a, at(t[1], t[2]));
    sets_.unite(a, at(t[2], t[0]));
  }
  std::size_t size() const { return size_; }
  /// The root of each node; the joins are used up.
  std::vector<std::uint32_t> take_roots() { return sets_.take_roots(); }

 private:
  /// Returns how many nodes there are.
  std::size_t number_members() {
    const auto& members = result_.fan_members;
    size_ = result_.fans.size();
    for (std::size_t i = 0; i < members.size(); ++i) {
      const bool same_fan_before = [&] {
        for (std::size_t k = i; k-- > 0 && members[k].vertex == members[i].vertex;) {
          if (members[k].fan != members[i].fan) continue;
          nodes_[i] = nodes_[k];
          return true;
        }
        return false;
      }();
      if (!same_fan_before) nodes_[i] = static_cast<std::uint32_t>(size_++);
    }
    return size_;
  }

  const BallPivotingResult& result_;
  std::size_t size_ = 0;
  std::vector<std::uint32_t> nodes_;  // per fan member
  ConcurrentSets sets_;
};

/// Numbers the components that matter from 0.
class ComponentNumbers {
 public:
  explicit ComponentNumbers(FanNodes& nodes)
      : number_(nodes.size(), kNoNode), roots_(nodes.take_roots()) {}
  std::uint32_t root(std::uint32_t node) const { return roots_[node]; }
  std::uint64_t of(std::uint32_t node) {
    std::uint32_t& number = number_[roots_[node]];
    if (number == kNoNode) number = count_++;
    return number;
  }
  std::uint64_t count() const { return count_; }

 private:
  std::vector<std::uint32_t> number_;
  std::vector<std::uint32_t> roots_;
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

/// Triangles or vertices of one component that follow each other.
struct Run {
  std::uint32_t root = 0;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  Box box;  ///< of vertices that the run is to bound
};

/// Finds the runs among `count` items with find(begin, end, runs), many blocks at once, and takes
/// them in order with take(run).
template <class Find, class Take>
void for_runs(std::size_t count, const Find& find, const Take& take) {
  // What the runs of so many blocks take is little, though each item may be a run.
  constexpr std::size_t kBlock = 4096, kBlocks = 64;
  std::vector<std::vector<Run>> runs(kBlocks);
  for (std::size_t first = 0; first < count; first += kBlock * kBlocks) {
    tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t block) {
      runs[block].clear();
      const std::size_t begin = std::min(count, first + block * kBlock);
      find(begin, std::min(count, begin + kBlock), runs[block]);
    });
    for (const std::vector<Run>& of_block : runs)
      for (const Run& run : of_block) take(run);
  }
}

/// The run of the next item.
Run& run_of(std::uint32_t root, std::size_t item, std::vector<Run>& runs) {
  if (runs.empty() || runs.back().root != root)
    runs.push_back({root, static_cast<std::uint32_t>(item), 0, {}});
  ++runs.back().count;
  return runs.back();
}

/// The components that the chunk owns triangles of, numbered by their first triangles.
void add_pieces(const ChunkPoints& points, const BallPivotingResult& result,
                std::span<const std::uint8_t> used, const FanNodes& nodes,
                ComponentNumbers& numbers, ChunkMesh& mesh) {
  const auto find_in_triangles = [&](std::size_t begin, std::size_t end, std::vector<Run>& runs) {
    for (std::size_t i = begin; i < end; ++i) {
      const Triangle& t = result.triangles[i];
      Run& run = run_of(numbers.root(nodes.at(t[0], t[1])), i, runs);
      if (result.fan_members.empty()) continue;
      for (const std::uint32_t vertex : t)
        if (result.fans[vertex] > 1) run.box.extend(points.positions[vertex]);
    }
  };
  for_runs(result.triangles.size(), find_in_triangles, [&](const Run& run) {  // ascending
    const std::uint64_t number = numbers.of(run.root);
    if (number == mesh.pieces.size()) {
      const Triangle& t = result.triangles[run.first];
      mesh.pieces.emplace_back().first = {points.global[t[0]], points.global[t[1]],
                                          points.global[t[2]]};
    }
    mesh.pieces[number].triangles += run.count;
    mesh.pieces[number].box.extend(run.box);
  });
  // All other vertices are of one piece each, and in the order of memory.
  const auto find_in_vertices = [&](std::size_t begin, std::size_t end, std::vector<Run>& runs) {
    for (std::size_t i = begin; i < end; ++i) {
      if (used[i] == 0 || result.fans[i] > 1) continue;
      run_of(numbers.root(static_cast<std::uint32_t>(i)), i, runs).box.extend(points.positions[i]);
    }
  };
  for_runs(used.size(), find_in_vertices,
           [&](const Run& run) { mesh.pieces[numbers.of(run.root)].box.extend(run.box); });
}

/// Joins the nodes of each triangle.
void join_triangles(std::span<const Triangle> triangles, FanNodes& nodes, const StopToken* stop) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), kStopBlock),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      check_stop(stop);
                      for (std::size_t t = range.begin(); t < range.end(); ++t)
                        nodes.join(triangles[t]);
                    });
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

/// Adds the triangle's area, and the volume of the cone to it.
void measure(const ChunkPoints& points, const Triangle& t, ChunkMesh& mesh) {
  const Vec3 a = points.positions[t[0]];
  const Vec3 across = cross(points.positions[t[1]] - a, points.positions[t[2]] - a);
  mesh.area += 0.5 * norm(across);
  mesh.volume += dot(a - points.origin, across) / 6.0;
}

/// Flags of the points that the triangles use; their area and volume as well, which take the same
/// corners.
std::vector<std::uint8_t> used_points(const ChunkPoints& points,
                                      std::span<const Triangle> triangles, ChunkMesh& mesh) {
  std::vector<std::uint8_t> used(points.positions.size(), 0);
  for (const Triangle& t : triangles) {
    measure(points, t, mesh);
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

void renumber(std::span<const std::uint32_t> local, std::span<Triangle> triangles) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), kStopBlock),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        Triangle& t = triangles[i];
                        t = {local[t[0]], local[t[1]], local[t[2]]};
                      }
                    });
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
                           used = used_points(points, result.triangles, mesh);
                           check_stop(stop);
                           local = number_points(points, used, mesh);
                           on_seam = seam_points(points, mesh, box, seam_width, used);
                         });
  });
  tbb::this_task_arena::isolate(
      [&] { number_components(points, result, used, on_seam, nodes, mesh, stop); });
  mesh.triangles = std::move(result.triangles);
  tbb::this_task_arena::isolate([&] { renumber(local, mesh.triangles); });
  return mesh;
}

}  // namespace orbweave
