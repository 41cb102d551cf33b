#include "engine/holes/fill_hole.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/holes/implicit/implicit_fill.h"
#include "engine/holes/loops/loop_parts.h"
#include "engine/holes/loops/parts_in_scene.h"
#include "engine/holes/patch/box_tree.h"
#include "engine/holes/patch/crease.h"
#include "engine/holes/patch/creased_fill.h"
#include "engine/holes/patch/direct_fill.h"
#include "engine/holes/patch/folded_patch.h"
#include "engine/holes/patch/patch_confidence.h"
#include "engine/holes/patch/patch_defect.h"
#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/patch/patch_values.h"
#include "engine/holes/patch/rim.h"
#include "engine/holes/patch/rim_piercings.h"
#include "engine/holes/patch/smooth_disc.h"
#include "engine/holes/patch/sound_part.h"
#include "engine/holes/patch/untangle.h"
#include "engine/holes/plane/plane_fill.h"
#include "engine/holes/plane/plane_grid.h"
#include "io/hole_facts.h"

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

HolePatch left_open(std::string reason, OpenReason open = OpenReason::kOther) {
  HolePatch patch;
  patch.open = open;
  patch.reason = std::move(reason);
  return patch;
}

/// a; b
std::string joined(std::string a, std::string_view b) {
  if (!a.empty() && !b.empty()) a += "; ";
  return a += b;
}

/// A patch of several parts has theirs already. What is missing of an open scene lies in the shadow
/// of something, and a rough rim runs over both.
void judge(const HoleProblem& problem, const PatchOptions& options, HolePatch& patch) {
  if (patch.confidence > 0.0 || !(rim_spacing(problem) > 0.0)) return;
  PatchEvidence evidence = evidence_of(problem, patch);
  evidence.in_object = !options.in_scene;
  patch.confidence = patch_confidence(evidence);
}

HolePatch left_open_in_scene() {
  return left_open(
      "every patch crosses the surface, and a wide gap of an open scene is not closed in part "
      "(fill.max_diameter)",
      OpenReason::kTooWide);
}

/// Whether a patch is wide, doubtful and of an open scene. Much area, more likely wrong than right,
/// would be invented. A wrong patch misses by about a tenth of its width, and edges along shadows
/// are two to three spacings long: a wrong patch of 8 edges misses by two spacings. Where the sheet
/// around the rim is parallel to the rim's plane, the surface does not lie far from that plane, and
/// a flat patch assumes less than others: both may be wider. `wider`: a factor of the limits.
bool is_wide_guess(const HoleProblem& problem, const PatchOptions& options, const HolePatch& patch,
                   double wider = 1.0) {
  // Mean lengths of the loop's edges.
  constexpr double kWide = 8.0, kWideInWall = 16.0, kWideFlat = 24.0;
  if (!options.whole || patch.method == FillMethod::kNone || patch.confidence >= kDoubtful)
    return false;
  const double width = evidence_of(problem, patch).width / wider;
  if (patch.is_flat) return width >= kWideFlat;
  return width >= kWideInWall || (width >= kWide && !rim_shape(problem).is_in_wall);
}

HolePatch left_open_as_guess() {
  static_assert(kDoubtful == 0.5, "the reason names it");
  return left_open(
      "a patch would be a guess (a confidence below 0.5), and a wide gap of an open scene is not "
      "closed by one (fill.max_diameter)",
      OpenReason::kTooWide);
}

constexpr const char* kCrosses = "the patch crosses the surface";
constexpr const char* kFoldsBack = "the patch folds back over the surface around it";

/// What the reason of a patch that closes its loop tells of the method that failed first. The fault
/// of a patch that was tried is not one of the patch that was taken.
std::string told_of_first(const std::string& fault) {
  constexpr std::string_view kThePatch = "the patch ";
  if (fault != kCrosses && fault != kFoldsBack) return fault;
  return "the first patch that was tried " + fault.substr(kThePatch.size());
}

/// What is told of a patch that closes its loop and folds back; empty of others.
std::string_view fault_of_folds(const HoleProblem& problem, const PatchOptions& options,
                                const HolePatch& patch) {
  return options.in_scene && is_folded(problem, patch) ? kFoldsBack : "";
}

/// The part of a patch that crosses nothing, where every patch crosses the surface.
HolePatch part_clear_of_surface(const HoleProblem& problem, HolePatch patch,
                                const std::vector<Contact>& contacts) {
  HolePatch part = sound_part(problem, std::move(patch), contacts);
  if (part.method == FillMethod::kNone) return left_open("every patch crosses the surface");
  if (part.open_edges > 0)
    part.reason = joined(part.reason, "open along " + std::to_string(part.open_edges) +
                                          " edges, where every patch crosses the surface");
  return part;
}

/// Triangles between a loop's corners alone.
struct Corners {
  HolePatch patch;
  std::vector<Contact> contacts;
  std::uint64_t avoidable = 0;  ///< of them
};

/// Tries methods until one gives a sound patch that meets nothing. Where none does, the best ones
/// are moved out of the way of what they meet.
class Attempts {
 public:
  /// `known`: triangles of the loop, where they were made before.
  Attempts(const HoleProblem& problem, const PatchOptions& options,
           std::optional<LoopTriangles> known = {})
      : problem_(problem), options_(options), loop_(std::move(known)) {
    if (loop_) rim_ = loop_->rim;
  }

  /// True when the patch is sound and meets nothing but what the loop's own edges meet: no other
  /// one is better. `known_contacts`: those that it has, where they were looked for before.
  bool take(HolePatch patch, std::optional<std::vector<Contact>> known_contacts = {}) {
    check_stop(options_.stop);
    if (patch.method == FillMethod::kNone) return fails(patch.reason, patch.open);
    if (const std::string defect = patch_defect(problem_, rim().faces, patch); !defect.empty()) {
      return fails(defect);
    }
    std::vector<Contact> contacts = known_contacts
                                        ? std::move(*known_contacts)
                                        : find_contacts(problem_, sheet(), patch, most_wanted());
    if (!contacts.empty()) {
      has_crossed_ = true;
      const std::uint64_t avoidable = piercings().count_avoidable(patch, contacts);
      tangled_.push_back({std::move(contacts), avoidable, std::move(patch)});
      fails(kCrosses);
      return avoidable == 0;
    }
    if (!fault_of_folds(problem_, options_, patch).empty()) {
      if (folded_.method == FillMethod::kNone) folded_ = std::move(patch);
      return fails(kFoldsBack);
    }
    best_ = std::move(patch);
    fewest_contacts_ = 0;
    return true;
  }

  bool try_plane() { return take(plane_fill(problem_, rim(), options_)); }
  bool try_implicit() {
    auto [patch, is_clear] = implicit_fill(problem_, loop(), sheet(), piercings(), options_);
    if (is_clear) return take(std::move(patch), std::vector<Contact>{});
    return take(std::move(patch));
  }
  bool try_membrane() { return take(membrane_fill(problem_, loop(), options_)); }
  /// What needs no plane. True also where nothing else is to be tried.
  bool try_smooth() {
    if (is_rough()) return try_membrane() || is_too_large();
    return try_implicit() || is_too_large() || is_hopeless() || try_membrane();
  }

  /// True when a flat patch meets nothing, if need be after it was moved out of the way: a smooth
  /// one that meets nothing bulges out of a crease or a recess. A flat patch that still meets
  /// something is one of many, unless is_flat_in_part() says otherwise.
  bool try_flat() {
    const FlatCall call = call_for_flat_patch(problem_, rim());
    if (call.recess && (settles(recessed_fill(problem_, loop(), *call.recess, options_),
                                "flat, at the ground of a recess") ||
                        is_flat_in_part()))
      return true;
    return (call.is_crease && settles(membrane_fill(problem_, loop(), options_),
                                      "flat, because the surface turns away all along the rim")) ||
           is_flat_in_part();
  }
  /// True when planes around the hole meet in an edge that the patch goes on with, if need be after
  /// it was moved out of the way: a smooth one rounds the edge off. Where they do not meet, nothing
  /// was tried.
  bool try_creased() {
    HolePatch patch = creased_fill(problem_, rim(), options_);
    if (patch.method == FillMethod::kNone && patch.reason.empty()) return false;
    if (take(std::move(patch))) return true;
    if (!comes_clear()) return false;
    if (fault_of_folds(problem_, options_, best_).empty()) return true;
    folded_ = std::move(best_);
    give_up_best();
    return fails(kFoldsBack);
  }
  bool try_direct() {
    Corners corners = std::move(of_corners());
    corners_.reset();
    return take(std::move(corners.patch), std::move(corners.contacts));
  }

  /// A hole that calls for too many points is not closed by a few large triangles instead.
  bool is_too_large() const { return too_large_ && tangled_.empty(); }

  /// True where no patch will come to be clear of the surface, and a part of one does not do: the
  /// loop's own edges run into it, or the patch that meets it least does so too often to be moved.
  bool is_hopeless() {
    if (!options_.whole) return false;
    if (piercings().any()) return true;
    return is_tangled() && std::none_of(tangled_.begin(), tangled_.end(), may_be_untangled);
  }

  /// True where triangles between the corners alone meet the surface so often that no patch will
  /// come to be clear of it, and a part of one does not do. What was tried before is dropped then.
  bool is_crumpled() {
    if (!options_.whole || has_folded()) return false;
    if (of_corners().contacts.size() <= kMostOfCorners) return false;
    has_crossed_ = true;
    tangled_.clear();
    return true;
  }

  /// True where triangles between the corners alone tell that a patch would be a guess: a smooth
  /// one has about their area, and meets the rim at about their angles. The guesses of nine scans
  /// but one are told so, and two narrower doubtful patches.
  bool is_guess() {
    constexpr double kWider = 9.0 / 8.0;  // than a guess has to be
    if (!options_.whole) return false;
    HolePatch& corners = of_corners().patch;
    if (corners.method == FillMethod::kNone) return false;
    judge(problem_, options_, corners);
    is_guess_ = is_wide_guess(problem_, options_, corners, kWider);
    return is_guess_;
  }

  /// True where triangles between the corners alone meet the surface oftener than at every other
  /// edge of the loop. A smooth patch does so, too, most of the time, and takes several times as
  /// long as all else that is tried: of 386 such loops of six scans 7 came to be clear by one, of
  /// the 90 with more than 32 contacts none.
  bool is_rough() {
    constexpr std::uint64_t kFew = 8;
    const std::uint64_t least = options_.whole ? kMostContacts : kFew;
    return of_corners().avoidable > std::max<std::uint64_t>(least, problem_.loop.size() / 2);
  }

  bool is_tangled() const { return !tangled_.empty(); }
  /// Whether there is a patch that meets nothing and folds back over the sheet around it.
  bool has_folded() const { return folded_.method != FillMethod::kNone; }

  /// Of the problem's sheet.
  const BoxTree& sheet() {
    if (!sheet_) sheet_ = BoxTree::of_sheet(problem_.positions, problem_.sheet);
    return *sheet_;
  }

  HolePatch result() {
    if (is_guess_) return left_open_as_guess();
    if (best_.method == FillMethod::kNone && has_folded()) {
      best_ = std::move(folded_);
      fewest_contacts_ = 0;
    }
    if (best_.method == FillMethod::kNone) untangle_best();
    if (options_.whole && has_crossed_ && fewest_contacts_ > 0)
      return flat_part_of(std::move(best_), least_contacts_);
    if (best_.method == FillMethod::kNone) {
      return left_open(last_fault_ == first_fault_ ? first_fault_
                                                   : joined(first_fault_, last_fault_));
    }
    give_values(problem_, best_);
    judge(problem_, options_, best_);
    if (fewest_contacts_ == 0) {
      const std::string_view fold = fault_of_folds(problem_, options_, best_);
      const bool is_told = first_fault_ == kFoldsBack && !fold.empty();
      best_.reason = joined(is_told ? first_fault_ : told_of_first(first_fault_), best_.reason);
      if (!is_told) best_.reason = joined(best_.reason, fold);
      return std::move(best_);
    }
    if (!options_.allow_intersections)
      return part_clear_of_surface(problem_, std::move(best_), least_contacts_);
    best_.reason = joined(best_.reason, "every patch crosses the surface, this one " +
                                            std::to_string(fewest_contacts_) + " times");
    return std::move(best_);
  }

 private:
  struct Tangled {
    std::vector<Contact> contacts;
    std::uint64_t avoidable = 0;  ///< of them
    HolePatch patch;
  };
  /// Hardly any patch of a wide loop in real scans that started with more contacts came to be
  /// clear.
  static constexpr std::size_t kMostContacts = 32;
  /// Of triangles between the corners alone, where no part of a patch does. On six scans 3 of 26
  /// such loops came to be closed at 81 to 160, none of 6 beyond.
  static constexpr std::size_t kMostOfCorners = 160;
  /// Of 289 patches of three scans that started with more avoidable contacts 10 came to be clear,
  /// after two fifths of all time that untangling took.
  static constexpr std::uint64_t kMostUntangled = 16;
  static bool may_be_untangled(const Tangled& candidate) {
    return candidate.contacts.size() <= kMostContacts;
  }
  /// How many contacts of a patch are looked for: where more leave the hole open, no more than
  /// show that.
  std::uint64_t most_wanted() const { return options_.whole ? kMostContacts + 1 : UINT64_MAX; }

  /// Made once, for all that ask.
  Corners& of_corners() {
    if (corners_) return *corners_;
    corners_.emplace();
    corners_->patch = direct_fill(problem_, loop());
    if (corners_->patch.method == FillMethod::kNone) return *corners_;
    const std::uint64_t most = options_.whole ? kMostOfCorners + 1 : UINT64_MAX;
    corners_->contacts = find_contacts(problem_, sheet(), corners_->patch, most);
    corners_->avoidable = piercings().count_avoidable(corners_->patch, corners_->contacts);
    return *corners_;
  }

  const RimPiercings& piercings() {
    if (!piercings_) piercings_.emplace(problem_, sheet());
    return *piercings_;
  }

  const Rim& rim() {
    if (!rim_) rim_ = find_rim(problem_);
    return *rim_;
  }

  const LoopTriangles& loop() {
    if (!loop_) loop_ = triangles_of_loop(problem_, rim());
    return *loop_;
  }

  void untangle_best() {
    // Of 583 third ones of three scans 13 came to be clear.
    constexpr std::size_t kMostCandidates = 2;
    // One that starts with so many more than are left of another does not come to fewer.
    const std::uint64_t most_times = piercings().any() ? 6 : 8;
    std::stable_sort(tangled_.begin(), tangled_.end(), [](const Tangled& a, const Tangled& b) {
      return a.contacts.size() < b.contacts.size();
    });
    if (tangled_.size() > kMostCandidates) tangled_.resize(kMostCandidates);
    if (options_.whole)
      std::erase_if(tangled_, [](const Tangled& each) { return !may_be_untangled(each); });
    std::uint64_t least_avoidable = UINT64_MAX / most_times - 1;
    for (Tangled& candidate : tangled_) {
      if (candidate.avoidable > most_times * (least_avoidable + 1)) continue;
      std::vector<Contact> left = std::move(candidate.contacts);
      if (candidate.avoidable <= kMostUntangled)
        left = untangle(problem_, piercings(), sheet(), std::move(left), candidate.patch);
      if (left.size() >= fewest_contacts_) continue;
      fewest_contacts_ = left.size();
      least_avoidable = piercings().count_avoidable(candidate.patch, left);
      best_ = std::move(candidate.patch);
      least_contacts_ = std::move(left);
      if (least_avoidable == 0) return;
    }
  }

  /// Whether the gap is a wide one of an open scene, and the best patch so far is flat and closes
  /// most of the loop without what crosses. Smooth patches that reach around something in a window
  /// are guesses: none is tried then.
  bool is_flat_in_part() const {
    if (!options_.whole || !is_tangled()) return false;
    const Tangled& best = tangled_.back();
    return flat_part_of(best.patch, best.contacts).method != FillMethod::kNone;
  }

  /// The clear part of a flat patch: the patch lies where the wall or the ground of a recess does,
  /// also beside what stands in the gap. The loop stays open where the patch is not flat, where the
  /// patch is doubtful, and where more than a quarter of the loop would stay open. Where the loop
  /// is a part of another (allow_intersections), the whole patch is returned: which triangles cross
  /// is known once all parts are together.
  HolePatch flat_part_of(HolePatch patch, const std::vector<Contact>& contacts) const {
    constexpr std::uint32_t kMostOpen = 4;  // one edge of so many
    if (!patch.is_flat) return left_open_in_scene();
    give_values(problem_, patch);
    judge(problem_, options_, patch);
    if (patch.confidence < kDoubtful) return left_open_in_scene();
    HolePatch part = part_clear_of_surface(problem_, patch, contacts);
    if (part.method == FillMethod::kNone || kMostOpen * part.open_edges > problem_.loop.size())
      return left_open_in_scene();
    return options_.allow_intersections ? std::move(patch) : std::move(part);
  }

  bool settles(HolePatch patch, const char* reason) {
    patch.reason = joined(reason, patch.reason);
    patch.is_flat = true;
    take(std::move(patch));
    return comes_clear();
  }

  /// Whether a patch meets nothing, if need be after the best ones were moved. Where none comes to
  /// be clear, the best one is put back.
  bool comes_clear() {
    if (fewest_contacts_ > 0 && is_tangled()) untangle_best();
    if (fewest_contacts_ == 0) return true;
    if (is_tangled()) put_back();
    return false;
  }

  /// Takes back what has become of the patches: others are tried first.
  void put_back() {
    const std::uint64_t avoidable = piercings().count_avoidable(best_, least_contacts_);
    Tangled moved{std::move(least_contacts_), avoidable, std::move(best_)};
    give_up_best();
    tangled_.push_back(std::move(moved));
  }

  void give_up_best() {
    tangled_.clear();
    best_ = {};
    least_contacts_ = {};
    fewest_contacts_ = UINT64_MAX;
  }

  bool fails(const std::string& fault, OpenReason open = OpenReason::kOther) {
    (first_fault_.empty() ? first_fault_ : last_fault_) = fault;
    too_large_ = too_large_ || open == OpenReason::kTooManyPoints;
    return false;
  }

  const HoleProblem& problem_;
  const PatchOptions& options_;
  std::optional<Rim> rim_;
  std::optional<LoopTriangles> loop_;
  std::optional<RimPiercings> piercings_;
  std::optional<BoxTree> sheet_;
  std::optional<Corners> corners_;
  std::vector<Tangled> tangled_;
  HolePatch best_;
  HolePatch folded_;  ///< the first that meets nothing but folds back
  std::uint64_t fewest_contacts_ = UINT64_MAX;
  std::vector<Contact> least_contacts_;  ///< of best_
  std::string first_fault_;              ///< of the simplest method
  std::string last_fault_;
  bool too_large_ = false;
  bool has_crossed_ = false;
  bool is_guess_ = false;
};

/// A few triangles meet what they meet whatever the method: looked for only where that matters.
HolePatch fill_small(const HoleProblem& problem, const PatchOptions& options) {
  HolePatch patch = direct_fill(problem);
  if (patch.method == FillMethod::kNone) return patch;
  if (std::string defect = patch_defect(problem, patch); !defect.empty()) {
    return left_open(std::move(defect));
  }
  judge(problem, options, patch);
  patch.reason = joined(patch.reason, fault_of_folds(problem, options, patch));
  if (options.allow_intersections) return patch;
  const std::vector<Contact> contacts = find_contacts(problem, patch);
  return part_clear_of_surface(problem, std::move(patch), contacts);
}

/// A loop whose corners are all different. `known`: its triangles, where they were made before.
HolePatch fill_simple(const HoleProblem& problem, const PatchOptions& options,
                      std::optional<LoopTriangles> known = {}) {
  if (is_closed_directly(problem, options)) return fill_small(problem, options);
  Attempts attempts(problem, options, std::move(known));
  if (attempts.is_hopeless()) return left_open_in_scene();
  const bool is_done = options.flat ? attempts.try_membrane() || attempts.is_too_large()
                                    : attempts.try_creased() || attempts.try_flat() ||
                                          attempts.try_plane() || attempts.is_crumpled() ||
                                          attempts.is_guess() || attempts.try_smooth();
  if (!is_done) attempts.try_direct();
  return attempts.result();
}

/// Parts close their loops whole. Which of their triangles cross the surface is known once all
/// parts are together.
HolePatch fill_parts(const HoleProblem& problem, const BoxTree& sheet, PatchOptions options,
                     PartsInScene& parts) {
  options.allow_intersections = true;
  HolePatch patch = fill_by_parts(problem, sheet, [&](const HoleProblem& part, std::size_t number) {
    constexpr std::size_t kFewEdges = 24;
    HolePatch closed = fill_simple(part, options, parts.take_triangles(part, number));
    // A small part that no patch closes clear of the surface does not keep the others open.
    const bool is_small =
        2 * part.loop.size() < problem.loop.size() && part.loop.size() <= kFewEdges;
    return closed.method == FillMethod::kNone && is_small ? direct_fill(part) : closed;
  });
  if (patch.method != FillMethod::kNone) patch.reason = "taken apart where the loop touches itself";
  return patch;
}

HolePatch fill_canonical(const HoleProblem& problem, const PatchOptions& options) {
  if (simple_parts(problem.loop).empty()) return fill_simple(problem, options);
  Attempts attempts(problem, options);
  if (attempts.is_hopeless()) return left_open_in_scene();
  PartsInScene in_scene(problem, attempts.sheet(), options);
  if (in_scene.is_hopeless()) return left_open_in_scene();
  // Two holes that touch are two holes. Triangles between all corners meet more than the parts do.
  HolePatch parts = fill_parts(problem, attempts.sheet(), options, in_scene);
  if (options.whole && parts.method == FillMethod::kNone) return parts;
  const bool is_done = attempts.take(std::move(parts)) || attempts.is_too_large();
  // Where the patches of a longer loop's parts fold back, triangles between all corners do, too:
  // those of 246 of 247 such loops of nine scans.
  constexpr std::size_t kFewEdges = 24;
  const bool is_enough =
      attempts.is_tangled() || (attempts.has_folded() && problem.loop.size() > kFewEdges);
  if (!is_done && !is_enough) attempts.try_direct();
  return attempts.result();
}

/// What makes a problem none; empty: it is one.
std::string fault_of(const HoleProblem& problem) {
  if (problem.loop.size() < 3) return "fewer than three edges";
  for (const std::uint32_t v : problem.loop) {
    if (v >= problem.positions.size()) return "a corner is not among the vertices";
  }
  if (!std::all_of(problem.positions.begin(), problem.positions.end(), is_finite)) {
    return "a vertex is not finite";
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
  const RimAngles angles = rim_angles(problem, patch);
  patch.rim_dihedral_rad = angles.largest;
  patch.rim_mean_rad = angles.mean;
  patch.confidence *= 1.0 - patch.open_edges / static_cast<double>(problem.loop.size());
  if (is_wide_guess(problem, options, patch)) return left_open_as_guess();
  return patch;
}

std::uint64_t expected_new_points(std::uint64_t edges, bool graded) {
  const double most = PatchOptions{}.max_new_points;
  return static_cast<std::uint64_t>(std::min(expected_grid_points(edges, graded), most));
}

}  // namespace orbweave
