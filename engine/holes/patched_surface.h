// A mesh with its patches, from which triangles are taken and to which patches are added while it
// is mended.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "engine/holes/hole_pass.h"
#include "engine/holes/problem/boundary_loop.h"
#include "engine/holes/problem/surface.h"
#include "io/box.h"

namespace orbweave {

/// What has been filled so far, as far as it is asked for.
struct FilledSurface {
  const Surface& scanned;  ///< without patches
  /// Adds the scanned triangles that come near a box, and maybe others.
  std::function<void(const Box&, std::vector<Triangle64>&)> scanned_near;
  std::span<const BoundaryLoop> loops;
  std::span<const HoleFacts> holes;         ///< what became of each loop
  std::int32_t first_id = 1;                ///< of the first loop
  std::span<const std::uint8_t> is_wanted;  ///< per loop, whether it was to be filled
  std::vector<Box> boxes;                   ///< per loop, of its patch; empty where it has none
  /// The patch of a loop that has one; its new vertices are kNewVertex + index.
  std::function<LoopPatch(std::size_t)> patch_of;
};

/// A triangle, and which patch it is of.
struct OwnedTriangle {
  static constexpr std::uint32_t kScanned = UINT32_MAX;
  Triangle64 corners{};
  std::uint32_t patch = kScanned;
  friend auto operator<=>(const OwnedTriangle&, const OwnedTriangle&) = default;
};

/// Patches are numbered like the loops that they close; those that are added come behind. New
/// vertex i of patch p is kNewVertex + (p << 32) + i. Not for several threads.
class PatchedSurface : public Surface {
 public:
  explicit PatchedSurface(const FilledSurface& filled);

  Vec3 position(std::uint64_t vertex) const override;
  void triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const override;
  std::uint32_t channels() const override { return filled_.scanned.channels(); }
  std::vector<double> values(std::span<const std::uint64_t> vertices) const override;

  using Surface::triangles_at;
  /// All triangles at a vertex, sorted.
  std::vector<OwnedTriangle> owned_at(std::uint64_t vertex) const;
  /// The triangle that runs along an edge in this direction.
  std::optional<OwnedTriangle> along(std::uint64_t tail, std::uint64_t head) const;
  /// All triangles whose boxes meet this one, sorted.
  std::vector<OwnedTriangle> near(const Box& box) const;
  Box box_of(const Triangle64& t) const;

  void take(const Triangle64& t) { taken_.insert(t); }
  void put_back(const Triangle64& t) { taken_.erase(t); }
  const std::set<Triangle64>& taken() const { return taken_; }

  /// The patch that closes a loop, alone or with others.
  std::uint32_t patch_of_loop(std::uint32_t loop) const;
  /// The loops that a patch closes or would close; not of added ones.
  std::vector<std::uint32_t> loops_of_patch(std::uint32_t patch) const;
  /// Whether all of these were to be filled.
  bool may_be_filled(std::uint32_t patch) const;
  /// The loops that visit a vertex.
  std::vector<std::uint32_t> loops_at(std::uint64_t vertex) const;
  bool has_patch(std::uint32_t patch) const { return is_there_[patch] != 0; }
  void drop(std::uint32_t patch) { is_there_[patch] = 0; }
  void restore(std::uint32_t patch) { is_there_[patch] = 1; }
  /// Adds a patch over a rim, a simple loop; returns its number.
  std::uint32_t add(LoopPatch patch, std::span<const std::uint64_t> rim);
  /// Takes the patch that was added last out for good.
  void remove_last();
  /// An added patch, its new vertices as they were given.
  const LoopPatch& added(std::uint32_t patch) const { return added_[patch - loops_]; }
  /// Its rim, in the direction in which it uses the edges.
  std::span<const std::uint64_t> rim_of_added(std::uint32_t patch) const {
    return added_rims_[patch - loops_];
  }
  /// The triangles of a patch that is there, sorted.
  std::vector<OwnedTriangle> triangles_of(std::uint32_t patch) const;
  std::uint32_t patches() const { return static_cast<std::uint32_t>(is_there_.size()); }

  /// Forgets the patches of `filled` that have been asked for.
  void forget() const { known_.clear(); }

 private:
  struct Known {
    LoopPatch patch;
    std::vector<std::pair<std::uint64_t, Triangle64>> at;  // by vertex, in this surface's numbers
  };

  const Known& known(std::uint32_t patch) const;
  Known known_of(LoopPatch patch, std::uint32_t number) const;
  void add_of_patch(std::uint32_t patch, std::uint64_t vertex,
                    std::vector<OwnedTriangle>& out) const;
  const Box& box_of_patch(std::uint32_t patch) const;

  const FilledSurface& filled_;
  const std::uint32_t loops_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> visits_;  // (vertex, loop), sorted
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joined_;  // (patch, other loop), sorted
  std::multimap<std::uint64_t, std::uint32_t> added_at_;  // patches by vertices of their rims
  std::vector<LoopPatch> added_;
  std::vector<std::vector<std::uint64_t>> added_rims_;
  std::vector<Box> added_boxes_;
  std::vector<std::uint8_t> is_there_;  // per patch
  std::set<Triangle64> taken_;
  mutable std::map<std::uint32_t, Known> known_;
};

}  // namespace orbweave
