#include "engine/holes/patch/untangle.h"

#include <algorithm>
#include <array>
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

constexpr std::uint64_t kMostContacts = 160;

class Untangler {
 public:
  Untangler(const HoleProblem& problem, HolePatch& patch)
      : problem_(problem),
        patch_(patch),
        given_(static_cast<std::uint32_t>(problem.positions.size())),
        rim_(find_rim(problem)),
        sheet_(problem.positions, problem.sheet),
        positions_(problem.positions) {
    positions_.insert(positions_.end(), patch.positions.begin(), patch.positions.end());
  }

  std::uint64_t run(std::vector<Contact> contacts) {
    constexpr int kRounds = 5;
    const std::vector<Vec3> before = patch_.positions;
    if (give_vertices(contacts)) contacts = find_contacts(problem_, patch_);
    for (int round = 0; round < kRounds && !contacts.empty(); ++round) {
      bool has_moved = false;
      for (const std::uint32_t v : movable(contacts)) has_moved = improve(v) || has_moved;
      std::copy(positions_.begin() + given_, positions_.end(), patch_.positions.begin());
      contacts = find_contacts(problem_, patch_);
      if (!has_moved) break;
    }
    renew_normals(before);
    return contacts.size();
  }

 private:
  bool is_new(std::uint32_t v) const { return v >= given_; }

  std::vector<std::uint32_t> touching(const std::vector<Contact>& contacts) const {
    std::vector<std::uint32_t> triangles;
    for (const Contact& contact : contacts) {
      for (const std::uint32_t t : contact) {
        if (t < patch_.triangles.size()) triangles.push_back(t);
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
    }
    const std::vector<double> values = values_from_corners(problem_, centers);
    patch_.positions.insert(patch_.positions.end(), centers.begin(), centers.end());
    patch_.values.insert(patch_.values.end(), values.begin(), values.end());
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

  /// A triangle that stays where it is while a vertex is moved.
  struct Other {
    Box box;
    Triangle triangle;
  };
  /// Triangles at a vertex, and those that they could meet wherever it moves to.
  struct Surroundings {
    std::vector<Triangle> own;
    std::vector<Other> others;
  };
  Surroundings surroundings(std::uint32_t vertex, double reach) const {
    Surroundings around;
    Box box;
    std::vector<Triangle> apart;
    for (const Triangle& t : patch_.triangles) {
      const bool is_own = std::find(t.begin(), t.end(), vertex) != t.end();
      (is_own ? around.own : apart).push_back(t);
      if (is_own) box.extend(box_of(t));
    }
    const Box within = box.grown(reach);
    for (const Triangle& t : apart) {
      const Box of_t = box_of(t);
      if (of_t.intersects(within)) around.others.push_back({of_t, t});
    }
    sheet_.for_each(within, [&](std::uint32_t index) {
      const Triangle& t = problem_.sheet[index];
      around.others.push_back({box_of(t), t});
      return true;
    });
    return around;
  }

  /// How many pairs meet; counting ends at `limit`.
  std::size_t count(const Surroundings& around, std::size_t limit) const {
    std::size_t found = 0;
    for (std::size_t i = 0; i < around.own.size(); ++i) {
      const Box box = box_of(around.own[i]);
      for (const Other& other : around.others) {
        if (!box.intersects(other.box)) continue;
        found += triangles_intersect(positions_, around.own[i], other.triangle);
        if (found >= limit) return found;
      }
      for (std::size_t k = 0; k < i; ++k) {
        found += triangles_intersect(positions_, around.own[i], around.own[k]);
        if (found >= limit) return found;
      }
    }
    return found;
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
  bool improve(std::uint32_t vertex) {
    constexpr std::array<double, 3> kSteps = {0.25, 0.6, 1.2};  // rim spacings
    const Surroundings around = surroundings(vertex, kSteps.back() * rim_.spacing);
    const Vec3 start = positions_[vertex];
    const Vec3 normal = normal_of(around.own);
    const Vec3 inward = rim_.center - start;
    const Vec3 along = normalized(inward - dot(inward, normal) * normal);
    const Vec3 sideways = cross(normal, along);
    std::size_t fewest = count(around, SIZE_MAX);
    Vec3 best = start;
    for (const double step : kSteps) {
      for (const Vec3 direction : {normal, -normal, along, -along, sideways, -sideways}) {
        if (fewest == 0) break;
        positions_[vertex] = start + step * rim_.spacing * direction;
        const std::size_t found = count(around, fewest);
        if (found < fewest) {
          fewest = found;
          best = positions_[vertex];
        }
      }
    }
    positions_[vertex] = best;
    return best != start;
  }

  const HoleProblem& problem_;
  HolePatch& patch_;
  std::uint32_t given_;
  Rim rim_;
  BoxTree sheet_;
  std::vector<Vec3> positions_;
};

}  // namespace

std::uint64_t untangle(const HoleProblem& problem, HolePatch& patch) {
  const std::vector<Contact> contacts = find_contacts(problem, patch);
  if (contacts.empty() || contacts.size() > kMostContacts) return contacts.size();
  HolePatch moved = patch;
  const std::uint64_t left = Untangler(problem, moved).run(contacts);
  if (left >= contacts.size()) return contacts.size();
  patch = std::move(moved);
  return left;
}

}  // namespace orbweave
