#include "engine/holes/patch/untangle.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "engine/geometry/triangle_intersection.h"
#include "engine/holes/patch/box_tree.h"
#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/patch/patch_values.h"
#include "engine/holes/patch/rim.h"
#include "io/box.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kMostContacts = 1000;
/// Places that are tried for a vertex lie this far from it, rim spacings.
constexpr std::array<double, 3> kSteps = {0.25, 0.6, 1.2};
constexpr int kRounds = 5;

/// The plane of a triangle: on which side of it a place lies, where doubles can tell.
class QuickPlane {
 public:
  QuickPlane(Vec3 a, Vec3 b, Vec3 c) : a_(a), normal_(cross(b - a, c - a)) {
    // Far above what rounding can add up to: six roundings of terms of this size.
    constexpr double kBound = 1e-14;
    bound_ = kBound * sum_of(b - a) * sum_of(c - a);
  }

  /// As side(p) where all places within `reach` of p are on the same side, else 0.
  int side(Vec3 p, double reach) const {
    const Vec3 d = p - a_;
    const double height = dot(normal_, d);
    const double bound = bound_ * (sum_of(d) + 2.0 * reach) + reach * sum_of(normal_);
    return height > bound ? 1 : height < -bound ? -1 : 0;
  }

  /// 1 or -1; 0 where rounding may decide.
  int side(Vec3 p) const {
    const Vec3 d = p - a_;
    const double height = dot(normal_, d);
    const double bound = bound_ * sum_of(d);
    return height > bound ? 1 : height < -bound ? -1 : 0;
  }

 private:
  static double sum_of(Vec3 v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

  Vec3 a_, normal_;
  double bound_ = 0.0;
};

/// Triangles at a vertex, and those that they could meet wherever it moves to. Most pairs are told
/// apart by the others' planes, on one side of which all three corners lie: what stays where it is
/// is asked for that once.
class Surroundings {
 public:
  explicit Surroundings(const std::vector<Vec3>& positions) : positions_(positions) {}

  /// Around another vertex. To be filled next: `own` with the triangles at it, `others` with those
  /// that are not; then prepare().
  void begin(std::uint32_t vertex) {
    vertex_ = vertex;
    own_.clear();
    others_.clear();
  }
  void add_own(const Triangle& t) { own_.push_back(t); }
  void add_other(const Triangle& t) { others_.push_back(t); }

  /// `reach`: how far the vertex may move.
  void prepare(double reach) {
    find_ring();
    boxes_.clear();
    planes_.clear();
    sides_.clear();
    for (const Triangle& t : others_) {
      boxes_.push_back(box_of(positions_, t));
      planes_.emplace_back(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
      for (const std::uint32_t v : ring_) {
        const bool is_corner = v == t[0] || v == t[1] || v == t[2];
        sides_.push_back(
            static_cast<std::int8_t>(is_corner ? kCorner : planes_.back().side(positions_[v])));
      }
    }
    find_fixed();
    find_near();
    order_.clear();
    for (std::uint32_t k = 0; k < others_.size(); ++k)
      if (!stays_beside(k, reach)) order_.push_back(k);
  }

  const std::vector<Triangle>& own() const { return own_; }
  /// Pairs that meet wherever the vertex is: the edge opposite it runs into the other triangle.
  std::size_t fixed() const { return fixed_; }

  /// How many pairs meet with the vertex where it is now; counting ends at `limit`, the sooner as
  /// what has been met before is looked at first.
  std::size_t count(std::size_t limit) {
    std::size_t found = fixed_;
    if (found >= limit) return found;
    own_boxes_.clear();
    own_planes_.clear();
    Box all;
    for (const Triangle& t : own_) {
      own_boxes_.push_back(box_of(positions_, t));
      own_planes_.emplace_back(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
      all.extend(own_boxes_.back());
    }
    for (std::size_t place = 0; place < order_.size(); ++place) {
      const std::uint32_t k = order_[place];
      if (!all.intersects(boxes_[k])) continue;
      const std::size_t before = found;
      const int side = planes_[k].side(positions_[vertex_]);
      for_each_near(k, side, [&](std::size_t i) {
        if (own_boxes_[i].intersects(boxes_[k])) found += meet(i, k, side) ? 1 : 0;
        return found < limit;
      });
      if (found > before) std::swap(order_[place], order_[place / 2]);
      if (found >= limit) return found;
    }
    return count_own(found, limit);
  }

 private:
  static constexpr int kCorner = 2;  ///< a corner of the other triangle: on no side of its plane

  /// Whether all own triangles lie on one side of another's plane wherever the vertex moves.
  bool stays_beside(std::size_t other, double reach) const {
    const int side = planes_[other].side(positions_[vertex_], reach);
    const std::int8_t* sides = sides_.data() + other * ring_.size();
    return side != 0 && std::all_of(sides, sides + ring_.size(), [&](std::int8_t of_ring) {
             return of_ring == side || of_ring == kCorner;
           });
  }

  void find_ring() {
    ring_.clear();
    for (const Triangle& t : own_) ring_.insert(ring_.end(), t.begin(), t.end());
    std::sort(ring_.begin(), ring_.end());
    ring_.erase(std::unique(ring_.begin(), ring_.end()), ring_.end());
    std::erase(ring_, vertex_);
    ends_.clear();
    for (const Triangle& t : own_) ends_.push_back(ends_of(t));
  }

  /// The two other corners of an own triangle, in the ring.
  std::array<std::uint32_t, 2> ends_of(const Triangle& t) const {
    std::array<std::uint32_t, 2> ends{};
    std::size_t next = 0;
    for (const std::uint32_t v : t) {
      if (v == vertex_) continue;
      const auto at = std::lower_bound(ring_.begin(), ring_.end(), v);
      ends[next++] = static_cast<std::uint32_t>(at - ring_.begin());
    }
    return ends;
  }

  void find_fixed() {
    fixed_ = 0;
    is_fixed_.assign(others_.size() * own_.size(), 0);
    for (std::size_t k = 0; k < others_.size(); ++k) {
      const Triangle& t = others_[k];
      const std::int8_t* sides = sides_.data() + k * ring_.size();
      for (std::size_t i = 0; i < own_.size(); ++i) {
        const auto [a, b] = ends_[i];
        if (sides[a] == kCorner || sides[b] == kCorner || sides[a] * sides[b] > 0) continue;
        const Vec3 from = positions_[ring_[a]], to = positions_[ring_[b]];
        Box edge;
        edge.extend(from);
        edge.extend(to);
        if (!edge.intersects(boxes_[k]) ||
            !segment_meets_triangle(from, to, positions_[t[0]], positions_[t[1]],
                                    positions_[t[2]])) {
          continue;
        }
        is_fixed_[k * own_.size() + i] = 1;
        ++fixed_;
      }
    }
  }

  /// One bit per own triangle that another one may meet, where the vertex lies above it or below.
  struct Near {
    std::uint64_t above = 0, below = 0;
  };
  static constexpr std::size_t kMostBits = 64;

  void find_near() {
    near_.assign(others_.size(), {});
    if (own_.size() > kMostBits) return;
    for (std::size_t k = 0; k < others_.size(); ++k) {
      for (std::size_t i = 0; i < own_.size(); ++i) {
        if (is_fixed(k, i)) continue;
        near_[k].above |= static_cast<std::uint64_t>(!is_apart(k, i, 1)) << i;
        near_[k].below |= static_cast<std::uint64_t>(!is_apart(k, i, -1)) << i;
      }
    }
  }

  /// Calls visit(own triangle) for those that another one may meet with the vertex on that side of
  /// it, until it returns false.
  template <class Visit>
  void for_each_near(std::size_t other, int side, const Visit& visit) const {
    if (side == 0 || own_.size() > kMostBits) {
      for (std::size_t i = 0; i < own_.size(); ++i)
        if (!is_fixed(other, i) && !is_apart(other, i, side) && !visit(i)) return;
      return;
    }
    std::uint64_t bits = side > 0 ? near_[other].above : near_[other].below;
    for (; bits != 0; bits &= bits - 1)
      if (!visit(static_cast<std::size_t>(std::countr_zero(bits)))) return;
  }

  bool is_fixed(std::size_t other, std::size_t own) const {
    return fixed_ > 0 && is_fixed_[other * own_.size() + own] != 0;
  }

  /// Whether an own triangle meets another one, which lies on that side of the moving vertex: told
  /// by the sides of the corners where these are known.
  bool meet(std::size_t own, std::size_t other, int side) const {
    const Triangle& t = others_[other];
    const auto [a, b] = ends_[own];
    const std::uint32_t first = ring_[a], second = ring_[b];
    std::array<int, 3> of_other{};
    bool is_above = false, is_below = false, has_common = false, is_known = true;
    for (std::size_t k = 0; k < 3; ++k) {
      if (t[k] == first || t[k] == second) {
        has_common = true;
        continue;
      }
      of_other[k] = own_planes_[own].side(positions_[t[k]]);
      is_above = is_above || of_other[k] > 0;
      is_below = is_below || of_other[k] < 0;
      is_known = is_known && of_other[k] != 0;
    }
    if (is_known && is_above != is_below) return false;
    const std::int8_t* sides = sides_.data() + other * ring_.size();
    if (!is_known || has_common || side == 0 || sides[a] == 0 || sides[b] == 0)
      return triangles_intersect(positions_, own_[own], t);
    std::array<Vec3, 3> own_corners, other_corners;
    std::array<int, 3> of_own{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = own_[own][k];
      own_corners[k] = positions_[v];
      other_corners[k] = positions_[t[k]];
      // Sides count the other way round there.
      of_own[k] = -(v == vertex_ ? side : v == first ? sides[a] : sides[b]);
      of_other[k] = -of_other[k];
    }
    return triangles_across_intersect(own_corners, other_corners, of_own, of_other);
  }

  /// Adds the pairs among the own triangles.
  std::size_t count_own(std::size_t found, std::size_t limit) {
    own_sides_.clear();
    for (std::size_t i = 0; i < own_.size(); ++i) {
      for (std::uint32_t v = 0; v < ring_.size(); ++v) {
        const bool is_corner = v == ends_[i][0] || v == ends_[i][1];
        own_sides_.push_back(static_cast<std::int8_t>(
            is_corner ? kCorner : own_planes_[i].side(positions_[ring_[v]])));
      }
    }
    const auto is_off = [&](std::size_t i, std::size_t k) {
      const std::int8_t a = own_sides_[i * ring_.size() + ends_[k][0]];
      const std::int8_t b = own_sides_[i * ring_.size() + ends_[k][1]];
      return a != 0 && b != 0 && (a == b || a == kCorner || b == kCorner);
    };
    for (std::size_t i = 0; i < own_.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        if (is_off(i, k) || is_off(k, i)) continue;
        found += triangles_intersect(positions_, own_[i], own_[k]) ? 1 : 0;
        if (found >= limit) return found;
      }
    }
    return found;
  }

  bool is_apart(std::size_t other, std::size_t own, int side) const {
    if (side == 0) return false;
    const std::int8_t* sides = sides_.data() + other * ring_.size();
    const std::int8_t a = sides[ends_[own][0]], b = sides[ends_[own][1]];
    return (a == side || a == kCorner) && (b == side || b == kCorner);
  }

  const std::vector<Vec3>& positions_;
  std::uint32_t vertex_ = 0;
  std::vector<Triangle> own_, others_;
  std::vector<std::uint32_t> order_;  ///< of the others
  std::vector<std::uint32_t> ring_;
  std::vector<std::array<std::uint32_t, 2>> ends_;
  std::vector<Box> boxes_;
  std::vector<QuickPlane> planes_;
  std::vector<std::int8_t> sides_;  ///< others x ring
  std::vector<char> is_fixed_;      ///< others x own
  std::vector<Near> near_;          ///< per other
  std::size_t fixed_ = 0;
  // Of the vertex where it is now.
  std::vector<Box> own_boxes_;
  std::vector<QuickPlane> own_planes_;
  std::vector<std::int8_t> own_sides_;  ///< own x ring
};

class Untangler {
 public:
  Untangler(const HoleProblem& problem, const RimPiercings& piercings, const BoxTree& sheet,
            HolePatch& patch)
      : problem_(problem),
        piercings_(piercings),
        sheet_(sheet),
        patch_(patch),
        given_(static_cast<std::uint32_t>(problem.positions.size())),
        spacing_(rim_spacing(problem)),
        center_(center_of_loop(problem)),
        positions_(problem.positions),
        around_(positions_) {
    positions_.insert(positions_.end(), patch.positions.begin(), patch.positions.end());
  }

  /// Returns the contacts that are left of `contacts`.
  std::vector<Contact> run(std::vector<Contact> contacts) {
    const std::vector<Vec3> before = patch_.positions;
    const auto given_triangles = static_cast<std::uint32_t>(patch_.triangles.size());
    for (Contact& contact : contacts)
      if (contact[1] >= given_triangles) contact[1] = kSheet + (contact[1] - given_triangles);
    is_changed_.assign(given_triangles, 0);
    const bool has_given = give_vertices(avoidable(contacts));
    BoxTree tree(positions_, patch_.triangles);
    if (has_given) renew(tree, contacts);
    list_triangles();
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<Contact> to_avoid = avoidable(contacts);
      if (to_avoid.empty()) break;
      bool has_moved = false;
      for (const std::uint32_t v : movable(to_avoid)) has_moved = improve(v, tree) || has_moved;
      std::copy(positions_.begin() + given_, positions_.end(), patch_.positions.begin());
      if (!has_moved) break;
      tree.refit(positions_, patch_.triangles);
      renew(tree, contacts);
    }
    renew_normals(before);
    const auto own = static_cast<std::uint32_t>(patch_.triangles.size());
    for (Contact& contact : contacts)
      if (contact[1] >= kSheet) contact[1] = own + (contact[1] - kSheet);
    return contacts;
  }

 private:
  /// The first number of the sheet's triangles in contacts, however many the patch has by then.
  static constexpr std::uint32_t kSheet = std::uint32_t{1} << 31;

  bool is_new(std::uint32_t v) const { return v >= given_; }

  /// Looks again for the contacts of triangles that have changed. `tree`: of the patch as it is.
  void renew(const BoxTree& tree, std::vector<Contact>& contacts) {
    std::erase_if(contacts, [&](const Contact& contact) {
      return is_changed_[contact[0]] != 0 || (contact[1] < kSheet && is_changed_[contact[1]] != 0);
    });
    for (std::uint32_t i = 0; i < patch_.triangles.size(); ++i) {
      if (is_changed_[i] == 0) continue;
      const Triangle& t = patch_.triangles[i];
      const Box box = box_of(t);
      tree.for_each(box, [&](std::uint32_t k) {
        const bool is_other = k != i && (is_changed_[k] == 0 || k < i);
        if (is_other && triangles_intersect(positions_, patch_.triangles[k], t))
          contacts.push_back({std::max(i, k), std::min(i, k)});
        return true;
      });
      sheet_.for_each(box, [&](std::uint32_t k) {
        if (triangles_intersect(positions_, t, problem_.sheet[k]))
          contacts.push_back({i, kSheet + k});
        return true;
      });
    }
    is_changed_.assign(patch_.triangles.size(), 0);
  }

  /// Without those that the loop's own edges have.
  std::vector<Contact> avoidable(std::vector<Contact> contacts) const {
    std::erase_if(contacts, [&](const Contact& contact) {
      return contact[1] >= kSheet &&
             piercings_.has(patch_.triangles[contact[0]], contact[1] - kSheet);
    });
    return contacts;
  }

  std::vector<std::uint32_t> touching(const std::vector<Contact>& contacts) const {
    std::vector<std::uint32_t> triangles;
    for (const Contact& contact : contacts) {
      for (const std::uint32_t t : contact) {
        if (t < kSheet) triangles.push_back(t);
      }
    }
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    return triangles;
  }

  /// Splits triangles that touch something and have no vertex to move at their centres. Whether
  /// there were any.
  bool give_vertices(const std::vector<Contact>& contacts) {
    std::vector<Vec3> centers;
    for (const std::uint32_t index : touching(contacts)) {
      const Triangle t = patch_.triangles[index];
      if (std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return is_new(v); })) continue;
      const auto center = static_cast<std::uint32_t>(positions_.size());
      centers.push_back((positions_[t[0]] + positions_[t[1]] + positions_[t[2]]) / 3.0);
      positions_.push_back(centers.back());
      patch_.triangles[index] = {t[0], t[1], center};
      patch_.triangles.push_back({t[1], t[2], center});
      patch_.triangles.push_back({t[2], t[0], center});
      is_changed_[index] = 1;
    }
    is_changed_.resize(patch_.triangles.size(), 1);
    patch_.positions.insert(patch_.positions.end(), centers.begin(), centers.end());
    if (!patch_.lacks_values) {
      const std::vector<double> values = values_from_corners(problem_, centers);
      patch_.values.insert(patch_.values.end(), values.begin(), values.end());
    }
    patch_.normals.resize(patch_.positions.size());
    return !centers.empty();
  }

  /// What has moved, and what is new, gets the normal of its faces.
  void renew_normals(const std::vector<Vec3>& before) {
    const std::vector<Vec3> normals = normals_of_patch(problem_, patch_);
    for (std::size_t v = 0; v < normals.size(); ++v) {
      if (v >= before.size() || patch_.positions[v] != before[v]) patch_.normals[v] = normals[v];
    }
  }

  std::vector<std::uint32_t> movable(const std::vector<Contact>& contacts) const {
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t t : touching(contacts)) {
      for (const std::uint32_t v : patch_.triangles[t]) {
        if (is_new(v)) vertices.push_back(v);
      }
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
  }

  Box box_of(const Triangle& t) const { return orbweave::box_of(positions_, t); }

  void list_triangles() {
    const std::size_t vertices = patch_.positions.size();
    tried_.assign(vertices, 0);
    moved_.assign(vertices, 0);
    first_at_.assign(vertices + 1, 0);
    for (const Triangle& t : patch_.triangles)
      for (const std::uint32_t v : t)
        if (is_new(v)) ++first_at_[v - given_ + 1];
    std::partial_sum(first_at_.begin(), first_at_.end(), first_at_.begin());
    at_.resize(first_at_.back());
    std::vector<std::uint32_t> place(first_at_.begin(), first_at_.end() - 1);
    for (std::uint32_t i = 0; i < patch_.triangles.size(); ++i)
      for (const std::uint32_t v : patch_.triangles[i])
        if (is_new(v)) at_[place[v - given_]++] = i;
  }

  /// The patch's triangles at a new vertex.
  std::span<const std::uint32_t> triangles_at(std::uint32_t vertex) const {
    const std::uint32_t* first = first_at_.data() + (vertex - given_);
    return std::span(at_).subspan(first[0], first[1] - first[0]);
  }

  /// `tree`: of the patch at the start of the round, in which every vertex moves once at most.
  void look_around(std::uint32_t vertex, const BoxTree& tree) {
    const double reach = kSteps.back() * spacing_;
    around_.begin(vertex);
    Box within;
    within.extend(positions_[vertex]);
    // Rounding does not decide what the vertex can come to.
    constexpr double kSlack = 1.0 + 1e-6;
    within = within.grown(kSlack * reach);
    for (const std::uint32_t i : triangles_at(vertex)) {
      around_.add_own(patch_.triangles[i]);
      within.extend(box_of(patch_.triangles[i]));
    }
    tree.for_each(within.grown(reach), [&](std::uint32_t i) {
      const Triangle& t = patch_.triangles[i];
      const bool is_own = std::find(t.begin(), t.end(), vertex) != t.end();
      if (!is_own && box_of(t).intersects(within)) around_.add_other(t);
      return true;
    });
    sheet_.for_each(within, [&](std::uint32_t i) {
      around_.add_other(problem_.sheet[i]);
      return true;
    });
    around_.prepare(reach);
  }

  Vec3 normal_of(const std::vector<Triangle>& triangles) const {
    Vec3 sum;
    for (const Triangle& t : triangles) {
      const Vec3 a = positions_[t[0]];
      sum = sum + cross(positions_[t[1]] - a, positions_[t[2]] - a);
    }
    return normalized(sum);
  }

  /// Tries places along the normal, towards the middle of the hole and across; the nearest of the
  /// best ones is taken. True when it is better than where the vertex is.
  bool improve(std::uint32_t vertex, const BoxTree& tree) {
    ++clock_;
    if (is_settled(vertex)) return false;
    look_around(vertex, tree);
    const Vec3 start = positions_[vertex];
    const Vec3 normal = normal_of(around_.own());
    const Vec3 inward = center_ - start;
    const Vec3 along = normalized(inward - dot(inward, normal) * normal);
    const Vec3 sideways = cross(normal, along);
    std::size_t fewest = around_.count(SIZE_MAX);
    Vec3 best = start;
    for (const double step : kSteps) {
      for (const Vec3 direction : {normal, -normal, along, -along, sideways, -sideways}) {
        if (fewest == around_.fixed()) break;
        positions_[vertex] = start + step * spacing_ * direction;
        const std::size_t found = around_.count(fewest);
        if (found < fewest) {
          fewest = found;
          best = positions_[vertex];
        }
      }
    }
    positions_[vertex] = best;
    if (best == start) {
      tried_[vertex - given_] = clock_;
      return false;
    }
    moved_[vertex - given_] = clock_;
    for (const std::uint32_t i : triangles_at(vertex)) is_changed_[i] = 1;
    return true;
  }

  /// Whether a vertex was tried in vain, and nothing beside it has moved since.
  bool is_settled(std::uint32_t vertex) const {
    const std::uint32_t tried = tried_[vertex - given_];
    if (tried == 0) return false;
    for (const std::uint32_t i : triangles_at(vertex)) {
      for (const std::uint32_t v : patch_.triangles[i])
        if (is_new(v) && moved_[v - given_] > tried) return false;
    }
    return true;
  }

  const HoleProblem& problem_;
  const RimPiercings& piercings_;
  const BoxTree& sheet_;
  HolePatch& patch_;
  std::uint32_t given_;
  double spacing_ = 0.0;          ///< of the rim
  Vec3 center_;                   ///< of the rim
  std::vector<Vec3> positions_;   ///< of the problem, then of the patch
  Surroundings around_;           ///< of the vertex that is being moved
  std::vector<char> is_changed_;  ///< per triangle of the patch: since contacts were found
  std::vector<std::uint32_t> first_at_, at_;  ///< triangles at the patch's new vertices
  std::uint32_t clock_ = 0;
  std::vector<std::uint32_t> tried_, moved_;  ///< when, last: in vain, and to a better place
};

}  // namespace

std::vector<Contact> untangle(const HoleProblem& problem, const RimPiercings& piercings,
                              const BoxTree& sheet, std::vector<Contact> contacts,
                              HolePatch& patch) {
  if (contacts.size() > kMostContacts || piercings.count_avoidable(patch, contacts) == 0)
    return contacts;
  HolePatch moved = patch;
  std::vector<Contact> left = Untangler(problem, piercings, sheet, moved).run(contacts);
  if (left.size() >= contacts.size()) return contacts;
  patch = std::move(moved);
  return left;
}

std::uint64_t untangle(const HoleProblem& problem, HolePatch& patch) {
  const BoxTree sheet = BoxTree::of_sheet(problem.positions, problem.sheet);
  return untangle(problem, RimPiercings(problem, sheet), sheet,
                  find_contacts(problem, sheet, patch), patch)
      .size();
}

}  // namespace orbweave
