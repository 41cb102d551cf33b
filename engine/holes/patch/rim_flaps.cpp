#include "engine/holes/patch/rim_flaps.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "engine/holes/triangulation/loop_chords.h"
#include "engine/holes/triangulation/loop_triangulation.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// A triangle that runs along the boundary from a to b.
struct Flap {
  Triangle64 triangle{};
  std::uint64_t a = 0, b = 0, c = 0;
};

/// Of the triangles at a, the one that runs from there to b.
std::optional<Flap> find_flap(std::span<const Triangle64> at_a, std::uint64_t a, std::uint64_t b) {
  for (const Triangle64& t : at_a)
    for (int k = 0; k < 3; ++k)
      if (t[k] == a && t[(k + 1) % 3] == b) return Flap{t, a, b, t[(k + 2) % 3]};
  return {};
}

/// A surface and what has been taken out of it.
class TrimmedSurface {
 public:
  explicit TrimmedSurface(const Surface& surface) : surface_(surface) {}

  Vec3 position(std::uint64_t vertex) const { return surface_.position(vertex); }

  /// Triangles at a vertex; valid until the next call.
  std::span<const Triangle64> around(std::uint64_t vertex) {
    around_.clear();
    surface_.triangles_at(vertex, around_);
    drop_taken(around_);
    return around_;
  }

  /// Twice the area vector.
  Vec3 area_of(const Triangle64& t) const {
    const Vec3 a = position(t[0]);
    return cross(position(t[1]) - a, position(t[2]) - a);
  }

  /// Whether the triangles around the flap's corner c, one after the other, come back to the flap.
  bool is_closed_at_c(const Flap& flap) {
    const std::span<const Triangle64> fan = around(flap.c);
    std::uint64_t edge = flap.a;  // the flap runs from c to there, the next one from there to c
    for (std::size_t i = 0; i < fan.size() && edge != flap.b; ++i) {
      const std::uint64_t before = edge;
      for (const Triangle64& t : fan)
        for (int k = 0; k < 3; ++k)
          if (t[k] == before && t[(k + 1) % 3] == flap.c) edge = t[(k + 2) % 3];
      if (edge == before) return false;
    }
    return edge == flap.b;
  }

  void take(const Triangle64& t) { taken_.insert(t); }
  void put_back(const Triangle64& t) { taken_.erase(t); }
  const std::set<Triangle64>& taken() const { return taken_; }

 private:
  void drop_taken(std::vector<Triangle64>& triangles) const {
    if (!taken_.empty())
      std::erase_if(triangles, [&](const Triangle64& t) { return taken_.contains(t); });
  }

  const Surface& surface_;
  std::set<Triangle64> taken_;
  std::vector<Triangle64> around_;
};

/// A flap that goes.
struct Cut {
  Flap flap;
  bool is_ear = false;  ///< the edge from b to c is on the boundary, too
};

/// One loop while its flaps are found.
class LoopTrimmer {
 public:
  LoopTrimmer(const Surface& surface, TrimmedSurface& trimmed)
      : surface_(surface), trimmed_(trimmed) {}

  /// Whether the triangulation of the loop's corners folds, over more than may be.
  bool folds(const std::vector<std::uint64_t>& loop) {
    loop_ = loop;
    if (touches_itself()) return false;
    const Folds found = find_folds();
    return found.folded > kMostFolded * found.area;
  }

  /// The flaps, taken out of the trimmed surface and off the loop; none where the loop does not
  /// fold, or not less without them.
  std::vector<Cut> trim(std::vector<std::uint64_t>& loop) {
    constexpr double kMostLeft = 0.5;  // of what was folded
    constexpr int kRounds = 3;
    loop_ = loop;
    cuts_.clear();
    if (touches_itself()) return {};
    const Folds before = find_folds();
    if (!(before.folded > kMostFolded * before.area)) return {};
    Folds now = before;
    for (int round = 0; round < kRounds && now.folded > kMostFolded * now.area; ++round) {
      if (!cut_flaps(now)) break;
      now = find_folds();
    }
    if (now.folded > kMostLeft * before.folded) {
      for (const Cut& cut : cuts_) trimmed_.put_back(cut.flap.triangle);
      return {};
    }
    loop = loop_;
    return std::move(cuts_);
  }

 private:
  static constexpr double kMostFolded = 0.1;  // of the area

  /// Where the triangulation of the corners folds.
  struct Folds {
    double area = 0.0, folded = 0.0;
    std::vector<std::array<std::uint64_t, 2>> edges;  ///< of the rim, as its faces run
  };

  bool touches_itself() {
    sorted_ = loop_;
    std::sort(sorted_.begin(), sorted_.end());
    return std::adjacent_find(sorted_.begin(), sorted_.end()) != sorted_.end();
  }

  /// The faces behind the edges, in the order of the corners from which the loop runs along them.
  bool find_faces() {
    sorted_ = loop_;
    std::sort(sorted_.begin(), sorted_.end());
    around_.clear();
    ends_.clear();
    surface_.triangles_at(sorted_, around_, ends_);
    faces_.clear();
    const std::size_t n = loop_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint64_t a = loop_[(i + 1) % n];
      const auto at = static_cast<std::size_t>(std::lower_bound(sorted_.begin(), sorted_.end(), a) -
                                               sorted_.begin());
      const std::size_t begin = at == 0 ? 0 : ends_[at - 1];
      const auto flap =
          find_flap(std::span(around_).subspan(begin, ends_[at] - begin), a, loop_[i]);
      if (!flap || trimmed_.taken().contains(flap->triangle)) return false;
      faces_.push_back(*flap);
    }
    return true;
  }

  Folds find_folds() {
    Folds folds;
    if (!find_faces()) return folds;
    const auto n = static_cast<std::uint32_t>(loop_.size());
    corners_.clear();
    behind_.clear();
    numbers_.clear();
    const Vec3 origin = trimmed_.position(loop_[0]);
    for (std::uint32_t i = 0; i < n; ++i) {
      corners_.push_back(trimmed_.position(loop_[i]) - origin);
      numbers_.push_back(i);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      const Vec3 third = trimmed_.position(faces_[i].c) - origin;
      behind_.push_back(facet(corners_[(i + 1) % n], corners_[i], third).normal);
    }
    if (n == 3) {
      add({0, 1, 2}, folds);
    } else {
      for (const CornerTriangle& t : triangulate_loop({corners_, numbers_, behind_, {}}))
        add(t, folds);
    }
    return folds;
  }

  void add(const CornerTriangle& t, Folds& folds) const {
    constexpr double kFacesAway = -0.5;  // cosine
    const auto n = static_cast<std::uint32_t>(loop_.size());
    const Facet face = facet(corners_[t[0]], corners_[t[1]], corners_[t[2]]);
    const std::size_t before = folds.edges.size();
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t i = t[k], next = (i + 1) % n;
      if (t[(k + 1) % 3] == next && dot(face.normal, behind_[i]) < kFacesAway)
        folds.edges.push_back({loop_[next], loop_[i]});
    }
    folds.area += face.area;
    if (folds.edges.size() > before) folds.folded += face.area;
  }

  /// Whether there were any.
  bool cut_flaps(const Folds& folds) {
    const std::size_t before = cuts_.size();
    for (const auto& [a, b] : folds.edges) cut_flap(a, b);
    return cuts_.size() > before;
  }

  void cut_flap(std::uint64_t a, std::uint64_t b) {
    constexpr std::size_t kFewestCorners = 3, kMostCorners = 24;
    const std::size_t n = loop_.size();
    const auto at =
        static_cast<std::size_t>(std::find(loop_.begin(), loop_.end(), b) - loop_.begin());
    if (at == n || loop_[(at + 1) % n] != a) return;  // a flap beside this one took the edge
    const std::optional<Flap> flap = find_flap(trimmed_.around(a), a, b);
    if (!flap) return;
    const bool has_next = !find_flap(trimmed_.around(flap->c), flap->c, b);
    const bool has_last = !find_flap(trimmed_.around(a), a, flap->c);
    if (!has_next && !has_last) {
      if (n == kMostCorners || !trimmed_.is_closed_at_c(*flap)) return;
      loop_.insert(loop_.begin() + static_cast<std::ptrdiff_t>(at) + 1, flap->c);
      cut({*flap, false});
    } else if (has_next != has_last && n > kFewestCorners) {
      // The loop runs from c by the ear's tip to the ear's first corner.
      const Flap ear = has_next ? *flap : Flap{flap->triangle, flap->c, a, b};
      const std::size_t tip = has_next ? at : (at + 1) % n;
      if (loop_[(tip + n - 1) % n] != ear.c || loop_[(tip + 1) % n] != ear.a) return;
      loop_.erase(loop_.begin() + static_cast<std::ptrdiff_t>(tip));
      cut({ear, true});
    }
  }

  void cut(const Cut& cut) {
    trimmed_.take(cut.flap.triangle);
    cuts_.push_back(cut);
  }

  const Surface& surface_;
  TrimmedSurface& trimmed_;
  std::vector<std::uint64_t> loop_;
  std::vector<Cut> cuts_;
  // Of the loop as it is.
  std::vector<std::uint64_t> sorted_;
  std::vector<Triangle64> around_;
  std::vector<std::size_t> ends_;
  std::vector<Flap> faces_;
  std::vector<Vec3> corners_, behind_;
  std::vector<std::uint32_t> numbers_;
};

std::vector<std::uint64_t> sorted_set(std::vector<std::uint64_t> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

/// Brings fans up to date where flaps went.
class FanCutter {
 public:
  /// `touched`: vertices of the flaps, ascending.
  FanCutter(std::vector<OpenFan>& fans, std::span<const std::uint64_t> touched) : fans_(fans) {
    const auto is_touched = [&](const OpenFan& fan) {
      return std::binary_search(touched.begin(), touched.end(), fan.vertex);
    };
    const auto others = std::stable_partition(fans.begin(), fans.end(),
                                              [&](const OpenFan& f) { return !is_touched(f); });
    at_.assign(others, fans.end());
    fans.erase(others, fans.end());
    std::sort(at_.begin(), at_.end(), [](const OpenFan& a, const OpenFan& b) {
      return std::tie(a.vertex, a.previous, a.next) < std::tie(b.vertex, b.previous, b.next);
    });
  }

  void apply(const Cut& cut) {
    const std::uint64_t a = cut.flap.a, b = cut.flap.b, c = cut.flap.c;
    OpenFan& at_a = find(a, [&](const OpenFan& fan) { return fan.next == b; });
    OpenFan& at_b = find(b, [&](const OpenFan& fan) { return fan.previous == a; });
    at_a.next = c;
    if (cut.is_ear) {
      find(c, [&](const OpenFan& fan) { return fan.previous == b; }).previous = a;
      at_b.previous = at_b.next = b;  // no fan any more
    } else {
      at_b.previous = c;
      new_.push_back({a, c, b, at_a.component});
    }
  }

  void finish() {
    at_.insert(at_.end(), new_.begin(), new_.end());
    std::erase_if(at_, [](const OpenFan& fan) { return fan.next == fan.vertex; });
    fans_.insert(fans_.end(), at_.begin(), at_.end());
  }

 private:
  template <class Is>
  OpenFan& find(std::uint64_t vertex, const Is& is) {
    auto at = std::lower_bound(at_.begin(), at_.end(), vertex,
                               [](const OpenFan& fan, std::uint64_t v) { return fan.vertex < v; });
    for (; at != at_.end() && at->vertex == vertex; ++at)
      if (is(*at)) return *at;
    return *std::find_if(new_.begin(), new_.end(),
                         [&](const OpenFan& fan) { return fan.vertex == vertex && is(fan); });
  }

  std::vector<OpenFan>& fans_;
  std::vector<OpenFan> at_, new_;
};

void bring_up_to_date(std::span<const Cut> cuts, std::vector<OpenFan>& fans) {
  std::vector<std::uint64_t> touched;
  for (const Cut& cut : cuts)
    touched.insert(touched.end(), cut.flap.triangle.begin(), cut.flap.triangle.end());
  touched = sorted_set(std::move(touched));
  FanCutter cutter(fans, touched);
  for (const Cut& cut : cuts) cutter.apply(cut);
  cutter.finish();
}

/// Adds the vertices that have come to the boundary.
void add_corners(std::span<const Cut> cuts, TrimmedSurface& trimmed,
                 std::vector<BoundaryVertex>& vertices) {
  std::vector<std::uint64_t> opened;
  for (const Cut& cut : cuts)
    if (!cut.is_ear) opened.push_back(cut.flap.c);
  const auto known = static_cast<std::ptrdiff_t>(vertices.size());
  for (const std::uint64_t vertex : sorted_set(std::move(opened))) {
    Vec3 normal;
    for (const Triangle64& t : trimmed.around(vertex)) normal = normal + trimmed.area_of(t);
    vertices.push_back({vertex, trimmed.position(vertex), normal});
  }
  // Of a vertex that was of the boundary before, by another fan, what was known comes first.
  std::inplace_merge(
      vertices.begin(), vertices.begin() + known, vertices.end(),
      [](const BoundaryVertex& a, const BoundaryVertex& b) { return a.vertex < b.vertex; });
}

RimFlaps flaps_of(TrimmedSurface& trimmed) {
  RimFlaps flaps;
  flaps.triangles.assign(trimmed.taken().begin(), trimmed.taken().end());
  std::vector<std::uint64_t> touched;
  for (const Triangle64& t : flaps.triangles) {
    touched.insert(touched.end(), t.begin(), t.end());
    flaps.area += 0.5 * norm(trimmed.area_of(t));
  }
  for (const std::uint64_t vertex : sorted_set(std::move(touched)))
    if (trimmed.around(vertex).empty()) flaps.freed.push_back(vertex);
  return flaps;
}

/// Flags of the loops that are wanted and fold.
std::vector<std::uint8_t> folding_loops(std::span<const std::uint8_t> is_wanted,
                                        const Surface& surface, std::span<const BoundaryLoop> loops,
                                        const StopToken* stop) {
  constexpr std::size_t kMostEdges = 16;
  constexpr double kSmooth = 0.8;  // of the suspects of an airborne scan nine in ten agree less
  constexpr std::size_t kLoopsAtOnce = 256;
  std::vector<std::uint8_t> folds(loops.size(), 0);
  for_each_whole((loops.size() + kLoopsAtOnce - 1) / kLoopsAtOnce, [&](std::size_t block) {
    TrimmedSurface whole(surface);
    LoopTrimmer trimmer(surface, whole);
    const std::size_t end = std::min(loops.size(), (block + 1) * kLoopsAtOnce);
    for (std::size_t l = block * kLoopsAtOnce; l < end; ++l) {
      const BoundaryLoop& loop = loops[l];
      if (is_wanted[l] == 0 || loop.vertices.size() > kMostEdges || loop.agreement() > kSmooth)
        continue;
      check_stop(stop);
      folds[l] = trimmer.folds(loop.vertices) ? 1 : 0;
    }
  });
  return folds;
}

}  // namespace

RimFlaps take_rim_flaps(std::span<const std::uint8_t> is_wanted, const Surface& surface,
                        std::vector<BoundaryLoop>& loops, std::vector<OpenFan>& fans,
                        std::vector<BoundaryVertex>& vertices, const StopToken* stop) {
  // A loop that does not fold does not come to fold as others lose their flaps.
  const std::vector<std::uint8_t> folds = folding_loops(is_wanted, surface, loops, stop);
  TrimmedSurface trimmed(surface);
  LoopTrimmer trimmer(surface, trimmed);
  std::vector<Cut> cuts;
  std::vector<std::size_t> changed;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (folds[l] == 0) continue;
    check_stop(stop);
    const std::vector<Cut> more = trimmer.trim(loops[l].vertices);
    if (!more.empty()) changed.push_back(l);
    cuts.insert(cuts.end(), more.begin(), more.end());
  }
  if (cuts.empty()) return {};
  bring_up_to_date(cuts, fans);
  add_corners(cuts, trimmed, vertices);
  for (const std::size_t l : changed) measure_loop(vertices, loops[l], stop);
  std::sort(loops.begin(), loops.end(),
            [](const BoundaryLoop& a, const BoundaryLoop& b) { return a.vertices < b.vertices; });
  return flaps_of(trimmed);
}

}  // namespace orbweave
