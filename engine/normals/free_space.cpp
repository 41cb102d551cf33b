#include "engine/normals/free_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "engine/geometry/plane_axes.h"
#include "engine/normals/patch_rays.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// Patches that send rays: about so many in all, and at least so many of a part.
constexpr std::size_t kSamples = 1024, kLeastSamples = 24;
/// Rays of a patch to each side: points of a disc, evenly spread, which make directions that are
/// spread as light is.
constexpr std::array<std::array<double, 2>, 9> kDisc = {{{0.0, 0.0},
                                                         {0.5, 0.1},
                                                         {-0.1, 0.5},
                                                         {-0.5, -0.1},
                                                         {0.1, -0.5},
                                                         {0.6, 0.6},
                                                         {-0.6, 0.6},
                                                         {-0.6, -0.6},
                                                         {0.6, -0.6}}};
/// Of the rays to a side that may leave the cloud where that side is shut in.
constexpr double kShut = 0.15;
/// So much farther reaches the side that is the wider one. Back, which is taken for solid, has to
/// be wider by more: in the folds of a closed object the solid is twice as wide.
constexpr double kWider = 2.0, kByFarWider = 4.0;

/// What rays to one side of a patch find.
struct Side {
  double left = 0.0;   // share of rays that leave the cloud
  double reach = 0.0;  // median distance
};

/// What the rays of one patch find.
struct Seen {
  Side front, back;
  bool is_cut_off = false;     ///< at its front, where back is by far the wider side
  std::vector<Facing> facing;  ///< of every ray that meets another part
};

/// The patches, as rays meet them.
struct Scene {
  std::span<const PatchSum> sums;
  std::span<const std::uint32_t> part;
  PatchRays rays;
};

/// Directions of the unit circle, each turned against the one before: rays are turned from patch to
/// patch, so that walls at right angles do not all send rays along an axis.
class Turns {
 public:
  void next() {
    turned_ = {0.6 * turned_[0] - 0.8 * turned_[1], 0.8 * turned_[0] + 0.6 * turned_[1]};
  }
  Vec3 direction_to(Vec3 side, std::size_t k) const {
    const PlaneAxes axes = plane_axes(side);
    const double x = turned_[0] * kDisc[k][0] - turned_[1] * kDisc[k][1];
    const double y = turned_[1] * kDisc[k][0] + turned_[0] * kDisc[k][1];
    return normalized(x * axes.u + y * axes.v +
                      std::sqrt(std::max(0.0, 1.0 - x * x - y * y)) * side);
  }

 private:
  std::array<double, 2> turned_ = {1.0, 0.0};
};

/// The rays of one patch.
class Viewer {
 public:
  Viewer(const Scene& scene, std::uint32_t patch, Turns turns)
      : scene_(scene), v_(patch), turns_(turns) {}

  Seen look_around() {
    const Vec3 normal = scene_.rays.normal(v_);
    if (normal == Vec3{}) {
      seen_.front.left = seen_.back.left = 1.0;
      return std::move(seen_);
    }
    seen_.front = look(normal, true);
    seen_.back = look(-normal, false);
    if (is_shut(seen_) && seen_.back.reach > kByFarWider * seen_.front.reach)
      seen_.is_cut_off = is_cut_off(normal);
    return std::move(seen_);
  }

  static bool is_shut(const Seen& seen) {
    return seen.front.left <= kShut && seen.back.left <= kShut;
  }

 private:
  /// Whether few of the rays to a side leave the cloud even where they are thrown back again and
  /// again: the space of a fold leads outside, the inside of a board does not.
  bool is_cut_off(Vec3 side) {
    constexpr int kThrows = 24;
    constexpr std::size_t kMostOut = 3;
    std::size_t out = 0;
    for (std::size_t k = 0; k < kDisc.size(); ++k) {
      std::uint32_t at = v_;
      Vec3 to = side;
      for (int thrown = 0; thrown < kThrows && at != PatchRays::kNothing; ++thrown) {
        turns_.next();
        const Vec3 direction =
            turns_.direction_to(to, (k + static_cast<std::size_t>(thrown)) % kDisc.size());
        at = scene_.rays.first(at, direction).patch;
        if (at == PatchRays::kNothing) break;
        to = scene_.rays.normal(at);
        if (dot(to, direction) > 0.0) to = -to;
      }
      if (at == PatchRays::kNothing) ++out;
    }
    return out <= kMostOut;
  }

  Side look(Vec3 side, bool is_front) {
    const double area = norm(scene_.sums[v_].area_normal) / static_cast<double>(kDisc.size());
    std::array<double, kDisc.size()> reaches{};
    Side found;
    for (std::size_t k = 0; k < kDisc.size(); ++k) {
      const Vec3 direction = turns_.direction_to(side, k);
      const PatchRays::Hit hit = scene_.rays.first(v_, direction);
      reaches[k] = hit.distance;
      if (hit.patch == PatchRays::kNothing) {
        found.left += 1.0 / static_cast<double>(kDisc.size());
      } else if (scene_.part[hit.patch] != scene_.part[v_]) {
        const Vec3 met = scene_.rays.normal(hit.patch);
        Facing& facing = seen_.facing.emplace_back();
        facing.from = scene_.part[v_];
        facing.to = scene_.part[hit.patch];
        facing.weight = area;
        facing.front = is_front ? area : 0.0;
        facing.votes = (dot(met, direction) < 0.0) == is_front ? area : -area;
      }
    }
    std::nth_element(reaches.begin(), reaches.begin() + reaches.size() / 2, reaches.end());
    found.reach = reaches[reaches.size() / 2];
    return found;
  }

  const Scene& scene_;
  std::uint32_t v_;
  Turns turns_;
  Seen seen_;
};

class Search {
 public:
  Search(std::span<const PatchSum> sums, double cell, std::span<const std::uint32_t> part,
         std::span<const std::uint8_t> turn)
      : scene_{sums, part, PatchRays(sums, cell, turn, part)} {}

  SpaceOfParts run(const RowsOfParts& rows_of_parts, const StopToken* stop) {
    const std::vector<std::uint32_t> samples = samples_of(rows_of_parts);
    std::vector<Turns> turns(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (i > 0) turns[i] = turns[i - 1];
      turns[i].next();
    }
    std::vector<Seen> seen(samples.size());
    for_each_whole(samples.size(), [&](std::size_t i) {
      check_stop(stop);
      seen[i] = Viewer(scene_, samples[i], turns[i]).look_around();
    });
    SpaceOfParts found;
    found.of_part.resize(scene_.sums.size());
    for (std::size_t i = 0; i < samples.size(); ++i)
      add(seen[i], norm(scene_.sums[samples[i]].area_normal),
          found.of_part[scene_.part[samples[i]]]);
    for (const auto& [part, rows] : rows_of_parts) finish(found.of_part[part]);
    for (const auto& [pair, facing] : facing_) found.facing.push_back(facing);
    return found;
  }

 private:
  /// Patches that send rays, part by part.
  static std::vector<std::uint32_t> samples_of(const RowsOfParts& rows_of_parts) {
    std::size_t total = 0;
    for (const auto& [part, rows] : rows_of_parts) total += rows.size();
    std::vector<std::uint32_t> patches;
    for (const auto& [part, rows] : rows_of_parts) {
      const std::size_t samples = std::max(kLeastSamples, kSamples * rows.size() / total);
      const std::size_t stride = (rows.size() + samples - 1) / samples;
      for (std::size_t k = 0; k < rows.size(); k += stride) patches.push_back(rows[k]);
    }
    return patches;
  }

  void add(const Seen& seen, double area, PartSpace& space) {
    for (const Facing& of_ray : seen.facing) {
      Facing& facing = facing_[{of_ray.from, of_ray.to}];
      facing.from = of_ray.from;
      facing.to = of_ray.to;
      facing.weight += of_ray.weight;
      facing.front += of_ray.front;
      facing.votes += of_ray.votes;
    }
    space.area += area;
    space.open_front += area * seen.front.left;
    space.open_back += area * seen.back.left;
    if (!Viewer::is_shut(seen)) return;
    space.shut += area;
    if (seen.front.reach > kWider * seen.back.reach) space.farther_front += area;
    if (!seen.is_cut_off) return;
    space.farther_back += area;
    ++space.cut_off;
  }

  static void finish(PartSpace& space) {
    if (!(space.area > 0.0)) return;
    space.open_front /= space.area;
    space.open_back /= space.area;
  }

  Scene scene_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Facing> facing_;
};

}  // namespace

SpaceOfParts find_free_space(std::span<const PatchSum> sums, double cell,
                             std::span<const std::uint32_t> part,
                             std::span<const std::uint8_t> turn, const RowsOfParts& rows,
                             const StopToken* stop) {
  return Search(sums, cell, part, turn).run(rows, stop);
}

}  // namespace orbweave
