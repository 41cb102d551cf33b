// One fault of a closed object, mended: a gap is widened until patches close it that cross nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "engine/holes/patched_surface.h"
#include "engine/holes/problem/boundary_loop.h"
#include "io/stop_token.h"
#include "io/surface_options.h"

namespace orbweave {

/// Either the patch of a loop that is open, whether or not there is a patch, or a vertex with
/// several fans.
struct RegionFault {
  std::optional<std::uint32_t> patch;
  std::uint64_t vertex = 0;
};

/// What a mend changed.
struct RegionMend {
  std::vector<std::uint32_t> added;    ///< patches
  std::vector<std::uint32_t> dropped;  ///< patches, and those that open loops would have had
};

class RegionMender {
 public:
  RegionMender(PatchedSurface& surface, std::span<const BoundaryLoop> loops,
               const FillOptions& options, const StopToken* stop)
      : surface_(surface), loops_(loops), options_(options), stop_(stop) {}

  /// Empty where the fault stays as it is, with the surface as it was, or where there is none.
  std::optional<RegionMend> mend(const RegionFault& fault);

 private:
  using Edge = std::array<std::uint64_t, 2>;
  /// A patch over a gap, among the patches of the surface.
  struct Trial {
    std::vector<std::uint64_t> rim;
    std::uint32_t patch = 0;
  };

  bool begin(const RegionFault& fault);
  bool close();
  void add_edge(std::uint64_t tail, std::uint64_t head);
  void take(const Triangle64& t);
  void drop(std::uint32_t patch);
  void give_up(const OwnedTriangle& t);
  bool settle_rim();
  bool join_open_loops(bool& any);
  bool leave_one_fan_each(bool& any);
  bool take_what_hangs_loose(bool& any);
  bool is_small_component(const OwnedTriangle& from, std::set<OwnedTriangle>& seen) const;
  bool hangs_together(std::span<const BoundaryLoop> gaps) const;
  std::vector<BoundaryLoop> gaps() const;
  bool fill(const BoundaryLoop& gap, bool flat);
  std::uint64_t contacts_of(const Trial& trial, std::vector<std::array<OwnedTriangle, 2>>& found);
  void widen(std::span<const std::array<OwnedTriangle, 2>> contacts,
             std::span<const BoundaryLoop> gaps);
  void take_around(const Triangle64& t);
  void take_around(std::uint64_t vertex);
  void take_back_trials();
  void take_back_all();

  PatchedSurface& surface_;
  std::span<const BoundaryLoop> loops_;
  const FillOptions& options_;
  const StopToken* stop_;
  std::set<Edge> rim_;  // that new triangles are to use, in their direction
  std::vector<Triangle64> taken_;
  std::vector<std::uint32_t> dropped_;
  std::vector<std::uint32_t> had_patch_;  // of the dropped
  std::vector<Trial> trials_;
  std::size_t most_taken_ = 0;
  bool is_hopeless_ = false;
};

}  // namespace orbweave
