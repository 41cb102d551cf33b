#include "engine/holes/fill_hole.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "engine/holes/direct_fill.h"
#include "engine/holes/implicit_fill.h"
#include "engine/holes/patch_intersections.h"
#include "engine/holes/plane_fill.h"
#include "engine/holes/rim.h"
#include "engine/holes/smooth_disc.h"

namespace orbweave {
namespace {

/// The smallest rotation of a loop, the same wherever it began.
std::vector<std::uint32_t> canonical_loop(const std::vector<std::uint32_t>& loop) {
  const std::uint32_t smallest = *std::min_element(loop.begin(), loop.end());
  std::vector<std::uint32_t> best;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    if (loop[i] != smallest) continue;
    std::vector<std::uint32_t> rotated(loop.begin() + static_cast<std::ptrdiff_t>(i), loop.end());
    rotated.insert(rotated.end(), loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(i));
    if (best.empty() || rotated < best) best = std::move(rotated);
  }
  return best;
}

HolePatch left_open(std::string reason) {
  HolePatch patch;
  patch.reason = std::move(reason);
  return patch;
}

/// Tries methods until one does.
class Attempts {
 public:
  Attempts(const HoleProblem& problem, const PatchOptions& options)
      : problem_(problem), options_(options) {}

  using Method = HolePatch (*)(const HoleProblem&, const PatchOptions&);
  /// True when the method's patch is sound and meets nothing.
  bool try_method(std::string_view name, Method method) {
    HolePatch patch = method(problem_, options_);
    if (patch.method == FillMethod::kNone) {
      add_reason(name, patch.reason);
      too_large_ = too_large_ || patch.reason == too_many_points(options_);
      return false;
    }
    if (const std::string defect = patch_defect(problem_, patch); !defect.empty()) {
      add_reason(name, defect);
      return false;
    }
    const std::uint64_t contacts = count_intersections(problem_, patch, fewest_contacts_);
    if (contacts > 0) add_reason(name, "meets the surface");
    if (contacts < fewest_contacts_) {
      best_ = std::move(patch);
      fewest_contacts_ = contacts;
    }
    return contacts == 0;
  }

  /// A hole that calls for too many points is not closed by a few large triangles instead.
  bool is_too_large() const { return too_large_ && best_.method == FillMethod::kNone; }

  HolePatch result() {
    if (best_.method == FillMethod::kNone) return left_open(reasons_);
    if (fewest_contacts_ > 0 && !options_.allow_intersections) return left_open(reasons_);
    if (best_.reason.empty()) {
      best_.reason = std::move(reasons_);
    } else if (!reasons_.empty()) {
      best_.reason = reasons_ + "; " + best_.reason;
    }
    return std::move(best_);
  }

 private:
  void add_reason(std::string_view name, std::string_view reason) {
    if (!reasons_.empty()) reasons_ += "; ";
    reasons_ += name;
    reasons_ += ": ";
    reasons_ += reason;
  }

  const HoleProblem& problem_;
  const PatchOptions& options_;
  HolePatch best_;
  std::uint64_t fewest_contacts_ = UINT64_MAX;
  std::string reasons_;
  bool too_large_ = false;
};

HolePatch fill_directly(const HoleProblem& problem, const PatchOptions&) {
  return direct_fill(problem);
}

/// A few triangles meet what they meet whatever the method: looked for only where that matters.
HolePatch fill_small(const HoleProblem& problem, const PatchOptions& options) {
  HolePatch patch = direct_fill(problem);
  if (patch.method == FillMethod::kNone) return patch;
  if (std::string defect = patch_defect(problem, patch); !defect.empty()) {
    return left_open(std::move(defect));
  }
  if (!options.allow_intersections && count_intersections(problem, patch, 1) > 0) {
    return left_open("direct: meets the surface");
  }
  return patch;
}

HolePatch fill_canonical(const HoleProblem& problem, const PatchOptions& options) {
  const bool has_extent = rim_spacing(problem) > 0.0;
  if (problem.loop.size() <= options.direct_edges || !has_extent) {
    return fill_small(problem, options);
  }
  Attempts attempts(problem, options);
  const bool is_done = attempts.try_method("plane", plane_fill) ||
                       attempts.try_method("implicit", implicit_fill) || attempts.is_too_large() ||
                       attempts.try_method("membrane", membrane_fill);
  if (!is_done) attempts.try_method("direct", fill_directly);
  return attempts.result();
}

/// What makes a problem none; empty: it is one.
std::string fault_of(const HoleProblem& problem) {
  if (problem.loop.size() < 3) return "fewer than three edges";
  for (const std::uint32_t v : problem.loop) {
    if (v >= problem.positions.size()) return "a corner is not among the vertices";
    if (!is_finite(problem.positions[v])) return "a corner is not finite";
  }
  return {};
}

}  // namespace

HolePatch fill_hole(const HoleProblem& problem, const PatchOptions& options) {
  if (std::string fault = fault_of(problem); !fault.empty()) return left_open(std::move(fault));
  std::vector<std::uint32_t> loop = canonical_loop(problem.loop);
  HolePatch patch;
  if (loop == problem.loop) {
    patch = fill_canonical(problem, options);
  } else {
    HoleProblem rotated = problem;
    rotated.loop = std::move(loop);
    patch = fill_canonical(rotated, options);
  }
  patch.rim_dihedral_rad = rim_dihedral(problem, patch);
  return patch;
}

}  // namespace orbweave
