#include "engine/voronoi/pruning.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/voronoi/umbrellas.h"

namespace orbweave::voronoi {
namespace {

class Pruning {
 public:
  Pruning(std::span<const Vec3> points, const Tetrahedra& tetrahedra, StarFinder& stars,
          std::span<const Vec3> normals, FacetFlags& flags, FacetLinks& links)
      : points_(points),
        flags_(flags),
        links_(links),
        umbrellas_(points, tetrahedra, stars, normals, flags) {}

  void run(const StopToken* stop) {
    for (HalfEdge edge = 0; edge < 3 * links_.halves(); ++edge) {
      if (edge % kStopBlock == 0) check_stop(stop);
      const HalfEdge across = links_.across(edge);
      if (across < edge || is_certainly_open(links_, edge)) continue;
      for (const HalfEdge from : {edge, across})
        if (folds_back(points_, links_, from)) waiting_.push_back(FacetLinks::half_of(from) & ~1U);
    }
    while (!waiting_.empty()) {
      check_stop(stop);
      sort_waiting();
      for (const FacetHalf half : std::exchange(waiting_, {}))
        if (links_.is_there(half) && is_sharp(half)) remove_if_spare(half);
    }
  }

 private:
  bool is_sharp(FacetHalf half) const {
    for (const FacetHalf from : {half, FacetLinks::opposite(half)})
      for (std::uint32_t k = 0; k < 3; ++k)
        if (folds_back(points_, links_, 3 * from + k)) return true;
    return false;
  }

  /// Facets by their corners, each once: storage decides nothing.
  void sort_waiting() {
    std::vector<std::pair<Triangle, FacetHalf>> keyed;
    for (const FacetHalf half : waiting_) {
      Triangle key = links_.corners(half);
      std::sort(key.begin(), key.end());
      keyed.emplace_back(key, half);
    }
    std::sort(keyed.begin(), keyed.end());
    keyed.erase(std::unique(keyed.begin(), keyed.end()), keyed.end());
    waiting_.clear();
    for (const auto& [key, half] : keyed) waiting_.push_back(half);
  }

  void remove_if_spare(FacetHalf half) {
    const FacetSide side = links_.side(half);
    flags_.clear(side);
    for (const std::uint32_t corner : links_.corners(half)) {
      if (umbrellas_.separate(corner)) continue;
      flags_.set(side);
      return;
    }
    for (const FacetHalf from : {half, FacetLinks::opposite(half)})
      for (std::uint32_t k = 0; k < 3; ++k)
        waiting_.push_back(FacetLinks::half_of(links_.across(3 * from + k)) & ~1U);
    links_.remove(half);
  }

  std::span<const Vec3> points_;
  FacetFlags& flags_;
  FacetLinks& links_;
  Umbrellas umbrellas_;
  std::vector<FacetHalf> waiting_;
};

}  // namespace

void prune_sharp_edges(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                       StarFinder& stars, std::span<const Vec3> normals, FacetFlags& flags,
                       FacetLinks& links, const StopToken* stop) {
  Pruning(points, tetrahedra, stars, normals, flags, links).run(stop);
}

}  // namespace orbweave::voronoi
