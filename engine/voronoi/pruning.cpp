#include "engine/voronoi/pruning.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/voronoi/umbrellas.h"

namespace orbweave::voronoi {
namespace {

class Pruning {
 public:
  Pruning(std::span<const Vec3> points, const Tetrahedra& tetrahedra, const Stars& stars,
          std::span<const Vec3> normals, FacetFlags& flags)
      : points_(points),
        tetrahedra_(tetrahedra),
        flags_(flags),
        umbrellas_(points, tetrahedra, stars, normals, flags) {}

  void run(const StopToken* stop) {
    for (std::uint32_t c = 0; c < tetrahedra_.size(); ++c) {
      if (c % kStopBlock == 0) check_stop(stop);
      if (!flags_.has_any(c)) continue;
      for (int place = 0; place < 4; ++place) {
        const FacetSide side{c, place};
        const bool is_first = c < tetrahedra_.neighbors[c][static_cast<std::size_t>(place)];
        if (is_first && flags_.has(side) && is_sharp(side)) waiting_.push_back(side);
      }
    }
    while (!waiting_.empty()) {
      check_stop(stop);
      sort_waiting();
      for (const FacetSide side : std::exchange(waiting_, {}))
        if (flags_.has(side) && is_sharp(side)) remove_if_spare(side);
    }
  }

 private:
  bool is_sharp(FacetSide side) const {
    for (const FacetSide from : {side, flags_.opposite(side)})
      for (int edge = 0; edge < 3; ++edge)
        if (folds_back(points_, tetrahedra_, from, edge,
                       next_around(tetrahedra_, flags_, from, edge)))
          return true;
    return false;
  }

  /// Facets by their corners: storage decides nothing.
  void sort_waiting() {
    std::vector<std::pair<Triangle, FacetSide>> keyed;
    for (const FacetSide side : waiting_) {
      Triangle key = corners_of(tetrahedra_, side);
      std::sort(key.begin(), key.end());
      keyed.emplace_back(key, side);
    }
    std::sort(keyed.begin(), keyed.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < keyed.size(); ++i) waiting_[i] = keyed[i].second;
  }

  void remove_if_spare(FacetSide side) {
    std::vector<FacetSide> near;
    for (const FacetSide from : {side, flags_.opposite(side)})
      for (int edge = 0; edge < 3; ++edge)
        near.push_back(next_around(tetrahedra_, flags_, from, edge));
    flags_.clear(side);
    for (const std::uint32_t corner : corners_of(tetrahedra_, side)) {
      if (umbrellas_.separate(corner)) continue;
      flags_.set(side);
      return;
    }
    waiting_.insert(waiting_.end(), near.begin(), near.end());
  }

  std::span<const Vec3> points_;
  const Tetrahedra& tetrahedra_;
  FacetFlags& flags_;
  Umbrellas umbrellas_;
  std::vector<FacetSide> waiting_;
};

}  // namespace

void prune_sharp_edges(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                       const Stars& stars, std::span<const Vec3> normals, FacetFlags& flags,
                       const StopToken* stop) {
  Pruning(points, tetrahedra, stars, normals, flags).run(stop);
}

}  // namespace orbweave::voronoi
