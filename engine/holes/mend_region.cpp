#include "engine/holes/mend_region.h"

#include <algorithm>
#include <utility>

#include "engine/holes/loops/split_vertices.h"
#include "engine/holes/patch/patch_intersections.h"

namespace orbweave {
namespace {

constexpr int kMostAttempts = 12;
/// A gap of so many edges takes long to fill: fewer attempts.
constexpr std::size_t kLargeGap = 500;
constexpr int kAttemptsAtLarge = 4;
/// A patch that runs into more is in the way of a surface, not of a few triangles.
constexpr std::size_t kMostContacts = 500;
/// A component of no more triangles that only the gap held is given up with it.
constexpr std::size_t kLoose = 64;
/// What hangs together does so within so many triangles.
constexpr std::size_t kFarthest = 50'000;

bool is_scanned(const OwnedTriangle& t) { return t.patch == OwnedTriangle::kScanned; }

std::vector<std::vector<OwnedTriangle>> fans_at(const PatchedSurface& surface,
                                                std::uint64_t vertex) {
  const std::vector<OwnedTriangle> around = surface.owned_at(vertex);
  std::vector<Triangle64> triangles;
  for (const OwnedTriangle& t : around) triangles.push_back(t.corners);
  const std::vector<std::uint32_t> group = fan_groups(triangles, vertex);
  std::vector<std::vector<OwnedTriangle>> fans;
  for (std::size_t i = 0; i < around.size(); ++i) {
    if (group[i] == fans.size()) fans.emplace_back();
    fans[group[i]].push_back(around[i]);
  }
  return fans;
}

/// Numbers of vertices among themselves.
class LocalVertices {
 public:
  explicit LocalVertices(const PatchedSurface& surface) : surface_(surface) {}

  void list(const Triangle64& t) { vertices_.insert(vertices_.end(), t.begin(), t.end()); }
  void number() {
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
  }
  std::vector<Vec3> positions() const {
    std::vector<Vec3> at;
    for (const std::uint64_t vertex : vertices_) at.push_back(surface_.position(vertex));
    return at;
  }
  Triangle of(const Triangle64& t) const {
    Triangle local{};
    for (int k = 0; k < 3; ++k)
      local[k] = static_cast<std::uint32_t>(
          std::lower_bound(vertices_.begin(), vertices_.end(), t[k]) - vertices_.begin());
    return local;
  }

 private:
  const PatchedSurface& surface_;
  std::vector<std::uint64_t> vertices_;
};

}  // namespace

void RegionMender::add_edge(std::uint64_t tail, std::uint64_t head) {
  if (rim_.erase({head, tail}) == 0) rim_.insert({tail, head});
}

void RegionMender::take(const Triangle64& t) {
  if (surface_.taken().contains(t)) return;
  surface_.take(t);
  taken_.push_back(t);
  for (int k = 0; k < 3; ++k) add_edge(t[k], t[(k + 1) % 3]);
}

void RegionMender::drop(std::uint32_t patch) {
  if (std::find(dropped_.begin(), dropped_.end(), patch) != dropped_.end()) return;
  dropped_.push_back(patch);
  if (surface_.has_patch(patch)) {
    had_patch_.push_back(patch);
    surface_.drop(patch);
  }
  const auto add_loop = [&](std::span<const std::uint64_t> loop) {
    for (std::size_t i = 0; i < loop.size(); ++i) add_edge(loop[i], loop[(i + 1) % loop.size()]);
  };
  if (patch >= loops_.size()) {
    add_loop(surface_.rim_of_added(patch));
    return;
  }
  for (const std::uint32_t loop : surface_.loops_of_patch(patch)) add_loop(loops_[loop].vertices);
}

void RegionMender::give_up(const OwnedTriangle& t) {
  if (is_scanned(t))
    take(t.corners);
  else
    drop(t.patch);
}

void RegionMender::take_around(std::uint64_t vertex) {
  for (const OwnedTriangle& t : surface_.owned_at(vertex))
    if (is_scanned(t)) take(t.corners);
}

void RegionMender::take_around(const Triangle64& t) {
  for (const std::uint64_t vertex : t)
    if (vertex < kNewVertex) take_around(vertex);
}

/// Edges of the rim that no triangle has on the other side are those of a loop that is open, too.
bool RegionMender::join_open_loops(bool& any) {
  const std::vector<Edge> rim(rim_.begin(), rim_.end());
  for (const Edge& edge : rim) {
    if (!rim_.contains(edge) || surface_.along(edge[1], edge[0])) continue;
    std::optional<std::uint32_t> open;
    for (const std::uint32_t loop : surface_.loops_at(edge[1])) {
      const std::vector<std::uint64_t>& at = loops_[loop].vertices;
      for (std::size_t i = 0; i < at.size(); ++i)
        if (at[i] == edge[1] && at[(i + 1) % at.size()] == edge[0])
          open = surface_.patch_of_loop(loop);
    }
    const bool is_known =
        open && std::find(dropped_.begin(), dropped_.end(), *open) == dropped_.end();
    if (!is_known || !surface_.may_be_filled(*open)) return false;
    drop(*open);
    any = true;
  }
  return true;
}

/// Every vertex of the rim keeps its largest fan.
bool RegionMender::leave_one_fan_each(bool& any) {
  std::vector<std::uint64_t> vertices;
  for (const Edge& edge : rim_) vertices.push_back(edge[0]);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (const std::uint64_t vertex : vertices) {
    const auto fans = fans_at(surface_, vertex);
    if (fans.size() < 2) continue;
    const auto largest = std::max_element(
        fans.begin(), fans.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    for (auto fan = fans.begin(); fan != fans.end(); ++fan)
      if (fan != largest)
        for (const OwnedTriangle& t : *fan) give_up(t);
    any = true;
  }
  return taken_.size() <= most_taken_;
}

bool RegionMender::is_small_component(const OwnedTriangle& from,
                                      std::set<OwnedTriangle>& seen) const {
  seen = {from};
  std::vector<OwnedTriangle> next = {from};
  while (!next.empty()) {
    const OwnedTriangle t = next.back();
    next.pop_back();
    for (int k = 0; k < 3; ++k) {
      const auto beside = surface_.along(t.corners[(k + 1) % 3], t.corners[k]);
      if (beside && seen.insert(*beside).second) next.push_back(*beside);
      if (seen.size() > kLoose) return false;
    }
  }
  return true;
}

/// Components that only the gap held.
bool RegionMender::take_what_hangs_loose(bool& any) {
  std::set<OwnedTriangle> done, seen;
  std::vector<OwnedTriangle> loose;
  bool has_large = false;
  for (const Edge& edge : rim_) {
    const auto beside = surface_.along(edge[1], edge[0]);
    if (!beside || done.contains(*beside)) continue;
    const bool is_small = is_small_component(*beside, seen);
    done.insert(seen.begin(), seen.end());
    if (is_small)
      loose.insert(loose.end(), seen.begin(), seen.end());
    else
      has_large = true;
  }
  if (loose.empty()) return true;
  if (!has_large) return false;
  for (const OwnedTriangle& t : loose) give_up(t);
  any = true;
  return taken_.size() <= most_taken_;
}

/// Widens the gap until its rims are simple loops in one surface.
bool RegionMender::settle_rim() {
  for (bool any = true; any;) {
    any = false;
    if (!join_open_loops(any) || !leave_one_fan_each(any)) return false;
    if (!any && !take_what_hangs_loose(any)) return false;
  }
  return true;
}

std::vector<BoundaryLoop> RegionMender::gaps() const {
  std::vector<OpenFan> fans;
  std::vector<BoundaryVertex> vertices;
  std::vector<Edge> arriving;  // (head, tail)
  for (const Edge& edge : rim_) arriving.push_back({edge[1], edge[0]});
  std::sort(arriving.begin(), arriving.end());
  std::vector<Triangle64> around;
  for (const Edge& edge : rim_) {
    const auto before = std::lower_bound(arriving.begin(), arriving.end(), Edge{edge[0], 0});
    if (before == arriving.end() || (*before)[0] != edge[0]) return {};
    // The triangles beside the rim run along it the other way.
    fans.push_back({edge[1], edge[0], (*before)[1], 0});
    BoundaryVertex vertex{edge[0], surface_.position(edge[0]), {}};
    around.clear();
    surface_.triangles_at(edge[0], around);
    for (const Triangle64& t : around) {
      const Vec3 a = surface_.position(t[0]);
      vertex.normal =
          vertex.normal + cross(surface_.position(t[1]) - a, surface_.position(t[2]) - a);
    }
    vertices.push_back(vertex);
  }
  return trace_loops(std::move(fans), vertices);
}

/// Whether one surface lies beside all rims: the patches over them neither join nor part any.
bool RegionMender::hangs_together(std::span<const BoundaryLoop> gaps) const {
  if (gaps.size() < 2) return true;
  std::set<OwnedTriangle> wanted;
  for (const BoundaryLoop& gap : gaps) {
    const auto beside = surface_.along(gap.vertices[1], gap.vertices[0]);
    if (!beside) return false;
    wanted.insert(*beside);
  }
  std::set<OwnedTriangle> seen = {*wanted.begin()};
  std::vector<OwnedTriangle> ring = {*wanted.begin()}, beyond;
  wanted.erase(wanted.begin());
  while (!ring.empty() && !wanted.empty() && seen.size() < kFarthest) {
    beyond.clear();
    for (const OwnedTriangle& t : ring) {
      for (int k = 0; k < 3; ++k) {
        const auto beside = surface_.along(t.corners[(k + 1) % 3], t.corners[k]);
        if (!beside || !seen.insert(*beside).second) continue;
        wanted.erase(*beside);
        beyond.push_back(*beside);
      }
    }
    ring.swap(beyond);
  }
  return wanted.empty();
}

bool RegionMender::fill(const BoundaryLoop& gap, bool flat) {
  HoleFacts known;
  known.first_vertex = gap.vertices.front();
  known.edges = gap.vertices.size();
  known.perimeter = gap.perimeter;
  known.diameter = 2.0 * gap.radius;
  known.center = gap.center;
  LoopPatch patch = fill_loop(surface_, gap, {}, known, options_, stop_, {.flat = flat});
  if (patch.facts.open == OpenReason::kTooManyPoints) is_hopeless_ = true;
  if (!patch.facts.filled || patch.facts.open_edges > 0) return false;
  // Triangles at new vertices of other patches keep their numbers: a rim has scanned vertices only.
  trials_.push_back({gap.vertices, surface_.add(std::move(patch), gap.vertices)});
  return true;
}

std::uint64_t RegionMender::contacts_of(const Trial& trial,
                                        std::vector<std::array<OwnedTriangle, 2>>& found) {
  std::vector<OwnedTriangle> own = surface_.triangles_of(trial.patch), others;
  Box box;
  for (const OwnedTriangle& t : own) box.extend(surface_.box_of(t.corners));
  for (const OwnedTriangle& t : surface_.near(box))
    if (t.patch != trial.patch) others.push_back(t);
  LocalVertices vertices(surface_);
  for (const OwnedTriangle& t : own) vertices.list(t.corners);
  for (const OwnedTriangle& t : others) vertices.list(t.corners);
  vertices.number();
  std::vector<Triangle> patch, sheet;
  for (const OwnedTriangle& t : own) patch.push_back(vertices.of(t.corners));
  for (const OwnedTriangle& t : others) sheet.push_back(vertices.of(t.corners));
  const std::vector<Contact> contacts = find_contacts(vertices.positions(), patch, sheet);
  for (const Contact& contact : contacts) {
    const std::size_t second = contact[1];
    found.push_back(
        {own[contact[0]], second < own.size() ? own[second] : others[second - own.size()]});
  }
  return contacts.size();
}

/// Gives up what patches run into, and what lies at the rim where they do.
void RegionMender::widen(std::span<const std::array<OwnedTriangle, 2>> contacts,
                         std::span<const BoundaryLoop> gaps) {
  const std::size_t before = taken_.size() + dropped_.size();
  for (const std::array<OwnedTriangle, 2>& contact : contacts) {
    const OwnedTriangle& own = contact[0];
    const OwnedTriangle& other = contact[1];
    take_around(own.corners);
    const bool is_trial = std::any_of(trials_.begin(), trials_.end(), [&](const Trial& trial) {
      return trial.patch == other.patch;
    });
    if (is_trial)
      take_around(other.corners);
    else
      give_up(other);
    if (taken_.size() > most_taken_) return;
  }
  if (taken_.size() + dropped_.size() > before) return;
  for (const BoundaryLoop& gap : gaps)
    for (const std::uint64_t vertex : gap.vertices) take_around(vertex);
}

void RegionMender::take_back_trials() {
  while (!trials_.empty()) {
    surface_.remove_last();
    trials_.pop_back();
  }
}

void RegionMender::take_back_all() {
  take_back_trials();
  for (const Triangle64& t : taken_) surface_.put_back(t);
  for (const std::uint32_t patch : had_patch_) surface_.restore(patch);
}

/// Whether there is something to mend.
bool RegionMender::begin(const RegionFault& fault) {
  if (fault.patch) {
    drop(*fault.patch);
  } else {
    const auto fans = fans_at(surface_, fault.vertex);
    if (fans.size() < 2) return false;
    const auto largest = std::max_element(
        fans.begin(), fans.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    for (auto fan = fans.begin(); fan != fans.end(); ++fan)
      if (fan != largest)
        for (const OwnedTriangle& t : *fan) give_up(t);
  }
  constexpr std::size_t kLeast = 200, kPerEdge = 4;
  most_taken_ = std::max(kLeast, kPerEdge * rim_.size());
  return true;
}

bool RegionMender::close() {
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    check_stop(stop_);
    if (!settle_rim() || taken_.size() > most_taken_) return false;
    const std::vector<BoundaryLoop> all = gaps();
    std::size_t edges = 0;
    for (const BoundaryLoop& gap : all) edges += gap.vertices.size();
    if (edges != rim_.size() || !hangs_together(all)) return false;
    if (edges > kLargeGap && attempt >= kAttemptsAtLarge) return false;
    std::vector<std::array<OwnedTriangle, 2>> contacts;
    std::vector<BoundaryLoop> unfilled;
    for (const bool flat : {false, true}) {
      take_back_trials();
      contacts.clear();
      unfilled.clear();
      for (const BoundaryLoop& gap : all)
        if (!fill(gap, flat)) unfilled.push_back(gap);
      if (is_hopeless_) return false;
      for (const Trial& trial : trials_) contacts_of(trial, contacts);
      if (contacts.empty() && unfilled.empty()) return true;
      if (flat) break;
    }
    if (contacts.size() > kMostContacts) return false;
    for (const BoundaryLoop& gap : unfilled)
      for (const std::uint64_t vertex : gap.vertices) take_around(vertex);
    if (!contacts.empty()) widen(contacts, all);
    take_back_trials();
  }
  return false;
}

std::optional<RegionMend> RegionMender::mend(const RegionFault& fault) {
  if (!begin(fault)) return std::nullopt;
  if (!close()) {
    take_back_all();
    return std::nullopt;
  }
  RegionMend mend;
  for (const Trial& trial : trials_) mend.added.push_back(trial.patch);
  mend.dropped = dropped_;
  return mend;
}

}  // namespace orbweave
