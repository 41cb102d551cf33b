#include "engine/holes/mend_solids.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/geometry/disjoint_sets.h"
#include "engine/holes/mend_region.h"

namespace orbweave {
namespace {

/// What one or more faults next to each other have become.
struct Mend {
  std::vector<std::uint32_t> loops;    // that it closes, ascending
  std::vector<std::uint32_t> patches;  // that were added, ascending
};

double area_of(const Triangle64& t, const Surface& surface) {
  const Vec3 a = surface.position(t[0]);
  return 0.5 * norm(cross(surface.position(t[1]) - a, surface.position(t[2]) - a));
}

/// The patches of one mend as one.
LoopPatch joined(std::vector<LoopPatch> parts) {
  LoopPatch whole = std::move(parts.front());
  for (std::size_t i = 1; i < parts.size(); ++i) {
    LoopPatch& part = parts[i];
    const std::uint64_t base = whole.positions.size();
    for (Triangle64 t : part.triangles) {
      for (std::uint64_t& vertex : t) vertex += vertex >= kNewVertex ? base : 0;
      whole.triangles.push_back(t);
    }
    whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
    whole.normals.insert(whole.normals.end(), part.normals.begin(), part.normals.end());
    whole.values.insert(whole.values.end(), part.values.begin(), part.values.end());
    HoleFacts& facts = whole.facts;
    facts.sites += part.facts.sites;
    facts.area += part.facts.area;
    facts.residual = std::max(facts.residual, part.facts.residual);
    facts.condition = std::max(facts.condition, part.facts.condition);
    facts.rim_dihedral_deg = std::max(facts.rim_dihedral_deg, part.facts.rim_dihedral_deg);
    facts.rim_mean_deg = std::max(facts.rim_mean_deg, part.facts.rim_mean_deg);
    facts.confidence = std::min(facts.confidence, part.facts.confidence);
    facts.seconds += part.facts.seconds;
  }
  whole.facts.points_added = whole.positions.size();
  whole.facts.triangles_added = whole.triangles.size();
  return whole;
}

/// The smallest scanned vertex of the patch: that of the loop may have gone.
void set_first_vertex(LoopPatch& patch) {
  std::uint64_t first = kNewVertex;
  for (const Triangle64& t : patch.triangles) first = std::min(first, std::min({t[0], t[1], t[2]}));
  if (first < kNewVertex) patch.facts.first_vertex = first;
}

class Mender {
 public:
  Mender(const FilledSurface& filled, const FillOptions& options, const StopToken* stop)
      : filled_(filled), surface_(filled), options_(options), stop_(stop) {
    options_.allow_intersections = true;  // what crosses is looked for here
    is_replaced_.assign(filled.loops.size(), 0);
  }

  void mend_loop(std::uint32_t loop) {
    if (is_replaced_[loop] != 0) return;  // with another one
    RegionFault fault;
    fault.patch = surface_.patch_of_loop(loop);
    mend(fault);
  }

  void mend_pinch(std::uint64_t vertex) {
    RegionFault fault;
    fault.vertex = vertex;
    mend(fault);
  }

  Mended result() {
    Mended mended;
    auto next_id = filled_.first_id + static_cast<std::int32_t>(filled_.loops.size());
    for (const Mend& mend : mends_)
      if (!mend.loops.empty() || !mend.patches.empty()) add_mend(mend, next_id, mended);
    mended.is_replaced = is_replaced_;
    mended.taken.assign(surface_.taken().begin(), surface_.taken().end());
    for (const Triangle64& t : mended.taken) mended.taken_area += area_of(t, filled_.scanned);
    mended.pieces_gone = pieces_gone(mended.taken);
    add_touched(mended);
    return mended;
  }

 private:
  void mend(const RegionFault& fault) {
    check_stop(stop_);
    RegionMender region(surface_, filled_.loops, options_, stop_);
    std::optional<RegionMend> found = region.mend(fault);
    surface_.forget();
    if (!found) return;
    Mend mend;
    mend.patches = found->added;
    for (const std::uint32_t patch : found->dropped) take_over(patch, mend);
    std::sort(mend.loops.begin(), mend.loops.end());
    std::sort(mend.patches.begin(), mend.patches.end());
    std::erase_if(mend.patches, [&](std::uint32_t p) { return !surface_.has_patch(p); });
    mends_.push_back(std::move(mend));
  }

  /// What a patch that has gone closed is the new mend's.
  void take_over(std::uint32_t patch, Mend& mend) {
    if (patch >= filled_.loops.size()) {
      const auto old = std::find_if(mends_.begin(), mends_.end(), [&](const Mend& m) {
        return std::binary_search(m.patches.begin(), m.patches.end(), patch);
      });
      if (old == mends_.end()) return;  // taken over with another one
      mend.loops.insert(mend.loops.end(), old->loops.begin(), old->loops.end());
      mend.patches.insert(mend.patches.end(), old->patches.begin(), old->patches.end());
      mends_.erase(old);
      return;
    }
    for (const std::uint32_t l : surface_.loops_of_patch(patch)) {
      is_replaced_[l] = 1;
      mend.loops.push_back(l);
    }
  }

  /// What is said of a mend: under the number of its first loop, or a new one where it had none.
  void add_mend(const Mend& mend, std::int32_t& next_id, Mended& mended) const {
    HoleFacts known;
    if (!mend.loops.empty()) known = filled_.holes[mend.loops.front()];
    std::vector<LoopPatch> parts;
    for (const std::uint32_t patch : mend.patches) parts.push_back(surface_.added(patch));
    if (parts.empty()) parts.emplace_back().facts.confidence = 1.0;  // what was open has gone
    LoopPatch whole = joined(std::move(parts));
    HoleFacts& facts = whole.facts;
    if (mend.loops.empty()) {
      facts.id = next_id++;
    } else {
      facts.id = known.id;
      facts.first_vertex = known.first_vertex;
      facts.edges = known.edges;
      facts.perimeter = known.perimeter;
      facts.diameter = known.diameter;
      facts.center = known.center;
    }
    set_first_vertex(whole);
    facts.filled = true;
    facts.open = OpenReason::kNone;
    facts.open_edges = 0;
    if (facts.method.empty()) facts.method = "direct";
    facts.reason = "closed after triangles of the scan around it were taken out";
    for (std::size_t i = 1; i < mend.loops.size(); ++i) {
      HoleFacts& other = mended.joined.emplace_back(filled_.holes[mend.loops[i]]);
      const double confidence = facts.confidence;
      const HoleFacts before = other;
      other = {};
      other.id = before.id;
      other.first_vertex = facts.first_vertex;
      other.edges = before.edges;
      other.perimeter = before.perimeter;
      other.diameter = before.diameter;
      other.center = before.center;
      other.filled = true;
      other.joined_to = facts.id;
      other.method = facts.method;
      other.confidence = confidence;
    }
    mended.patches.push_back(std::move(whole));
  }

  /// Pieces of the scanned mesh, joined over edges, of which nothing is left.
  std::uint64_t pieces_gone(std::span<const Triangle64> taken) const {
    const auto number_of = [&](const Triangle64& t) {
      const auto at = std::lower_bound(taken.begin(), taken.end(), t);
      return at != taken.end() && *at == t ? static_cast<std::size_t>(at - taken.begin())
                                           : taken.size();
    };
    DisjointSets pieces(taken.size());
    std::vector<std::uint8_t> has_more(taken.size(), 0);
    std::vector<Triangle64> around;
    for (std::uint32_t i = 0; i < taken.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const std::uint64_t tail = taken[i][k], head = taken[i][(k + 1) % 3];
        around.clear();
        filled_.scanned.triangles_at(tail, around);
        for (const Triangle64& other : around) {
          const bool is_beside = (other[0] == head && other[1] == tail) ||
                                 (other[1] == head && other[2] == tail) ||
                                 (other[2] == head && other[0] == tail);
          if (!is_beside) continue;
          const std::size_t number = number_of(other);
          if (number == taken.size())
            has_more[i] = 1;
          else
            pieces.unite(i, static_cast<std::uint32_t>(number));
        }
      }
    }
    std::vector<std::uint8_t> stays(taken.size(), 0);
    for (std::uint32_t i = 0; i < taken.size(); ++i)
      if (has_more[i] != 0) stays[pieces.find(i)] = 1;
    std::uint64_t gone = 0;
    for (std::uint32_t i = 0; i < taken.size(); ++i)
      gone += pieces.find(i) == i && stays[i] == 0 ? 1 : 0;
    return gone;
  }

  void add_touched(Mended& mended) const {
    std::vector<std::uint64_t>& touched = mended.touched;
    for (const Triangle64& t : mended.taken) touched.insert(touched.end(), t.begin(), t.end());
    for (const LoopPatch& patch : mended.patches)
      for (const Triangle64& t : patch.triangles)
        for (const std::uint64_t vertex : t)
          if (vertex < kNewVertex) touched.push_back(vertex);
    for (std::size_t l = 0; l < is_replaced_.size(); ++l) {
      const std::vector<std::uint64_t>& loop = filled_.loops[l].vertices;
      if (is_replaced_[l] != 0) touched.insert(touched.end(), loop.begin(), loop.end());
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const std::uint64_t vertex : touched) {
      const std::vector<OwnedTriangle> around = surface_.owned_at(vertex);
      if (around.empty()) mended.freed.push_back(vertex);
      for (const OwnedTriangle& owned : around) {
        if (owned.patch != OwnedTriangle::kScanned) continue;
        const Triangle64& t = owned.corners;
        const int k = t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
        mended.corners.push_back({t[(k + 2) % 3], vertex, t[(k + 1) % 3], 0});
      }
    }
  }

  const FilledSurface& filled_;
  PatchedSurface surface_;
  FillOptions options_;
  const StopToken* stop_;
  std::vector<std::uint8_t> is_replaced_;
  std::vector<Mend> mends_;
};

}  // namespace

std::vector<std::uint32_t> open_loops_of_solids(const HolePlan& plan,
                                                std::span<const HoleFacts> holes) {
  std::vector<std::uint32_t> open;
  if (!plan.is_object) return open;
  for (std::uint32_t l = 0; l < plan.loops.size(); ++l) {
    const bool was_to_be_filled = plan.is_wanted[l] != 0;
    const bool is_open = !holes[l].filled || holes[l].open_edges > 0;
    if (was_to_be_filled && is_open && plan.is_of_solid(l)) open.push_back(l);
  }
  return open;
}

std::vector<std::uint64_t> pinches_of_solids(const HolePlan& plan,
                                             std::span<const std::uint64_t> pinched,
                                             std::span<const OpenFan> fans) {
  std::vector<std::uint64_t> of_solids;
  if (!plan.is_object) return of_solids;
  const bool any_scene =
      std::find(plan.is_scene.begin(), plan.is_scene.end(), 1) != plan.is_scene.end();
  for (const std::uint64_t vertex : pinched) {
    auto at = std::lower_bound(
        fans.begin(), fans.end(), vertex,
        [](const OpenFan& fan, std::uint64_t number) { return fan.vertex < number; });
    bool is_of_scene = false, has_fans = false;
    for (; at != fans.end() && at->vertex == vertex; ++at) {
      has_fans = true;
      is_of_scene = is_of_scene || plan.is_scene[at->component] != 0;
    }
    if (has_fans ? !is_of_scene : !any_scene) of_solids.push_back(vertex);
  }
  return of_solids;
}

Mended mend_solids(const FilledSurface& filled, const Faults& faults, const FillOptions& options,
                   const StopToken* stop) {
  if (faults.loops.empty() && faults.pinched.empty()) return {};
  Mender mender(filled, options, stop);
  for (const std::uint32_t loop : faults.loops) mender.mend_loop(loop);
  for (const std::uint64_t vertex : faults.pinched) mender.mend_pinch(vertex);
  return mender.result();
}

}  // namespace orbweave
