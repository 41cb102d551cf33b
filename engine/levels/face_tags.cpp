#include "engine/levels/face_tags.h"

#include <algorithm>
#include <limits>

#include "engine/geometry/triangle_tree.h"
#include "engine/levels/corner_groups.h"

namespace orbweave {
namespace {

/// The triangles around each vertex, and their tags.
class TaggedStars {
 public:
  TaggedStars(std::span<const Vec3> positions, std::span<const Triangle> triangles,
              std::span<const FaceTag> tags)
      : positions_(positions),
        triangles_(triangles),
        tags_(tags),
        stars_(
            triangles, [&](std::uint32_t t, std::size_t c) { return triangles[t][c]; },
            [](std::uint32_t t, std::size_t) { return t; }) {}

  FaceTag tag_of(const Triangle& t) const {
    const FaceTag& first = tags_[stars_[t[0]].front()];
    return is_everywhere(t, first) ? first : nearest_tag(t);
  }

 private:
  /// Where all triangles around the corners have one tag, no distance is needed.
  bool is_everywhere(const Triangle& t, const FaceTag& tag) const {
    return std::ranges::all_of(t, [&](std::uint32_t corner) {
      return std::ranges::all_of(stars_[corner],
                                 [&](std::uint32_t near) { return tags_[near] == tag; });
    });
  }

  bool reaches_all_corners(const Triangle& t, std::uint32_t component) const {
    return std::ranges::all_of(t, [&](std::uint32_t corner) {
      return std::ranges::any_of(
          stars_[corner], [&](std::uint32_t near) { return tags_[near].component == component; });
    });
  }

  FaceTag nearest_tag(const Triangle& t) const {
    /// A triangle of the component that has all three corners goes before any other.
    struct Candidate {
      bool is_foreign = true;
      double squared_distance = std::numeric_limits<double>::infinity();
      std::uint32_t triangle = std::numeric_limits<std::uint32_t>::max();
      auto operator<=>(const Candidate&) const = default;
    };
    const Vec3 middle = (1.0 / 3.0) * (positions_[t[0]] + positions_[t[1]] + positions_[t[2]]);
    Candidate best;
    for (const std::uint32_t corner : t)
      for (const std::uint32_t near : stars_[corner]) {
        const Triangle& n = triangles_[near];
        best = std::min(best, {!reaches_all_corners(t, tags_[near].component),
                               squared_distance_to_triangle(middle, positions_[n[0]],
                                                            positions_[n[1]], positions_[n[2]]),
                               near});
      }
    return tags_[best.triangle];
  }

  std::span<const Vec3> positions_;
  std::span<const Triangle> triangles_;
  std::span<const FaceTag> tags_;
  CornerGroups<std::uint32_t> stars_;
};

}  // namespace

std::vector<FaceTag> simplified_tags(std::span<const Vec3> positions,
                                     std::span<const Triangle> before,
                                     std::span<const FaceTag> tags,
                                     std::span<const Triangle> after) {
  if (tags.empty()) return {};
  if (std::ranges::all_of(tags, [&](const FaceTag& tag) { return tag == tags.front(); }))
    return std::vector<FaceTag>(after.size(), tags.front());
  const TaggedStars stars(positions, before, tags);
  std::vector<FaceTag> result;
  result.reserve(after.size());
  for (const Triangle& t : after) result.push_back(stars.tag_of(t));
  return result;
}

}  // namespace orbweave
