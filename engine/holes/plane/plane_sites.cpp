#include "engine/holes/plane/plane_sites.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <unordered_map>

#include "engine/holes/rbf/rbf_centers.h"

namespace orbweave {
namespace {

// Two places steeper above one another than this are not on one height field: the slope of the
// steepest faces allowed, and some more for what lies between.
constexpr double kMostSlope = 5.0;

// Beyond this many spacings from the rim, sites at a distance d lie about as far apart as d says.
// On discs cut from scans, patches are as close to what was there as with all sites, which are
// ten times as many at radii of 16 spacings.
constexpr double kFullDensity = 1.0;

// Triangles of the sheet at each vertex.
class Fans {
 public:
  explicit Fans(const HoleProblem& problem) : first_(problem.positions.size() + 1, 0) {
    for (const Triangle& t : problem.sheet) {
      for (const std::uint32_t v : t) ++first_[v + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    items_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < problem.sheet.size(); ++i) {
      for (const std::uint32_t v : problem.sheet[i]) items_[next[v]++] = i;
    }
  }
  std::span<const std::uint32_t> at(std::uint32_t v) const {
    return std::span(items_).subspan(first_[v], first_[v + 1] - first_[v]);
  }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> items_;
};

// Sites by cells of the plane, to find those near a place.
class PlaneCells {
 public:
  explicit PlaneCells(double size) : size_(size) {}

  // Calls visit(site) for those in the cells around x; for all where they are few.
  template <class Visit>
  void for_each_near(Vec3 x, const Visit& visit) const {
    if (sorted_.empty()) {
      for (std::uint32_t i = 0; i < count_; ++i) visit(i);
      return;
    }
    const std::int64_t row = cell(x.y);
    for (int dx = -1; dx <= 1; ++dx) {
      const Entry key{cell(x.x) + dx, row - 1, 0};
      for (auto e = std::lower_bound(sorted_.begin(), sorted_.end(), key);
           e != sorted_.end() && e->x == key.x && e->y <= row + 1; ++e) {
        visit(e->site);
      }
    }
  }

  // All places, of which those before `first` were added before.
  void add(std::span<const Vec3> places, std::uint32_t first) {
    count_ = static_cast<std::uint32_t>(places.size());
    if (count_ <= kFew) return;
    if (sorted_.empty()) first = 0;
    const auto middle = static_cast<std::ptrdiff_t>(sorted_.size());
    for (std::uint32_t i = first; i < places.size(); ++i) {
      sorted_.push_back({cell(places[i].x), cell(places[i].y), i});
    }
    std::sort(sorted_.begin() + middle, sorted_.end());
    std::inplace_merge(sorted_.begin(), sorted_.begin() + middle, sorted_.end());
  }

 private:
  static constexpr std::uint32_t kFew = 64;  // are looked at one by one

  struct Entry {
    std::int64_t x = 0;
    std::int64_t y = 0;
    std::uint32_t site = 0;
    friend auto operator<=>(const Entry&, const Entry&) = default;
  };
  // Places are within a few hundred million cells of the origin: llround cannot overflow.
  std::int64_t cell(double x) const {
    return static_cast<std::int64_t>(std::floor(std::clamp(x / size_, -1e15, 1e15)));
  }

  double size_;
  std::uint32_t count_ = 0;
  std::vector<Entry> sorted_;  // empty where the sites are few
};

// Places kept so far, in nested cells, to ask whether one lies within any distance of another.
class NestedCells {
 public:
  explicit NestedCells(double size) : size_(size) {}

  bool has_within(Vec3 x, double distance) {
    if (places_.size() <= kFew) return is_any_within(places_, x, distance);
    std::size_t level = 0;
    while (level + 1 < kMostLevels && size_of(level) < distance) ++level;
    while (levels_.size() <= level) add_level();
    const std::int64_t column = cell(x.x, level), row = cell(x.y, level);
    const auto reach = static_cast<std::int64_t>(std::ceil(distance / size_of(level)));
    for (std::int64_t i = column - reach; i <= column + reach; ++i) {
      for (std::int64_t k = row - reach; k <= row + reach; ++k) {
        const auto at = levels_[level].find(key(i, k));
        if (at == levels_[level].end()) continue;
        if (is_any_within(at->second, x, distance)) return true;
      }
    }
    return false;
  }

  void add(Vec3 x) {
    places_.push_back(x);
    for (std::size_t level = 0; level < levels_.size(); ++level) put(x, level);
  }

 private:
  using Cells = std::unordered_map<std::uint64_t, std::vector<Vec3>>;
  static constexpr std::size_t kMostLevels = 24;
  static constexpr std::size_t kFew = 256;  // are looked at one by one

  static bool is_any_within(const std::vector<Vec3>& places, Vec3 x, double distance) {
    // What is near was added last, more often than not.
    return std::any_of(places.rbegin(), places.rend(), [&](Vec3 other) {
      const double dx = x.x - other.x;
      const double dy = x.y - other.y;
      return dx * dx + dy * dy < distance * distance;
    });
  }

  double size_of(std::size_t level) const { return std::ldexp(size_, static_cast<int>(level)); }
  std::int64_t cell(double x, std::size_t level) const {
    return static_cast<std::int64_t>(std::floor(std::clamp(x / size_of(level), -1e15, 1e15)));
  }
  // Cells that share a key cost time alone.
  static std::uint64_t key(std::int64_t i, std::int64_t k) {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;
    return static_cast<std::uint64_t>(i) * kGolden + static_cast<std::uint64_t>(k);
  }
  void put(Vec3 x, std::size_t level) {
    levels_[level][key(cell(x.x, level), cell(x.y, level))].push_back(x);
  }
  void add_level() {
    levels_.emplace_back();
    for (const Vec3 x : places_) put(x, levels_.size() - 1);
  }

  double size_;
  std::vector<Vec3> places_;
  std::vector<Cells> levels_;
};

bool is_above(Vec3 a, Vec3 b, double spacing) {
  const double dx = a.x - b.x;
  const double dy = a.y - b.y;
  const double squared = dx * dx + dy * dy;
  return squared < spacing * spacing && std::abs(a.z - b.z) > kMostSlope * std::sqrt(squared);
}

class Gathering {
 public:
  Gathering(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
            const PlaneOutline& outline)
      : problem_(problem),
        rim_(rim),
        frame_(frame),
        outline_(outline),
        fans_(problem),
        reached_(problem.positions.size(), 0),
        nearest_(problem.positions.size(), 0),
        upright_(problem.sheet.size(), Upright::kUnknown),
        places_(problem.positions.size()),
        cells_(rim.spacing) {
    for (std::size_t v = 0; v < places_.size(); ++v)
      places_[v] = frame.to_frame(problem.positions[v] - rim.center);
  }

  PlaneSites gather() {
    std::vector<std::uint32_t> ring(problem_.loop);
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    for (const std::uint32_t v : ring) {
      reached_[v] = 1;
      nearest_[v] = v;
      take(v);
    }
    sites_.rim = static_cast<std::uint32_t>(ring.size());
    cells_.add(sites_.places, 0);
    while (!ring.empty()) {
      const auto first = static_cast<std::uint32_t>(sites_.vertices.size());
      ring = next_ring(ring);
      cells_.add(sites_.places, first);
    }
    return thinned();
  }

 private:
  enum class Upright : std::uint8_t { kUnknown, kYes, kNo };

  Vec3 place(std::uint32_t v) const { return places_[v]; }

  void take(std::uint32_t v) {
    sites_.vertices.push_back(v);
    sites_.places.push_back(place(v));
  }

  // Each face is asked for at each of its corners.
  bool is_upright(std::uint32_t face) {
    Upright& known = upright_[face];
    if (known == Upright::kUnknown)
      known = is_upright(problem_.sheet[face]) ? Upright::kYes : Upright::kNo;
    return known == Upright::kYes;
  }

  bool is_upright(const Triangle& t) const {
    const Vec3 a = problem_.positions[t[0]];
    const Vec3 area = cross(problem_.positions[t[1]] - a, problem_.positions[t[2]] - a);
    return dot(area, frame_.axis) >= kLeastUpright * norm(area);
  }

  // Vertices beyond the ring over upright faces; those that do not fit in are no sites, and
  // nothing is reached through them.
  std::vector<std::uint32_t> next_ring(const std::vector<std::uint32_t>& ring) {
    std::vector<std::uint32_t> beyond;
    for (const std::uint32_t v : ring) {
      for (const std::uint32_t face : fans_.at(v)) {
        const Triangle& t = problem_.sheet[face];
        if (!is_upright(face)) continue;
        for (const std::uint32_t w : t) {
          if (reached_[w] == 0) beyond.push_back(w);
          if (reached_[w] == 0 ||
              (nearest_[v] != nearest_[w] &&
               squared_from_rim(w, nearest_[v]) < squared_from_rim(w, nearest_[w]))) {
            nearest_[w] = nearest_[v];
          }
          reached_[w] = 1;
        }
      }
    }
    std::sort(beyond.begin(), beyond.end());
    std::erase_if(beyond, [this](std::uint32_t v) { return !fits(v); });
    for (const std::uint32_t v : beyond) take(v);
    return beyond;
  }

  // Against the sites of the rings before; those of one ring are too few to search for.
  bool fits(std::uint32_t v) const {
    const Vec3 normal = problem_.normals[v];
    if (normal != Vec3{} && dot(normal, frame_.axis) < kLeastUpright) return false;
    const Vec3 x = place(v);
    if (outline_.contains(x)) return false;
    bool free = true;
    cells_.for_each_near(x, [&](std::uint32_t other) {
      if (is_above(x, sites_.places[other], rim_.spacing)) free = false;
    });
    return free;
  }

  // In the plane.
  double squared_from_rim(std::uint32_t v, std::uint32_t rim_vertex) const {
    const Vec3 d = place(v) - place(rim_vertex);
    return d.x * d.x + d.y * d.y;
  }

  PlaneSites thinned() const {
    PlaneSites kept;
    kept.rim = sites_.rim;
    NestedCells cells(rim_.spacing);
    for (std::size_t i = 0; i < sites_.places.size(); ++i) {
      const std::uint32_t v = sites_.vertices[i];
      const double apart =
          std::sqrt(squared_from_rim(v, nearest_[v])) - kFullDensity * rim_.spacing;
      const Vec3 x = sites_.places[i];
      if (apart > 0.0 && cells.has_within(x, apart)) continue;
      cells.add(x);
      kept.vertices.push_back(v);
      kept.places.push_back(x);
    }
    return kept;
  }

  const HoleProblem& problem_;
  const Rim& rim_;
  const HoleFrame& frame_;
  const PlaneOutline& outline_;
  Fans fans_;
  std::vector<std::uint8_t> reached_;   // from a ring; those refused then stay so
  std::vector<std::uint32_t> nearest_;  // rim vertex, about
  std::vector<Upright> upright_;        // per face
  std::vector<Vec3> places_;            // of all vertices, in the frame
  PlaneCells cells_;
  PlaneSites sites_;
};

}  // namespace

PlaneSites plane_sites(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
                       const PlaneOutline& outline) {
  return Gathering(problem, rim, frame, outline).gather();
}

std::vector<Vec3> mean_places(const std::vector<Vec3>& places, std::uint32_t most) {
  std::vector<Vec3> flat = places;
  for (Vec3& place : flat) place.z = 0.0;
  std::vector<std::uint32_t> centers;
  FarthestPoints spread(flat, {});
  while (centers.size() < most) {
    const auto next = spread.next();
    if (!next) break;
    centers.push_back(*next);
  }
  std::vector<Vec3> sums(centers.size());
  std::vector<double> counts(centers.size(), 0.0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::size_t best = 0;
    for (std::size_t c = 1; c < centers.size(); ++c) {
      if (squared_norm(flat[i] - flat[centers[c]]) < squared_norm(flat[i] - flat[centers[best]])) {
        best = c;
      }
    }
    sums[best] = sums[best] + places[i];
    counts[best] += 1.0;
  }
  for (std::size_t c = 0; c < sums.size(); ++c) sums[c] = sums[c] / counts[c];
  return sums;
}

}  // namespace orbweave
