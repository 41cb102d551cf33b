#include "engine/voronoi/power_crust.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <tuple>
#include <utility>

#include "engine/voronoi/poles.h"
#include "io/box.h"
#include "io/vec3_order.h"

namespace orbweave::voronoi {
namespace {

/// The poles of all points as tetrahedra.
struct PoleChoice {
  std::vector<std::uint32_t> first, second;
};

/// The radius of a Voronoi cell across its normal: of its corners within an eighth of a turn of the
/// tangent plane, the largest distance.
double width_of_cell(std::uint32_t p, std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                     const Stars& stars, Vec3 normal) {
  double width = 0.0;
  for (const std::uint32_t cell : stars.of(p)) {
    if (!tetrahedra.is_finite(cell)) continue;
    const Vec3 offset = tetrahedra.centers[cell] - points[p];
    const double along = std::abs(dot(offset, normal));
    if (along > std::numbers::sqrt2 / 2.0 * tetrahedra.radii[cell]) continue;
    width = std::max(width, std::sqrt(std::max(0.0, squared_norm(offset) - along * along)));
  }
  return width;
}

PoleChoice choose_poles(std::span<const Vec3> bounded, std::size_t samples,
                        const Tetrahedra& tetrahedra, const PowerCrustOptions& options,
                        const StopToken* stop) {
  const Stars stars = stars_of(tetrahedra, bounded.size());
  Poles poles = find_poles(bounded, tetrahedra, stop);
  const double least_height = (1.0 - options.sampling_constant) / options.sampling_constant;
  const auto usable = [&](std::uint32_t cell) {
    return cell != kNone && tetrahedra.is_finite(cell) && is_finite(tetrahedra.centers[cell]);
  };
  for (std::uint32_t p = 0; p < samples; ++p) {
    if (!usable(poles.first[p])) poles.first[p] = kNone;
    std::uint32_t& second = poles.second[p];
    if (!usable(second)) second = kNone;
    if (second == kNone) continue;
    const double width = width_of_cell(p, bounded, tetrahedra, stars, poles.normals[p]);
    if (tetrahedra.radii[second] < least_height * width) second = kNone;
  }
  poles.first.resize(samples);
  poles.second.resize(samples);
  return {std::move(poles.first), std::move(poles.second)};
}

/// A tetrahedron of a polar ball.
struct PolarCell {
  std::uint32_t cell = 0;
  std::uint32_t ball = 0;
};

/// The tetrahedra of the poles, each once, in the order of the first points that have them, which
/// is that of the points: balls that lie near each other have near numbers.
std::vector<PolarCell> cells_in_use(const PoleChoice& poles, std::size_t tetrahedra) {
  std::vector<PolarCell> cells;
  std::vector<std::uint8_t> is_known(tetrahedra, 0);
  for (std::size_t p = 0; p < poles.first.size(); ++p) {
    for (const std::uint32_t cell : {poles.first[p], poles.second[p]}) {
      if (cell == kNone || is_known[cell] != 0) continue;
      is_known[cell] = 1;
      cells.push_back({cell, static_cast<std::uint32_t>(cells.size())});
    }
  }
  return cells;
}

/// Numbers the balls, one for each centre, and brings their tetrahedra together.
std::vector<PolarCell> cells_of_balls(const PoleChoice& poles, const Tetrahedra& tetrahedra) {
  std::vector<PolarCell> cells = cells_in_use(poles, tetrahedra.size());
  const auto center = [&](const PolarCell& cell) -> Vec3 { return tetrahedra.centers[cell.cell]; };
  std::vector<PolarCell> by_center = cells;
  std::sort(by_center.begin(), by_center.end(), [&](const PolarCell& a, const PolarCell& b) {
    const Vec3 p = center(a), q = center(b);
    return std::tie(p.x, p.y, p.z, a.ball) < std::tie(q.x, q.y, q.z, b.ball);
  });
  for (std::size_t i = 1; i < by_center.size(); ++i)
    if (center(by_center[i]) == center(by_center[i - 1])) by_center[i].ball = by_center[i - 1].ball;
  std::sort(by_center.begin(), by_center.end(), [](const PolarCell& a, const PolarCell& b) {
    return std::tie(a.ball, a.cell) < std::tie(b.ball, b.cell);
  });
  return by_center;
}

/// Sorts what the last ball touches, each point once.
void end_ball(PolarBalls& balls) {
  if (balls.balls.empty()) return;
  const auto begin =
      balls.touched.begin() + static_cast<std::ptrdiff_t>(balls.touched_begin.back());
  std::sort(begin, balls.touched.end());
  balls.touched.erase(std::unique(begin, balls.touched.end()), balls.touched.end());
  balls.touched_begin.push_back(static_cast<std::uint32_t>(balls.touched.size()));
}

/// Collects the balls and what they touch; returns the balls of tetrahedra, for those that have
/// one.
std::vector<std::uint32_t> collect_balls(const PoleChoice& poles, const Tetrahedra& tetrahedra,
                                         PolarBalls& balls) {
  const std::size_t samples = poles.first.size();
  std::vector<std::uint32_t> ball_of(tetrahedra.size(), kNone);
  std::uint32_t last = kNone;
  for (const auto& [cell, ball_key] : cells_of_balls(poles, tetrahedra)) {
    if (balls.balls.empty() || ball_key != last) {
      end_ball(balls);
      balls.balls.push_back({tetrahedra.centers[cell], 0.0});
      balls.outer.push_back(0);
      last = ball_key;
    }
    MedialBall& ball = balls.balls.back();
    ball.radius = std::max(ball.radius, tetrahedra.radii[cell]);
    for (const std::uint32_t v : tetrahedra.vertices[cell]) {
      if (v >= samples)
        balls.outer.back() = 1;
      else
        balls.touched.push_back(v);
    }
    ball_of[cell] = static_cast<std::uint32_t>(balls.balls.size() - 1);
  }
  end_ball(balls);
  return ball_of;
}

/// How much speaks for either label, from 0 to 1.
struct Belief {
  double in = 0.0;
  double out = 0.0;

  /// One voice alone comes first, the stronger the earlier; then silence; then dispute.
  double priority() const {
    if (in > 0.0 && out > 0.0) return std::abs(in - out) - 1.0;
    return std::max(in, out);
  }
};

/// Amenta, Choi, Kolluri 2001, section 5: labels balls in the order of their priority.
class Labeling {
 public:
  Labeling(const PolarBalls& balls, const Tetrahedra& power, std::span<const std::uint8_t> outer)
      : balls_(balls),
        power_(power),
        stars_(stars_of(power, outer.size())),
        beliefs_(outer.size()),
        is_labeled_(outer.size(), 0),
        seen_by_(outer.size(), kNone) {
    find_opposite();
    for (std::uint32_t b = 0; b < outer.size(); ++b) {
      if (outer[b] != 0) beliefs_[b].out = 1.0;
      push(b);
    }
    inner_.assign(outer.size(), 0);
    for (std::uint32_t b = 0; b < outer.size(); ++b) fixed_.push_back(outer[b]);
  }

  std::vector<std::uint8_t> run(const StopToken* stop) {
    for (std::size_t n = 0; !queue_.empty(); ++n) {
      if (n % kStopBlock == 0) check_stop(stop);
      const auto [priority, reversed] = queue_.top();
      queue_.pop();
      const std::uint32_t ball = ~reversed;
      if (is_labeled_[ball] != 0 || priority != beliefs_[ball].priority()) continue;
      label(ball);
    }
    return std::move(inner_);
  }

 private:
  /// The other pole of a point, with the cosine of the angle at the point.
  struct Opposite {
    std::uint32_t ball = 0, other = 0;
    double weight = 0.0;
  };

  void find_opposite() {
    for (std::size_t p = 0; p < balls_.first.size(); ++p) {
      const std::uint32_t a = balls_.first[p], b = balls_.second[p];
      if (a == kNone || b == kNone || a == b) continue;
      const double weight = balls_.opposite_weight[p];
      opposite_.push_back({a, b, weight});
      opposite_.push_back({b, a, weight});
    }
    std::sort(opposite_.begin(), opposite_.end(), [](const Opposite& a, const Opposite& b) {
      return std::tie(a.ball, a.other, a.weight) < std::tie(b.ball, b.other, b.weight);
    });
  }

  void push(std::uint32_t ball) {
    // Of equals the first ball comes first.
    queue_.emplace(beliefs_[ball].priority(), ~ball);
  }

  void raise(double& belief, double to, std::uint32_t ball) {
    if (is_labeled_[ball] != 0 || to <= belief) return;
    belief = to;
    push(ball);
  }

  void label(std::uint32_t ball) {
    is_labeled_[ball] = 1;
    const Belief belief = beliefs_[ball];
    const bool is_inner = fixed_[ball] == 0 && belief.in > belief.out;
    inner_[ball] = is_inner ? 1 : 0;
    const double strength = is_inner ? belief.in : belief.out;
    auto opposite =
        std::lower_bound(opposite_.begin(), opposite_.end(), ball,
                         [](const Opposite& o, std::uint32_t number) { return o.ball < number; });
    for (; opposite != opposite_.end() && opposite->ball == ball; ++opposite) {
      Belief& other = beliefs_[opposite->other];
      raise(is_inner ? other.out : other.in, strength * opposite->weight, opposite->other);
    }
    // The tetrahedra lie all over the memory, but can all be on their way at once.
    for (const std::uint32_t cell : stars_.of(ball)) __builtin_prefetch(&power_.vertices[cell]);
    for (const std::uint32_t cell : stars_.of(ball)) {
      for (const std::uint32_t near : power_.vertices[cell]) {
        if (near == kInfinite || is_labeled_[near] != 0 || seen_by_[near] == ball) continue;
        seen_by_[near] = ball;
        Belief& other = beliefs_[near];
        raise(is_inner ? other.in : other.out, strength * depth(ball, near), near);
      }
    }
  }

  /// The cosine of the angle between the radii where two balls meet: 1 for equal balls, 0 and less
  /// for balls that meet at a right angle or hardly.
  double depth(std::uint32_t a, std::uint32_t b) const {
    const MedialBall &p = balls_.balls[a], &q = balls_.balls[b];
    const double squares = p.radius * p.radius + q.radius * q.radius;
    const double cosine =
        (squares - squared_norm(p.center - q.center)) / (2.0 * p.radius * q.radius);
    return std::clamp(cosine, 0.0, 1.0);
  }

  const PolarBalls& balls_;
  const Tetrahedra& power_;
  Stars stars_;
  std::vector<Belief> beliefs_;
  std::vector<std::uint8_t> is_labeled_;
  std::vector<std::uint32_t> seen_by_;  // the last ball that looked at it
  std::vector<std::uint8_t> inner_;
  std::vector<std::uint8_t> fixed_;
  std::vector<Opposite> opposite_;
  std::priority_queue<std::pair<double, std::uint32_t>> queue_;
};

}  // namespace

std::vector<Vec3> PolarBalls::centers() const {
  std::vector<Vec3> all;
  for (const MedialBall& ball : balls) all.push_back(ball.center);
  return all;
}

std::vector<double> PolarBalls::weights() const {
  std::vector<double> all;
  for (const MedialBall& ball : balls) all.push_back(ball.radius * ball.radius);
  return all;
}

std::vector<Vec3> bounded_points(std::span<const Vec3> points, const PowerCrustOptions& options) {
  Box box;
  for (const Vec3 p : points) box.extend(p);
  std::vector<Vec3> bounded(points.begin(), points.end());
  if (points.empty()) return bounded;
  const Vec3 center = 0.5 * (box.min + box.max);
  // A cube: a flat cloud is to be bounded above and below as well.
  const double reach = 0.5 * options.bounding_factor * box.largest_extent();
  for (int corner = 0; corner < 8; ++corner)
    bounded.push_back(center + Vec3{(corner & 1) != 0 ? reach : -reach,
                                    (corner & 2) != 0 ? reach : -reach,
                                    (corner & 4) != 0 ? reach : -reach});
  return bounded;
}

PolarBalls polar_balls(std::span<const Vec3> bounded, const Tetrahedra& tetrahedra,
                       const PowerCrustOptions& options, const StopToken* stop) {
  const std::size_t samples = bounded.size() - 8;
  const PoleChoice poles = choose_poles(bounded, samples, tetrahedra, options, stop);
  PolarBalls result;
  const std::vector<std::uint32_t> ball_of = collect_balls(poles, tetrahedra, result);
  for (std::size_t p = 0; p < samples; ++p) {
    const std::uint32_t a = poles.first[p], b = poles.second[p];
    result.first.push_back(a == kNone ? kNone : ball_of[a]);
    result.second.push_back(b == kNone ? kNone : ball_of[b]);
    const Vec3 u = a == kNone ? Vec3{} : tetrahedra.centers[a] - bounded[p];
    const Vec3 v = b == kNone ? Vec3{} : tetrahedra.centers[b] - bounded[p];
    result.opposite_weight.push_back(std::max(0.0, -dot(normalized(u), normalized(v))));
  }
  return result;
}

PowerCrustSurface power_crust_surface(std::span<const Vec3> points, const PolarBalls& balls,
                                      const Tetrahedra& power, const StopToken* stop) {
  // The cells at infinity are outside: an unbounded face has no corners.
  std::vector<std::uint8_t> outer = balls.outer;
  for (std::uint32_t c = 0; c < power.size(); ++c)
    if (!power.is_finite(c))
      for (const std::uint32_t ball : power.vertices[c])
        if (ball != kInfinite) outer[ball] = 1;
  const std::vector<std::uint8_t> inner = Labeling(balls, power, outer).run(stop);
  PowerCrustSurface surface = faces_between(points, balls, power, inner, stop);
  for (std::size_t b = 0; b < inner.size(); ++b)
    if (inner[b] != 0) surface.medial_axis.push_back(balls.balls[b]);
  std::sort(
      surface.medial_axis.begin(), surface.medial_axis.end(),
      [](const MedialBall& a, const MedialBall& b) { return comes_before(a.center, b.center); });
  return surface;
}

}  // namespace orbweave::voronoi
