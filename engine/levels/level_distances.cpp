#include "engine/levels/level_distances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include "engine/geometry/triangle_tree.h"
#include "io/meshes/vertex_colors.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kMostVertices = std::uint64_t{1} << 18;
constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 16;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A channel as a share of its range.
using Color = std::array<double, 3>;

Color color_of(const VertexColors& colors, const PointCloud& points, std::size_t i) {
  Color color{};
  const auto channels = colors.of(points, i);
  for (std::size_t c = 0; c < color.size(); ++c)
    color[c] = static_cast<double>(channels[c].value) / static_cast<double>(channels[c].most);
  return color;
}

/// A vertex of the mesh that is measured.
struct VertexSample {
  Vec3 position;
  Color color{};
};

/// The middle of a triangle of a node that is measured, and what was found of it.
struct MiddleSample {
  Vec3 position;
  double squared_distance = kInfinity;
};

/// Of one node, until those of its height are put together in their order.
struct NodeSums {
  double largest = 0.0;  ///< squared
  double distances = 0.0;
  double colors = 0.0;
  std::uint64_t vertices = 0;
};

double squared_distance(Vec3 p, const Box& box) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double outside = std::max({box.min[axis] - p[axis], p[axis] - box.max[axis], 0.0});
    sum += outside * outside;
  }
  return sum;
}

/// Weights of the corners at the point of a segment nearest to p: 1 - t and t.
double place_on_segment(Vec3 p, Vec3 a, Vec3 b) {
  const double length = squared_norm(b - a);
  return length > 0.0 ? std::clamp(dot(p - a, b - a) / length, 0.0, 1.0) : 0.0;
}

/// Weights of the corners at the triangle's point nearest to p.
std::array<double, 3> nearest_weights(Vec3 p, const std::array<Vec3, 3>& corners) {
  const auto [a, b, c] = corners;
  const Vec3 normal = cross(b - a, c - a);
  const double area = squared_norm(normal);
  if (area > 0.0) {
    const double of_c = dot(cross(b - a, p - a), normal) / area;
    const double of_b = dot(cross(p - a, c - a), normal) / area;
    if (of_b >= 0.0 && of_c >= 0.0 && of_b + of_c <= 1.0) return {1.0 - of_b - of_c, of_b, of_c};
  }
  std::array<double, 3> nearest{1.0, 0.0, 0.0};
  double least = kInfinity;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    const double t = place_on_segment(p, corners[i], corners[next]);
    const Vec3 place = corners[i] + t * (corners[next] - corners[i]);
    if (squared_norm(p - place) >= least) continue;
    least = squared_norm(p - place);
    nearest = {};
    nearest[i] = 1.0 - t;
    nearest[next] += t;
  }
  return nearest;
}

class LevelMeasure {
 public:
  LevelMeasure(const LevelMaker& maker, const StopToken& stop)
      : maker_(maker),
        nodes_(maker.levels().nodes),
        stop_(stop),
        vertices_(nodes_.size()),
        middles_(nodes_.size()),
        sums_(nodes_.size()),
        heights_(static_cast<std::size_t>(nodes_[0].height) + 1) {}

  std::vector<LevelDistance> measure() {
    collect_samples();
    measure_vertices();
    measure_middles();
    return put_together();
  }

 private:
  /// Every so many of a number of things.
  static std::uint64_t stride(std::uint64_t count, std::uint64_t most) {
    return (count + most - 1) / most;
  }

  void collect_samples() {
    std::vector<std::uint64_t> of_height(heights_.size(), 0);
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      of_height[static_cast<std::size_t>(nodes_[i].height)] += maker_.levels().facts[i].triangles;
    const std::uint64_t vertex_stride =
        std::max<std::uint64_t>(1, stride(maker_.levels().vertices, kMostVertices));
    maker_.on_threads(nodes_.size(), [&](std::size_t i) {
      stop_.check();
      const auto number = static_cast<std::uint32_t>(i);
      const NodeMesh mesh = maker_.node(number);
      if (nodes_[i].is_leaf())
        take_vertices(number, mesh, vertex_stride);
      else
        take_middles(number, mesh,
                     stride(of_height[static_cast<std::size_t>(nodes_[i].height)], kMostTriangles));
    });
  }

  void take_vertices(std::uint32_t leaf, const NodeMesh& mesh, std::uint64_t every) {
    const PointCloud points = maker_.points(mesh);
    const VertexColors colors(points.schema);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      if (mesh.vertices[i] % every != 0) continue;
      VertexSample sample{points.positions[i], {}};
      if (colors.all_are_there()) sample.color = color_of(colors, points, i);
      vertices_[leaf].push_back(sample);
    }
  }

  void take_middles(std::uint32_t node, const NodeMesh& mesh, std::uint64_t every) {
    const std::vector<Vec3> positions = maker_.positions(mesh);
    for (std::size_t i = 0; i < mesh.triangles.size(); i += every) {
      const Triangle& t = mesh.triangles[i];
      middles_[node].push_back(
          {(1.0 / 3.0) * (positions[t[0]] + positions[t[1]] + positions[t[2]]), kInfinity});
    }
  }

  std::vector<std::uint32_t> leaves_below(std::uint32_t node) const {
    if (nodes_[node].is_leaf()) return {node};
    std::vector<std::uint32_t> leaves;
    for (const std::uint32_t child : nodes_[node].children) {
      const std::vector<std::uint32_t> below = leaves_below(child);
      leaves.insert(leaves.end(), below.begin(), below.end());
    }
    return leaves;
  }

  /// From vertices of the mesh to each node above them.
  void measure_vertices() {
    maker_.on_threads(nodes_.size(), [&](std::size_t i) {
      if (nodes_[i].is_leaf()) return;
      stop_.check();
      const auto number = static_cast<std::uint32_t>(i);
      TriangleMesh mesh;
      {
        NodeMesh node = maker_.node(number);
        mesh.vertices = maker_.points(node);
        mesh.triangles = std::move(node.triangles);
      }
      const TriangleTree tree(mesh);
      const VertexColors colors(mesh.vertices.schema);
      for (const std::uint32_t leaf : leaves_below(number))
        for (const VertexSample& sample : vertices_[leaf])
          add_vertex(sample, mesh, tree, colors, sums_[i]);
    });
  }

  static void add_vertex(const VertexSample& sample, const TriangleMesh& mesh,
                         const TriangleTree& tree, const VertexColors& colors, NodeSums& sums) {
    const TriangleTree::Nearest nearest = tree.nearest(sample.position);
    sums.largest = std::max(sums.largest, nearest.squared_distance);
    sums.distances += nearest.squared_distance;
    ++sums.vertices;
    if (!colors.all_are_there()) return;
    const Triangle& t = mesh.triangles[nearest.item];
    const std::vector<Vec3>& p = mesh.vertices.positions;
    const std::array<double, 3> weights =
        nearest_weights(sample.position, {p[t[0]], p[t[1]], p[t[2]]});
    Color color{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Color own = color_of(colors, mesh.vertices, t[corner]);
      for (std::size_t c = 0; c < color.size(); ++c) color[c] += weights[corner] * own[c];
    }
    for (std::size_t c = 0; c < color.size(); ++c)
      sums.colors += (color[c] - sample.color[c]) * (color[c] - sample.color[c]) / 3.0;
  }

  /// From middles of triangles to the mesh: leaf by leaf, each with the samples of all nodes above
  /// it that it is not too far from.
  void measure_middles() {
    std::vector<std::uint32_t> parents(nodes_.size(), 0);
    std::vector<std::uint32_t> leaves;
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      for (const std::uint32_t child : nodes_[i].children) parents[child] = i;
      if (nodes_[i].is_leaf()) leaves.push_back(i);
    }
    maker_.on_threads(leaves.size(), [&](std::size_t i) {
      stop_.check();
      std::vector<std::uint32_t> above;
      for (std::uint32_t node = leaves[i]; node != 0;) {
        node = parents[node];
        above.push_back(node);
      }
      if (!above.empty()) measure_at(leaves[i], above);
    });
  }

  void measure_at(std::uint32_t leaf, const std::vector<std::uint32_t>& above) {
    TriangleMesh mesh;
    {
      NodeMesh node = maker_.node(leaf);
      mesh.vertices.positions = maker_.positions(node);
      mesh.triangles = std::move(node.triangles);
    }
    const TriangleTree tree(mesh);
    const Box& bounds = maker_.levels().facts[leaf].bounds;
    for (const std::uint32_t node : above) {
      std::vector<MiddleSample> samples;
      {
        const std::scoped_lock lock(mutex_);
        samples = middles_[node];
      }
      for (MiddleSample& sample : samples)
        if (squared_distance(sample.position, bounds) < sample.squared_distance)
          sample.squared_distance =
              std::min(sample.squared_distance, tree.squared_distance(sample.position));
      const std::scoped_lock lock(mutex_);
      for (std::size_t i = 0; i < samples.size(); ++i)
        middles_[node][i].squared_distance =
            std::min(middles_[node][i].squared_distance, samples[i].squared_distance);
    }
  }

  std::vector<LevelDistance> put_together() {
    std::vector<NodeSums> sums(heights_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const auto height = static_cast<std::size_t>(nodes_[i].height);
      NodeSums& sum = sums[height];
      sum.largest = std::max(sum.largest, sums_[i].largest);
      sum.distances += sums_[i].distances;
      sum.colors += sums_[i].colors;
      sum.vertices += sums_[i].vertices;
      heights_[height].samples += sums_[i].vertices + middles_[i].size();
      for (const MiddleSample& sample : middles_[i])
        sum.largest = std::max(sum.largest, sample.squared_distance);
    }
    for (std::size_t height = 0; height < heights_.size(); ++height) {
      const auto count = static_cast<double>(std::max<std::uint64_t>(sums[height].vertices, 1));
      heights_[height].distance = std::sqrt(sums[height].largest);
      heights_[height].mean_distance = std::sqrt(sums[height].distances / count);
      heights_[height].color_error = std::sqrt(sums[height].colors / count);
      heights_[height].has_colors = VertexColors(maker_.schema()).all_are_there();
    }
    return std::move(heights_);
  }

  const LevelMaker& maker_;
  const std::vector<LevelNode>& nodes_;
  const StopToken& stop_;
  std::vector<std::vector<VertexSample>> vertices_;  ///< of each leaf
  std::vector<std::vector<MiddleSample>> middles_;   ///< of each node that is no leaf
  std::vector<NodeSums> sums_;
  std::vector<LevelDistance> heights_;
  std::mutex mutex_;  ///< of the middles' distances
};

}  // namespace

std::vector<LevelDistance> measure_levels(const LevelMaker& maker, const StopToken& stop) {
  return LevelMeasure(maker, stop).measure();
}

}  // namespace orbweave
