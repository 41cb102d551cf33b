#include "engine/normals/free_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "engine/geometry/plane_axes.h"
#include "engine/normals/patch_rays.h"

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

class Search {
 public:
  Search(std::span<const PatchSum> sums, double cell, std::span<const std::uint32_t> part,
         std::span<const std::uint8_t> turn)
      : sums_(sums), part_(part), turn_(turn), rays_(sums, cell) {}

  SpaceOfParts run(const RowsOfParts& rows_of_parts, const StopToken* stop) {
    std::size_t total = 0;
    for (const auto& [part, rows] : rows_of_parts) total += rows.size();
    SpaceOfParts found;
    found.of_part.resize(sums_.size());
    for (const auto& [part, rows] : rows_of_parts) {
      const std::size_t samples = std::max(kLeastSamples, kSamples * rows.size() / total);
      const std::size_t stride = (rows.size() + samples - 1) / samples;
      for (std::size_t k = 0; k < rows.size(); k += stride) {
        check_stop(stop);
        add(rows[k], found.of_part[part]);
      }
      finish(found.of_part[part]);
    }
    for (const auto& [pair, facing] : facing_) found.facing.push_back(facing);
    return found;
  }

 private:
  void add(std::uint32_t v, PartSpace& space) {
    // Turned from patch to patch, so that walls at right angles do not all send rays along an axis.
    turn();
    const Vec3 normal = turn_[v] ? -rays_.normal(v) : rays_.normal(v);
    const double area = norm(sums_[v].area_normal);
    const Side front = look(v, normal, true), back = look(v, -normal, false);
    space.area += area;
    space.open_front += area * front.left;
    space.open_back += area * back.left;
    if (front.left > kShut || back.left > kShut) return;
    space.shut += area;
    if (front.reach > kWider * back.reach) space.farther_front += area;
    if (back.reach > kByFarWider * front.reach && is_cut_off(v, normal)) {
      space.farther_back += area;
      ++space.cut_off;
    }
  }

  static void finish(PartSpace& space) {
    if (!(space.area > 0.0)) return;
    space.open_front /= space.area;
    space.open_back /= space.area;
  }

  Vec3 direction_to(Vec3 side, std::size_t k) const {
    const PlaneAxes axes = plane_axes(side);
    const double x = turned_[0] * kDisc[k][0] - turned_[1] * kDisc[k][1];
    const double y = turned_[1] * kDisc[k][0] + turned_[0] * kDisc[k][1];
    return normalized(x * axes.u + y * axes.v +
                      std::sqrt(std::max(0.0, 1.0 - x * x - y * y)) * side);
  }

  void turn() {
    turned_ = {0.6 * turned_[0] - 0.8 * turned_[1], 0.8 * turned_[0] + 0.6 * turned_[1]};
  }

  /// Whether few of the rays to a side leave the cloud even where they are thrown back again and
  /// again: the space of a fold leads outside, the inside of a board does not.
  bool is_cut_off(std::uint32_t v, Vec3 side) {
    constexpr int kThrows = 24;
    constexpr std::size_t kMostOut = 3;
    std::size_t out = 0;
    for (std::size_t k = 0; k < kDisc.size(); ++k) {
      std::uint32_t at = v;
      Vec3 to = side;
      for (int thrown = 0; thrown < kThrows && at != PatchRays::kNothing; ++thrown) {
        turn();
        const Vec3 direction =
            direction_to(to, (k + static_cast<std::size_t>(thrown)) % kDisc.size());
        at = rays_.first(at, direction).patch;
        if (at == PatchRays::kNothing) break;
        to = rays_.normal(at);
        if (dot(to, direction) > 0.0) to = -to;
      }
      if (at == PatchRays::kNothing) ++out;
    }
    return out <= kMostOut;
  }

  Side look(std::uint32_t v, Vec3 side, bool is_front) {
    const double area = norm(sums_[v].area_normal) / static_cast<double>(kDisc.size());
    std::array<double, kDisc.size()> reaches{};
    Side found;
    for (std::size_t k = 0; k < kDisc.size(); ++k) {
      const Vec3 direction = direction_to(side, k);
      const PatchRays::Hit hit = rays_.first(v, direction);
      reaches[k] = hit.distance;
      if (hit.patch == PatchRays::kNothing) {
        found.left += 1.0 / static_cast<double>(kDisc.size());
      } else if (part_[hit.patch] != part_[v]) {
        const Vec3 met = turn_[hit.patch] ? -rays_.normal(hit.patch) : rays_.normal(hit.patch);
        Facing& facing = facing_[{part_[v], part_[hit.patch]}];
        facing.from = part_[v];
        facing.to = part_[hit.patch];
        facing.weight += area;
        if (is_front) facing.front += area;
        facing.votes += (dot(met, direction) < 0.0) == is_front ? area : -area;
      }
    }
    std::nth_element(reaches.begin(), reaches.begin() + reaches.size() / 2, reaches.end());
    found.reach = reaches[reaches.size() / 2];
    return found;
  }

  std::span<const PatchSum> sums_;
  std::span<const std::uint32_t> part_;
  std::span<const std::uint8_t> turn_;
  PatchRays rays_;
  std::array<double, 2> turned_ = {1.0, 0.0};
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
