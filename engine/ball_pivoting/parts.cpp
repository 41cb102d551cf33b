#include "engine/ball_pivoting/parts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include "io/bounds.h"

namespace orbweave {
namespace {

using Indices = std::vector<std::uint32_t>;

/// Some of the points, by their indices in the whole, ascending.
struct Part {
  Indices points;
  std::vector<std::uint8_t> owned;  ///< per point
};

/// Puts the results of parts together.
class Merger {
 public:
  explicit Merger(std::size_t points) { whole_.fans.assign(points, 0); }

  void add(const Part& part, const BallPivotingResult& result) {
    const Indices& of = part.points;
    // What a part says of a point holds where the part owns it or has one of its triangles.
    std::vector<std::uint8_t> known = part.owned;
    for (const Triangle& t : result.triangles) {
      whole_.triangles.push_back({of[t[0]], of[t[1]], of[t[2]]});
      for (const std::uint32_t v : t) known[v] = 1;
    }
    for (std::size_t v = 0; v < of.size(); ++v)
      if (known[v] != 0) whole_.fans[of[v]] = result.fans[v];
    for (const BoundaryFan& fan : result.boundary)
      if (known[fan.vertex] != 0)
        whole_.boundary.push_back({of[fan.previous], of[fan.vertex], of[fan.next]});
    for (const FanMember& member : result.fan_members)
      if (known[member.vertex] != 0)
        whole_.fan_members.push_back({of[member.vertex], of[member.first], of[member.fan]});
    whole_.conflicts_lost += result.conflicts_lost;
    whole_.isolated_dropped += result.isolated_dropped;
  }

  /// Parts that know the same point agree on its triangles.
  BallPivotingResult take() {
    std::sort(whole_.triangles.begin(), whole_.triangles.end());
    sort_unique(whole_.fan_members, std::less<>());
    sort_unique(whole_.boundary, [](const BoundaryFan& a, const BoundaryFan& b) {
      return std::pair(a.vertex, a.next) < std::pair(b.vertex, b.next);
    });
    return std::move(whole_);
  }

 private:
  template <class T, class Before>
  static void sort_unique(std::vector<T>& list, const Before& before) {
    std::sort(list.begin(), list.end(), before);
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }

  BallPivotingResult whole_;
};

class Divider {
 public:
  Divider(const PivotInput& input, double halo_width, double most,
          const std::function<BallPivotingResult(const PivotInput&, const Box&)>& pivot)
      : input_(input),
        halo_width_(halo_width),
        most_(most),
        pivot_(pivot),
        merger_(input.positions.size()) {}

  BallPivotingResult take() { return merger_.take(); }

  /// Works on a part, or cuts the part in two until each is small enough. Points that are out of
  /// reach of a half are let go of at once, so all parts that wait together hold about as many
  /// points as the whole, but for their halos.
  void divide(Part whole, const StopToken* stop) {
    std::vector<Part> waiting;
    waiting.push_back(std::move(whole));
    while (!waiting.empty()) {
      check_stop(stop);
      const Part part = std::move(waiting.back());
      waiting.pop_back();
      const Box core = box_of_owned(part);
      if (core.empty()) continue;
      const Box box = box_of(part);
      if (!(box.largest_extent() > most_)) {
        work_on(part, box);
        continue;
      }
      const int axis = longest_axis(core);
      const double middle = middle_of(part, core, axis);
      waiting.push_back(owning(part, [&](Vec3 p) { return !(p[axis] < middle); }));
      waiting.push_back(owning(part, [&](Vec3 p) { return p[axis] < middle; }));
    }
  }

  /// The points owned for which `wanted` holds, and all within their reach.
  template <class Wanted>
  Part owning(const Part& part, const Wanted& wanted) const {
    const auto owns = [&](std::size_t k) {
      return part.owned[k] != 0 && wanted(at(part.points[k]));
    };
    Box core;
    for (std::size_t k = 0; k < part.points.size(); ++k)
      if (owns(k)) core.extend(at(part.points[k]));
    Part half;
    if (core.empty()) return half;
    const Box near = core.grown(halo_width_);
    for (std::size_t k = 0; k < part.points.size(); ++k) {
      if (!near.contains(at(part.points[k]))) continue;
      half.points.push_back(part.points[k]);
      half.owned.push_back(owns(k) ? 1 : 0);
    }
    return half;
  }

 private:
  const Vec3& at(std::uint32_t i) const { return input_.positions[i]; }

  Box box_of(const Part& part) const {
    Box box;
    for (const std::uint32_t i : part.points) box.extend(at(i));
    return box;
  }
  Box box_of_owned(const Part& part) const {
    Box box;
    for (std::size_t k = 0; k < part.points.size(); ++k)
      if (part.owned[k] != 0) box.extend(at(part.points[k]));
    return box;
  }
  static int longest_axis(const Box& box) {
    const Vec3 extent = box.extent();
    return extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  }
  /// A value that leaves about half of the owned points below it, and at least one on each side:
  /// where half of them or more lie at the very minimum, the next value. Halves hence shrink by
  /// half or lose their extent along the axis.
  double middle_of(const Part& part, const Box& core, int axis) const {
    std::vector<double> values;
    for (std::size_t k = 0; k < part.points.size(); ++k)
      if (part.owned[k] != 0) values.push_back(at(part.points[k])[axis]);
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    if (*half > core.min[axis]) return *half;
    double next = core.max[axis];
    for (const double value : values)
      if (value > core.min[axis]) next = std::min(next, value);
    if (!(next > core.min[axis]))
      throw std::logic_error("pivot_in_parts: `most` is less than two halos");
    return next;
  }
  void work_on(const Part& part, const Box& box) {
    std::vector<Vec3> positions, normals;
    for (const std::uint32_t i : part.points) {
      positions.push_back(at(i));
      normals.push_back(input_.normals[i]);
    }
    merger_.add(part, pivot_({positions, normals, part.owned}, box));
  }

  const PivotInput& input_;
  const double halo_width_;
  const double most_;
  const std::function<BallPivotingResult(const PivotInput&, const Box&)>& pivot_;
  Merger merger_;
};

Part whole_of(const PivotInput& input) {
  Part part;
  part.points.resize(input.positions.size());
  for (std::size_t i = 0; i < part.points.size(); ++i)
    part.points[i] = static_cast<std::uint32_t>(i);
  part.owned.assign(input.owned.begin(), input.owned.end());
  if (part.owned.empty()) part.owned.assign(part.points.size(), 1);
  return part;
}

}  // namespace

BallPivotingResult pivot_in_parts(
    const PivotInput& input, double halo_width, double most,
    const std::function<BallPivotingResult(const PivotInput&, const Box&)>& pivot,
    const StopToken* stop) {
  const Box box = bounds_of(input.positions);
  if (!(box.largest_extent() > most)) return pivot(input, box);
  Divider divider(input, halo_width, most, pivot);
  divider.divide(divider.owning(whole_of(input), [](Vec3) { return true; }), stop);
  return divider.take();
}

}  // namespace orbweave
