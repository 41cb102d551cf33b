#include "engine/holes/problem/boundary_loop.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "engine/geometry/plane_axes.h"

namespace orbweave {
namespace {

/// Grows with the angle of (x, y) from 0 to 4 over one turn. The same on every machine, as the
/// library's atan2 is not.
double pseudo_angle(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (!(sum > 0.0)) return 0.0;
  if (y >= 0.0) return x >= 0.0 ? y / sum : 2.0 - y / sum;
  return x < 0.0 ? 2.0 - y / sum : 4.0 + y / sum;
}

double turned_by(double from, double to) {
  const double turn = to - from;
  return turn > 0.0 ? turn : turn + 4.0;
}

/// Any two directions that make a right-handed frame with the normal.
struct TangentFrame : PlaneAxes {
  explicit TangentFrame(Vec3 normal) : PlaneAxes(plane_axes(normal)) {}
  double angle(Vec3 direction) const { return pseudo_angle(dot(direction, u), dot(direction, v)); }
};

const BoundaryVertex& find(std::span<const BoundaryVertex> vertices, std::uint64_t vertex) {
  return *std::lower_bound(
      vertices.begin(), vertices.end(), vertex,
      [](const BoundaryVertex& known, std::uint64_t number) { return known.vertex < number; });
}

/// The least of all rotations that begin at the smallest vertex.
void rotate_to_least(std::vector<std::uint64_t>& loop, const StopToken* stop) {
  const std::uint64_t smallest = *std::min_element(loop.begin(), loop.end());
  std::vector<std::uint64_t> best;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    if (loop[i] != smallest) continue;
    if (!best.empty()) check_stop(stop);
    std::vector<std::uint64_t> turned(loop.begin() + static_cast<std::ptrdiff_t>(i), loop.end());
    turned.insert(turned.end(), loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(i));
    if (best.empty() || turned < best) best = std::move(turned);
  }
  loop = std::move(best);
}

class LoopTracer {
 public:
  LoopTracer(std::vector<OpenFan> fans, std::span<const BoundaryVertex> vertices,
             const StopToken* stop)
      : fans_(std::move(fans)), vertices_(vertices), stop_(stop) {
    std::sort(fans_.begin(), fans_.end(), [](const OpenFan& a, const OpenFan& b) {
      return std::tie(a.vertex, a.previous, a.next) < std::tie(b.vertex, b.previous, b.next);
    });
  }

  std::vector<BoundaryLoop> trace() {
    pair_fans();
    follow_edges();
    std::vector<std::uint8_t> done(fans_.size(), 0);
    std::vector<BoundaryLoop> loops;
    for (std::uint32_t first = 0; first < fans_.size(); ++first) {
      if (first % kStopBlock == 0) check_stop(stop_);
      if (done[first] != 0) continue;
      std::optional<BoundaryLoop> loop = walk(first, done);
      if (loop) loops.push_back(std::move(*loop));
    }
    tbb::parallel_for(std::size_t{0}, loops.size(), [&](std::size_t l) { finish(loops[l]); });
    std::sort(loops.begin(), loops.end(),
              [](const BoundaryLoop& a, const BoundaryLoop& b) { return a.vertices < b.vertices; });
    return loops;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  const BoundaryVertex& known(std::uint64_t vertex) const { return find(vertices_, vertex); }

  /// after_[f]: the fan whose boundary edge follows the one that arrives at f.
  void pair_fans() {
    after_.resize(fans_.size());
    for (std::uint32_t begin = 0, end = 0; begin < fans_.size(); begin = end) {
      for (end = begin; end < fans_.size() && fans_[end].vertex == fans_[begin].vertex;) ++end;
      for (std::uint32_t f = begin; f < end; ++f) after_[f] = f;
      if (end - begin > 1) pair_around(begin, end);
    }
  }

  /// Several fans at one vertex: each is followed by the next around the normal, unless they
  /// overlap. A fan reaches counter-clockwise from its next to its previous vertex.
  void pair_around(std::uint32_t begin, std::uint32_t end) {
    const BoundaryVertex& center = known(fans_[begin].vertex);
    if (!(squared_norm(center.normal) > 0.0)) return;
    const TangentFrame frame(normalized(center.normal));
    struct Sector {
      double from, width;
      std::uint32_t fan;
    };
    std::vector<Sector> sectors;
    for (std::uint32_t f = begin; f < end; ++f) {
      const double from = frame.angle(known(fans_[f].next).position - center.position);
      const double to = frame.angle(known(fans_[f].previous).position - center.position);
      sectors.push_back({from, turned_by(from, to), f});
    }
    std::sort(sectors.begin(), sectors.end(), [](const Sector& a, const Sector& b) {
      return std::tie(a.from, a.fan) < std::tie(b.from, b.fan);
    });
    for (std::size_t s = 0; s < sectors.size(); ++s) {
      const Sector& follower = sectors[(s + 1) % sectors.size()];
      if (sectors[s].width >= turned_by(sectors[s].from, follower.from)) return;
    }
    for (std::size_t s = 0; s < sectors.size(); ++s) {
      after_[sectors[s].fan] = sectors[(s + 1) % sectors.size()].fan;
    }
  }

  /// The fan that the edge which leaves `fan` arrives at.
  std::uint32_t reached_from(std::uint32_t fan) const {
    const std::uint64_t vertex = fans_[fan].next, previous = fans_[fan].vertex;
    const auto at =
        std::lower_bound(fans_.begin(), fans_.end(), OpenFan{previous, vertex, 0, 0},
                         [](const OpenFan& a, const OpenFan& b) {
                           return std::tie(a.vertex, a.previous) < std::tie(b.vertex, b.previous);
                         });
    const bool found = at != fans_.end() && at->vertex == vertex && at->previous == previous;
    return found ? static_cast<std::uint32_t>(at - fans_.begin()) : kNone;
  }

  /// next_[f]: the fan after the edge that leaves f, or kNone.
  void follow_edges() {
    constexpr std::size_t kGrain = 1024;
    next_.resize(fans_.size());
    tbb::parallel_for(
        tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(fans_.size()), kGrain),
        [&](const tbb::blocked_range<std::uint32_t>& range) {
          for (std::uint32_t f = range.begin(); f < range.end(); ++f) {
            const std::uint32_t reached = reached_from(f);
            next_[f] = reached == kNone ? kNone : after_[reached];
          }
        });
    after_ = {};
  }

  std::optional<BoundaryLoop> walk(std::uint32_t first, std::vector<std::uint8_t>& done) const {
    BoundaryLoop loop;
    std::uint32_t fan = first;
    do {
      if (done[fan] != 0) return std::nullopt;
      done[fan] = 1;
      loop.vertices.push_back(fans_[fan].vertex);
      loop.components.push_back(fans_[fan].component);
      fan = next_[fan];
      if (fan == kNone) return std::nullopt;
    } while (fan != first);
    return loop;
  }

  /// The loop as it is kept, and its measures.
  void finish(BoundaryLoop& loop) const {
    std::reverse(loop.vertices.begin(), loop.vertices.end());
    std::sort(loop.components.begin(), loop.components.end());
    loop.components.erase(std::unique(loop.components.begin(), loop.components.end()),
                          loop.components.end());
    loop.components.shrink_to_fit();
    measure_loop(vertices_, loop, stop_);
  }

  std::vector<OpenFan> fans_;  // by vertex, previous
  std::span<const BoundaryVertex> vertices_;
  const StopToken* stop_;
  std::vector<std::uint32_t> after_;
  std::vector<std::uint32_t> next_;
};

}  // namespace

std::vector<BoundaryLoop> trace_loops(std::vector<OpenFan> fans,
                                      std::span<const BoundaryVertex> vertices,
                                      const StopToken* stop) {
  return LoopTracer(std::move(fans), vertices, stop).trace();
}

void measure_loop(std::span<const BoundaryVertex> vertices, BoundaryLoop& loop,
                  const StopToken* stop) {
  rotate_to_least(loop.vertices, stop);
  std::vector<Vec3> at;
  for (const std::uint64_t vertex : loop.vertices) at.push_back(find(vertices, vertex).position);
  // Sums of differences to one vertex: coordinates may be large.
  Vec3 sum;
  for (const Vec3 p : at) sum = sum + (p - at.front());
  loop.center = at.front() + sum / static_cast<double>(at.size());
  loop.perimeter = loop.radius = 0.0;
  loop.area_vector = loop.mean_normal = {};
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Vec3 a = at[i], b = at[(i + 1) % at.size()];
    loop.perimeter += norm(b - a);
    loop.radius = std::max(loop.radius, norm(a - loop.center));
    loop.area_vector = loop.area_vector + 0.5 * cross(a - loop.center, b - loop.center);
    loop.mean_normal = loop.mean_normal + normalized(find(vertices, loop.vertices[i]).normal);
  }
  loop.mean_normal = loop.mean_normal / static_cast<double>(at.size());
}

}  // namespace orbweave
