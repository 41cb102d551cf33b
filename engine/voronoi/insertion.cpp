#include "engine/voronoi/insertion.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "engine/voronoi/exact_signs.h"
#include "io/error.h"

namespace orbweave::voronoi {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

std::size_t at(int place) { return static_cast<std::size_t>(place); }

/// The place of a value that is among four.
std::size_t place_of(const std::array<std::uint32_t, 4>& values, std::uint32_t value) {
  return (values[1] == value ? 1U : 0U) + (values[2] == value ? 2U : 0U) +
         (values[3] == value ? 3U : 0U);
}

}  // namespace

Insertion::Insertion(std::vector<Vec3> points, const std::array<std::uint32_t, 4>& first)
    : points_(std::move(points)),
      infinite_(static_cast<std::uint32_t>(points_.size())),
      least_error_(least_squared_error(points_)) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  points_.push_back({kNaN, kNaN, kNaN});
  // Room for those of a surface; memory is taken as it is used.
  constexpr std::size_t kCellsPerPoint = 7;
  cells_.reserve(kCellsPerPoint * points_.size());
  looks_.reserve(cells_.capacity());
  Cell inner{first, {1, 2, 3, 4}};
  const auto corner = [&](std::size_t k) { return points_[first[k]]; };
  if (exact_plane_side({corner(0), corner(1), corner(2), corner(3)}) < 0)
    std::swap(inner.vertices[0], inner.vertices[1]);
  cells_.push_back(inner);
  for (std::size_t place = 0; place < 4; ++place) {
    // The vertex at infinity lies on the other side of the facet: two others change places.
    Cell outer{inner.vertices, {1, 2, 3, 4}};
    outer.vertices[place] = infinite_;
    outer.neighbors[place] = 0;
    const std::size_t i = (place + 1) % 4, j = (place + 2) % 4;
    std::swap(outer.vertices[i], outer.vertices[j]);
    std::swap(outer.neighbors[i], outer.neighbors[j]);
    cells_.push_back(outer);
  }
  looks_.assign(cells_.size(), 0);
}

void Insertion::add(std::uint32_t point) {
  const std::uint32_t first = locate(points_[point]);
  if (is_known(first, point)) return;
  find_taken(first, points_[point]);
  find_rim(point);
  fill();
}

bool Insertion::is_finite(const Cell& cell) const {
  return ((cell.vertices[0] == infinite_) | (cell.vertices[1] == infinite_) |
          (cell.vertices[2] == infinite_) | (cell.vertices[3] == infinite_)) == 0;
}

/// The tetrahedron that p lies in; outside the hull, one at infinity whose facet sees p. Walks from
/// the point before: the spheres put all tetrahedra in the order in which p sees them, so that no
/// way leads back.
std::uint32_t Insertion::locate(const Vec3& p) const {
  std::uint32_t cell = last_, from = kNone;
  if (!is_finite(cells_[cell]))
    cell = cells_[cell].neighbors[place_of(cells_[cell].vertices, infinite_)];
  while (true) {
    const std::uint32_t next = next_on_way(cell, from, p);
    if (next == cell || !is_finite(cells_[next])) return next;
    from = cell;
    cell = next;
  }
}

/// The neighbour beyond a facet that p lies beyond; the tetrahedron itself where p is inside.
std::uint32_t Insertion::next_on_way(std::uint32_t cell, std::uint32_t from, const Vec3& p) const {
  for (std::size_t place = 0; place < 4; ++place) {
    const std::uint32_t next = cells_[cell].neighbors[place];
    if (next != from && side_with(cells_[cell], place, p) < 0) return next;
  }
  return cell;
}

/// On which side of the facet opposite a place p lies: 1 on that of the tetrahedron.
int Insertion::side_with(const Cell& cell, std::size_t place, const Vec3& p) const {
  const auto& facet = kFacet[place];
  const auto corner = [&](std::size_t k) -> const Vec3& {
    return points_[cell.vertices[at(facet[k])]];
  };
  const auto offset = [&](std::size_t k) {
    return Offset<double>{corner(k).x - p.x, corner(k).y - p.y, corner(k).z - p.z};
  };
  // Counter-clockwise seen from outside: clockwise seen from the tetrahedron.
  const int side = certain_sign(plane_sum(offset(0), offset(2), offset(1)), least_error_);
  return side != 0 ? side : exact_plane_side({corner(0), corner(2), corner(1), p});
}

/// Whether a vertex of the tetrahedron lies in the place of the point.
bool Insertion::is_known(std::uint32_t cell, std::uint32_t point) {
  for (const std::uint32_t vertex : cells_[cell].vertices) {
    if (vertex == infinite_ || points_[vertex] != points_[point]) continue;
    copies_.push_back({vertex, point});
    return true;
  }
  return false;
}

/// Whether p lies inside the sphere of a tetrahedron, whatever doubles can tell. That of one at
/// infinity is the half space beyond its facet, and in the plane of the facet the sphere of the
/// tetrahedron behind.
bool Insertion::takes_away_exactly(const Cell& cell, const Vec3& p) const {
  const auto& v = cell.vertices;
  if (is_finite(cell))
    return exact_sphere_side({points_[v[0]], points_[v[1]], points_[v[2]], points_[v[3]]}, p) > 0;
  const std::size_t at_infinity = place_of(v, infinite_);
  const int side = side_with(cell, at_infinity, p);
  return side > 0 || (side == 0 && takes_away_exactly(cells_[cell.neighbors[at_infinity]], p));
}

/// The tetrahedra whose spheres have p inside: they hang together. What is asked of tetrahedra is
/// answered by counting, without branches: the machine foresees none of them.
void Insertion::find_taken(std::uint32_t first, const Vec3& p) {
  look_ += 2;
  taken_count_ = 0;
  make_room();
  taken_[taken_count_++] = first;
  looks_[first] = look_ + kTaken;
  for (std::size_t i = 0; i < taken_count_;) {
    asked_count_ = 0;
    for (; i < taken_count_ && asked_count_ < kAskedAtOnce; ++i) ask_neighbors(taken_[i]);
    answer(p);
  }
}

/// Room for as many tetrahedra as can be asked about at once.
void Insertion::make_room() {
  if (taken_.size() < taken_count_ + asked_.size())
    taken_.resize(2 * (taken_count_ + asked_.size()));
}

void Insertion::ask_neighbors(std::uint32_t cell) {
  for (const std::uint32_t next : cells_[cell].neighbors) {
    asked_[asked_count_] = next;
    asked_count_ += looks_[next] < look_ ? 1U : 0U;
    looks_[next] = std::max(looks_[next], look_);
  }
}

/// Takes those of the tetrahedra that are asked about whose spheres have p inside.
void Insertion::answer(const Vec3& p) {
  make_room();
  asked_[asked_count_] = asked_[0];  // beside the last one where their number is odd
  for (std::size_t i = 0; i < asked_count_; i += 2) {
    const std::array<bool, 2> inside = are_inside(asked_[i], asked_[i + 1], p);
    take_away(asked_[i], inside[0]);
    if (i + 1 < asked_count_) take_away(asked_[i + 1], inside[1]);
  }
}

std::array<bool, 2> Insertion::are_inside(std::uint32_t first, std::uint32_t second,
                                          const Vec3& p) const {
  std::array<Offset<Two>, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3& a = points_[cells_[first].vertices[k]];
    const Vec3& b = points_[cells_[second].vertices[k]];
    corners[k] = {Two{a.x, b.x} - p.x, Two{a.y, b.y} - p.y, Two{a.z, b.z} - p.z};
  }
  const RoundedSum<Two> sums = sphere_sum(corners);
  const auto are_certain = certain(sums, least_error_);
  if ((are_certain[0] & are_certain[1]) != 0) return {sums.value[0] > 0.0, sums.value[1] > 0.0};
  return {are_certain[0] != 0 ? sums.value[0] > 0.0 : takes_away_exactly(cells_[first], p),
          are_certain[1] != 0 ? sums.value[1] > 0.0 : takes_away_exactly(cells_[second], p)};
}

void Insertion::take_away(std::uint32_t cell, bool is_inside) {
  const std::uint32_t taken = is_inside ? kTaken : 0;
  looks_[cell] += taken;
  taken_[taken_count_] = cell;
  taken_count_ += taken;
}

/// The facets between what is taken away and what stays.
void Insertion::find_rim(std::uint32_t point) {
  rim_.resize(4 * taken_count_);
  std::size_t count = 0;
  for (std::size_t i = 0; i < taken_count_; ++i) {
    for (std::size_t place = 0; place < 4; ++place) {
      rim_[count].cell = taken_[i];
      rim_[count].place = static_cast<std::uint32_t>(place);
      count += looks_[cells_[taken_[i]].neighbors[place]] == look_ ? 1U : 0U;
    }
  }
  rim_.resize(count);
  for (Rim& rim : rim_) {
    const Cell& cell = cells_[rim.cell];
    rim.vertices = cell.vertices;
    rim.vertices[rim.place] = point;
    rim.outside = cell.neighbors[rim.place];
    rim.outside_place =
        static_cast<std::uint32_t>(place_of(cells_[rim.outside].neighbors, rim.cell));
  }
}

/// Tetrahedra between the point and the rim, in the place of those taken away.
void Insertion::fill() {
  edges_.clear(3 * rim_.size());
  std::size_t reused = 0;
  for (Rim& rim : rim_) {
    rim.cell = reused < taken_count_ ? taken_[reused++] : new_cell();
    cells_[rim.cell].vertices = rim.vertices;
    cells_[rim.cell].neighbors[rim.place] = rim.outside;
    cells_[rim.outside].neighbors[rim.outside_place] = rim.cell;
    const auto& facet = kFacet[rim.place];
    for (std::size_t k = 0; k < 3; ++k)
      edges_.add(rim.vertices[at(facet[k])], rim.vertices[at(facet[(k + 1) % 3])], rim.cell);
  }
  free_.insert(free_.end(), taken_.begin() + static_cast<std::ptrdiff_t>(reused),
               taken_.begin() + static_cast<std::ptrdiff_t>(taken_count_));
  connect();
  last_ = rim_.back().cell;
}

/// Connects the new tetrahedra: those at one edge of the rim see it in opposite directions.
void Insertion::connect() {
  for (const Rim& rim : rim_) {
    const auto& facet = kFacet[rim.place];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = rim.vertices[at(facet[(k + 1) % 3])];
      const std::uint32_t to = rim.vertices[at(facet[k])];
      cells_[rim.cell].neighbors[at(facet[(k + 2) % 3])] = edges_.cell(from, to);
    }
  }
}

std::uint32_t Insertion::new_cell() {
  if (!free_.empty()) {
    const std::uint32_t cell = free_.back();
    free_.pop_back();
    return cell;
  }
  if (cells_.size() == kNone)
    throw_resource("the Delaunay triangulation is too large",
                   {.found = std::to_string(points_.size() - 1) + " points",
                    .expected = "fewer than 2^32 tetrahedra"});
  cells_.emplace_back();
  looks_.push_back(0);
  return static_cast<std::uint32_t>(cells_.size() - 1);
}

void Insertion::rename(std::span<const std::uint32_t> indices) {
  std::vector<std::uint32_t> names(indices.begin(), indices.end());
  for (const Copy& copy : copies_)
    names[copy.vertex] = std::min(names[copy.vertex], indices[copy.point]);
  for (Cell& cell : cells_)
    for (std::uint32_t& vertex : cell.vertices)
      vertex = vertex == infinite_ ? kInfinite : names[vertex];
  infinite_ = kInfinite;
}

Tetrahedra Insertion::take(std::span<const std::uint32_t> indices, const StopToken* stop) {
  rename(indices);
  for (const std::uint32_t cell : free_) cells_[cell].vertices.fill(kInfinite);
  std::vector<std::uint32_t> number;
  number.reserve(cells_.size());
  for (const Cell& cell : cells_)
    number.push_back(*std::min_element(cell.vertices.begin(), cell.vertices.end()));
  check_stop(stop);
  number_by(number, points_.size() - 1);
  const std::size_t count = cells_.size() - free_.size();
  Tetrahedra result;
  result.vertices.resize(count);
  result.neighbors.resize(count);
  result.finite.resize(count);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    if (number[c] == kNone) continue;
    result.vertices[number[c]] = cells_[c].vertices;
    result.finite[number[c]] = is_finite(cells_[c]) ? 1 : 0;
    for (std::size_t place = 0; place < 4; ++place)
      result.neighbors[number[c]][place] = number[cells_[c].neighbors[place]];
  }
  return result;
}

}  // namespace orbweave::voronoi
