#include "engine/geometry/triangle_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace orbweave {
namespace {

constexpr std::size_t kLeafItems = 8;
constexpr std::size_t kParallelItems = 16384;

double squared_distance_to_segment(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 along = b - a, to = p - a;
  const double length = squared_norm(along);
  const double t = length > 0.0 ? std::clamp(dot(to, along) / length, 0.0, 1.0) : 0.0;
  return squared_norm(to - t * along);
}

double squared_distance_to_box(Vec3 p, const Box& box) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double outside = std::max({box.min[axis] - p[axis], 0.0, p[axis] - box.max[axis]});
    sum += outside * outside;
  }
  return sum;
}

}  // namespace

double squared_distance_to_triangle(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 normal = cross(b - a, c - a);
  const double length = squared_norm(normal);
  const bool above = length > 0.0 && dot(cross(b - a, p - a), normal) >= 0.0 &&
                     dot(cross(c - b, p - b), normal) >= 0.0 &&
                     dot(cross(a - c, p - c), normal) >= 0.0;
  if (above) {
    const double height = dot(p - a, normal);
    const double squared = height * height;
    // The sixth power of a length may be no double where its fourth power is one.
    return std::isnormal(squared) ? squared / length : height / length * height;
  }
  return std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                   squared_distance_to_segment(p, c, a)});
}

TriangleTree::TriangleTree(const TriangleMesh& mesh)
    : positions_(mesh.vertices.positions), triangles_(mesh.triangles) {
  items_.resize(triangles_.empty() ? positions_.size() : triangles_.size());
  std::iota(items_.begin(), items_.end(), 0u);
  while ((kLeafItems << depth_) < items_.size()) ++depth_;
  boxes_.resize((std::size_t{2} << depth_) - 1);
  if (!items_.empty()) build(0, 0, items_.size(), depth_);
}

Triangle TriangleTree::item(std::uint32_t index) const {
  return triangles_.empty() ? Triangle{index, index, index} : triangles_[index];
}

Vec3 TriangleTree::center(std::uint32_t index) const {
  const Triangle t = item(index);
  return (positions_[t[0]] + positions_[t[1]] + positions_[t[2]]) / 3.0;
}

void TriangleTree::build(std::size_t node, std::size_t begin, std::size_t end, int depth) {
  const auto first = items_.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto last = items_.begin() + static_cast<std::ptrdiff_t>(end);
  if (depth == 0) {
    for (auto it = first; it != last; ++it)
      for (const std::uint32_t v : item(*it)) boxes_[node].extend(positions_[v]);
    return;
  }
  Box centers;
  for (auto it = first; it != last; ++it) centers.extend(center(*it));
  const Vec3 extent = centers.extent();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::size_t middle = begin + (end - begin) / 2;
  std::nth_element(first, items_.begin() + static_cast<std::ptrdiff_t>(middle), last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = center(a)[axis], y = center(b)[axis];
                     return x != y ? x < y : a < b;
                   });
  const auto lower = [&] { build(2 * node + 1, begin, middle, depth - 1); };
  const auto upper = [&] { build(2 * node + 2, middle, end, depth - 1); };
  if (end - begin > kParallelItems) {
    tbb::parallel_invoke(lower, upper);
  } else {
    lower();
    upper();
  }
  boxes_[node].extend(boxes_[2 * node + 1]);
  boxes_[node].extend(boxes_[2 * node + 2]);
}

TriangleTree::Nearest TriangleTree::nearest_in(std::size_t begin, std::size_t end, Vec3 p,
                                               Nearest best) const {
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle t = item(items_[i]);
    const double squared =
        squared_distance_to_triangle(p, positions_[t[0]], positions_[t[1]], positions_[t[2]]);
    if (squared < best.squared_distance) best = {squared, items_[i]};
  }
  return best;
}

TriangleTree::Nearest TriangleTree::nearest(Vec3 p, double enough) const {
  Nearest best{std::numeric_limits<double>::infinity(), 0};
  if (items_.empty()) return best;
  struct Visit {
    std::size_t node, begin, end;
    int depth;
    double bound;
  };
  std::array<Visit, 64> stack;  // one per level at most, and 2^58 triangles are plenty
  std::size_t size = 0;
  stack[size++] = {0, 0, items_.size(), depth_, 0.0};
  while (size > 0) {
    const Visit visit = stack[--size];
    if (visit.bound >= best.squared_distance) continue;
    if (visit.depth == 0) {
      best = nearest_in(visit.begin, visit.end, p, best);
      if (best.squared_distance <= enough) break;
      continue;
    }
    const std::size_t middle = visit.begin + (visit.end - visit.begin) / 2;
    const std::size_t child = 2 * visit.node + 1;
    Visit near{child, visit.begin, middle, visit.depth - 1,
               squared_distance_to_box(p, boxes_[child])};
    Visit far{child + 1, middle, visit.end, visit.depth - 1,
              squared_distance_to_box(p, boxes_[child + 1])};
    if (far.bound < near.bound) std::swap(near, far);
    if (far.bound < best.squared_distance) stack[size++] = far;
    if (near.bound < best.squared_distance) stack[size++] = near;
  }
  return best;
}

}  // namespace orbweave
