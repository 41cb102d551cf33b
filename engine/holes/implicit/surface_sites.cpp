#include "engine/holes/implicit/surface_sites.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "engine/holes/patch/box_tree.h"

namespace orbweave {
namespace {

/// Least distance of points from one another, in rim spacings: nearer ones make the system as good
/// as singular.
constexpr double kLeastGap = 0.02;

/// A vertex that may become a site.
struct Candidate {
  double from_rim = 0.0;  ///< distance to the nearest corner
  std::uint32_t vertex = 0;
  Vec3 position;  ///< relative to the rim's centre
};

/// Of several least distances at once, so that none waits for the one before.
double nearest_of(Vec3 p, std::span<const Vec3> corners) {
  std::array<double, 4> least;
  least.fill(std::numeric_limits<double>::infinity());
  std::size_t i = 0;
  for (; i + least.size() <= corners.size(); i += least.size())
    for (std::size_t k = 0; k < least.size(); ++k)
      least[k] = std::min(least[k], squared_norm(p - corners[i + k]));
  for (; i < corners.size(); ++i) least[0] = std::min(least[0], squared_norm(p - corners[i]));
  return std::min(std::min(least[0], least[1]), std::min(least[2], least[3]));
}

/// The corners of a rim in runs that lie together, for nearest ones of many places.
class CornerRuns {
 public:
  explicit CornerRuns(std::span<const Vec3> corners) : corners_(corners) {
    for (std::size_t first = 0; first < corners.size(); first += kRun) {
      Box& box = boxes_.emplace_back();
      for (const Vec3 corner : run(first / kRun)) box.extend(corner);
    }
  }

  /// The squared distance to the nearest corner. Places near one another are best asked for in
  /// turn.
  double nearest_squared(Vec3 p) {
    double least = nearest_of(p, run(last_));
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      if (i == last_ || !(squared_distance(p, boxes_[i]) < least)) continue;
      const double here = nearest_of(p, run(i));
      if (!(here < least)) continue;
      least = here;
      last_ = i;
    }
    return least;
  }

 private:
  static constexpr std::size_t kRun = 16;

  std::span<const Vec3> run(std::size_t i) const {
    return corners_.subspan(i * kRun, std::min(kRun, corners_.size() - i * kRun));
  }

  /// No more than the squared distance of any corner in the box, rounded as that is.
  static double squared_distance(Vec3 p, const Box& box) {
    Vec3 apart;
    for (int axis = 0; axis < 3; ++axis)
      apart[axis] = std::max({0.0, box.min[axis] - p[axis], p[axis] - box.max[axis]});
    return squared_norm(apart);
  }

  std::span<const Vec3> corners_;
  std::vector<Box> boxes_;
  std::size_t last_ = 0;  // the run that was nearest
};

std::vector<Candidate> candidates_by_distance(const HoleProblem& problem, const Rim& rim) {
  std::vector<Candidate> candidates;
  CornerRuns corners(rim.corners);
  for (std::uint32_t v = 0; v < problem.positions.size(); ++v) {
    if (!(squared_norm(problem.normals[v]) > 0.0)) continue;
    const Vec3 p = problem.positions[v] - rim.center;
    candidates.push_back({std::sqrt(corners.nearest_squared(p)), v, p});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.from_rim != b.from_rim ? a.from_rim < b.from_rim : a.vertex < b.vertex;
  });
  return candidates;
}

/// Greedy: a candidate is kept when no kept one is nearer than `scale` times the spacing wished
/// for at its distance from the rim. Ends when more than `most` are kept.
std::vector<Candidate> thin(std::span<const Candidate> candidates, double scale, double spacing,
                            std::size_t most) {
  constexpr double kGrowth = 0.5;  // of the spacing, per distance from the rim
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    const double apart =
        std::max(kLeastGap * spacing, scale * (spacing + kGrowth * candidate.from_rim));
    // What is near was kept last, more often than not.
    const bool clear = std::none_of(kept.rbegin(), kept.rend(), [&](const Candidate& other) {
      return squared_norm(candidate.position - other.position) < apart * apart;
    });
    if (!clear) continue;
    kept.push_back(candidate);
    if (kept.size() > most) break;
  }
  return kept;
}

/// The vertices by their first coordinates, to find those near one of them.
class VerticesByX {
 public:
  explicit VerticesByX(std::span<const Vec3> positions)
      : positions_(positions.begin(), positions.end()) {
    std::sort(positions_.begin(), positions_.end(), [](Vec3 a, Vec3 b) { return a.x < b.x; });
  }

  /// Those that may be nearer than the vertex at p to a point at most `offset` off it, relative to
  /// it; in no order.
  std::vector<Vec3> near(Vec3 p, double offset) const {
    constexpr double kReach = 2.001;  // offsets
    constexpr double kSlack = 2.002;  // rounding does not decide who is looked at
    const auto is_left = [](Vec3 q, double x) { return q.x < x; };
    auto at =
        std::lower_bound(positions_.begin(), positions_.end(), p.x - kSlack * offset, is_left);
    std::vector<Vec3> near;
    for (; at != positions_.end() && at->x <= p.x + kSlack * offset; ++at) {
      if (std::abs(at->y - p.y) > kSlack * offset) continue;
      const Vec3 d = *at - p;
      if (*at != p && squared_norm(d) < kReach * kReach * offset * offset) near.push_back(d);
    }
    return near;
  }

 private:
  std::vector<Vec3> positions_;
};

/// The largest fraction of `offset`, halved so often, at which the vertex is the nearest of all to
/// the point off it; 0 where there is none.
double clear_offset(const std::vector<Vec3>& near, Vec3 normal, double offset) {
  constexpr int kHalvings = 4;
  for (int i = 0; i < kHalvings; ++i, offset *= 0.5) {
    const Vec3 off = offset * normal;
    const bool own = std::all_of(near.begin(), near.end(),
                                 [&](Vec3 d) { return squared_norm(d - off) > squared_norm(off); });
    if (own) return offset;
  }
  return 0.0;
}

bool is_clear(std::span<const RbfSite> points, Vec3 place, double gap) {
  return std::all_of(points.begin(), points.end(),
                     [&](Vec3 other) { return squared_norm(other - place) > gap * gap; });
}

}  // namespace

std::vector<std::uint32_t> choose_sites(const HoleProblem& problem, const Rim& rim,
                                        std::uint32_t most) {
  const std::vector<Candidate> all = candidates_by_distance(problem, rim);
  constexpr int kSteps = 6;
  double few = 0.0, many = 0.0;  // scales that leave few enough sites and too many
  std::vector<Candidate> kept;
  while ((kept = thin(all, few, rim.spacing, most)).size() > most) {
    many = few;
    few = few == 0.0 ? 1.0 : 2.0 * few;
  }
  for (int step = 0; step < kSteps && few > 0.0; ++step) {
    const double middle = 0.5 * (few + many);
    std::vector<Candidate> closer = thin(all, middle, rim.spacing, most);
    const bool fits = closer.size() <= most;
    (fits ? few : many) = middle;
    if (fits) kept = std::move(closer);
  }
  std::vector<std::uint32_t> sites;
  for (const Candidate& candidate : kept) sites.push_back(candidate.vertex);
  return sites;
}

SignedDistances signed_distances(const HoleProblem& problem, const Rim& rim,
                                 const std::vector<std::uint32_t>& sites) {
  SignedDistances distances;
  const VerticesByX vertices(problem.positions);
  for (const std::uint32_t v : sites) {
    distances.points.push_back(problem.positions[v] - rim.center);
    distances.values.push_back(0.0);
  }
  // Alternately to either side: as good as to both, and a third less to solve for.
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const Vec3 normal = problem.normals[sites[i]];
    const double first = i % 2 == 0 ? 1.0 : -1.0;
    const std::vector<Vec3> near = vertices.near(problem.positions[sites[i]], rim.spacing);
    for (const double side : {first, -first}) {
      const double offset = clear_offset(near, side * normal, rim.spacing);
      const Vec3 place = distances.points[i] + side * offset * normal;
      if (offset == 0.0 || !is_clear(distances.points, place, kLeastGap * rim.spacing)) continue;
      distances.points.push_back(place);
      distances.values.push_back(side * offset);
      break;
    }
  }
  return distances;
}

}  // namespace orbweave
