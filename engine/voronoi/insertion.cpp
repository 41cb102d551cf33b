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

std::size_t at(int place) { return static_cast<std::size_t>(place); }

}  // namespace

Insertion::Insertion(std::vector<Vec3> points, const std::array<std::uint32_t, 4>& first)
    : points_(std::move(points)),
      infinite_(static_cast<std::uint32_t>(points_.size())),
      least_error_(least_squared_error(points_)) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  points_.push_back({kNaN, kNaN, kNaN});
  // Room for the tetrahedra of a surface; memory is taken as it is used.
  constexpr std::size_t kCellsPerPoint = 7;
  vertices_.reserve(kCellsPerPoint * points_.size());
  neighbors_.reserve(vertices_.capacity());
  looks_.reserve(vertices_.capacity());
  std::array<std::uint32_t, 4> inner = first;
  if (exact_plane_side(
          {points_[first[0]], points_[first[1]], points_[first[2]], points_[first[3]]}) < 0)
    std::swap(inner[0], inner[1]);
  vertices_.push_back(inner);
  neighbors_.push_back({1, 2, 3, 4});
  for (std::size_t place = 0; place < 4; ++place) {
    // The vertex at infinity lies on the other side of the facet: two others change places.
    std::array<std::uint32_t, 4> outer = inner, beside = {1, 2, 3, 4};
    outer[place] = infinite_;
    beside[place] = 0;
    const std::size_t i = (place + 1) % 4, j = (place + 2) % 4;
    std::swap(outer[i], outer[j]);
    std::swap(beside[i], beside[j]);
    vertices_.push_back(outer);
    neighbors_.push_back(beside);
  }
  looks_.assign(vertices_.size(), 0);
}

void Insertion::add(std::uint32_t point) {
  const std::uint32_t first = locate(points_[point]);
  if (is_known(first, point)) return;
  find_taken(first, points_[point]);
  find_rim(point);
  fill();
}

bool Insertion::is_finite(std::uint32_t cell) const {
  const auto& v = vertices_[cell];
  return v[0] != infinite_ && v[1] != infinite_ && v[2] != infinite_ && v[3] != infinite_;
}

/// The tetrahedron that p lies in; outside the hull, one at infinity whose facet sees p. Walks from
/// the point before: the spheres put all tetrahedra in the order in which p sees them, so that the
/// walk ends.
std::uint32_t Insertion::locate(const Vec3& p) const {
  std::uint32_t cell = last_, from = kNone;
  if (!is_finite(cell)) cell = neighbors_[cell][at(place_in(vertices_[cell], infinite_))];
  while (true) {
    const std::uint32_t next = next_on_way(cell, from, p);
    if (next == cell || !is_finite(next)) return next;
    from = cell;
    cell = next;
  }
}

/// The neighbour beyond a facet that p lies beyond; the tetrahedron itself where p is inside.
std::uint32_t Insertion::next_on_way(std::uint32_t cell, std::uint32_t from, const Vec3& p) const {
  for (std::size_t place = 0; place < 4; ++place) {
    const std::uint32_t next = neighbors_[cell][place];
    if (next != from && side_with(cell, place, p) < 0) return next;
  }
  return cell;
}

/// On which side of the facet opposite a place p lies: 1 on that of the tetrahedron.
int Insertion::side_with(std::uint32_t cell, std::size_t place, const Vec3& p) const {
  const auto& facet = kFacet[place];
  const auto corner = [&](std::size_t k) -> const Vec3& {
    return points_[vertices_[cell][at(facet[k])]];
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
  for (const std::uint32_t vertex : vertices_[cell]) {
    if (vertex == infinite_ || points_[vertex] != points_[point]) continue;
    copies_.push_back({vertex, point});
    return true;
  }
  return false;
}

/// Whether p lies inside the sphere of a tetrahedron, whatever doubles can tell. That of one at
/// infinity is the half space beyond its facet, and in the plane of the facet the sphere of the
/// tetrahedron behind.
bool Insertion::takes_away_exactly(std::uint32_t cell, const Vec3& p) const {
  const auto& v = vertices_[cell];
  if (is_finite(cell))
    return exact_sphere_side({points_[v[0]], points_[v[1]], points_[v[2]], points_[v[3]]}, p) > 0;
  const std::size_t at_infinity = at(place_in(v, infinite_));
  const int side = side_with(cell, at_infinity, p);
  return side > 0 || (side == 0 && takes_away_exactly(neighbors_[cell][at_infinity], p));
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
  for (const std::uint32_t next : neighbors_[cell]) {
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
    const Vec3& a = points_[vertices_[first][k]];
    const Vec3& b = points_[vertices_[second][k]];
    corners[k] = {Two{a.x, b.x} - p.x, Two{a.y, b.y} - p.y, Two{a.z, b.z} - p.z};
  }
  const RoundedSum<Two> sums = sphere_sum(corners);
  const auto are_certain = certain(sums, least_error_);
  if ((are_certain[0] & are_certain[1]) != 0) return {sums.value[0] > 0.0, sums.value[1] > 0.0};
  return {are_certain[0] != 0 ? sums.value[0] > 0.0 : takes_away_exactly(first, p),
          are_certain[1] != 0 ? sums.value[1] > 0.0 : takes_away_exactly(second, p)};
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
      count += looks_[neighbors_[taken_[i]][place]] == look_ ? 1U : 0U;
    }
  }
  rim_.resize(count);
  for (Rim& rim : rim_) {
    rim.vertices = vertices_[rim.cell];
    rim.vertices[rim.place] = point;
    rim.outside = neighbors_[rim.cell][rim.place];
    rim.outside_place = static_cast<std::uint32_t>(place_in(neighbors_[rim.outside], rim.cell));
  }
}

/// Tetrahedra between the point and the rim, in the place of those taken away.
void Insertion::fill() {
  edges_.clear(3 * rim_.size());
  std::size_t reused = 0;
  for (Rim& rim : rim_) {
    rim.cell = reused < taken_count_ ? taken_[reused++] : new_cell();
    vertices_[rim.cell] = rim.vertices;
    neighbors_[rim.cell][rim.place] = rim.outside;
    neighbors_[rim.outside][rim.outside_place] = rim.cell;
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
      neighbors_[rim.cell][at(facet[(k + 2) % 3])] = edges_.cell(from, to);
    }
  }
}

std::uint32_t Insertion::new_cell() {
  if (!free_.empty()) {
    const std::uint32_t cell = free_.back();
    free_.pop_back();
    return cell;
  }
  if (vertices_.size() == kNone)
    throw_resource("the Delaunay triangulation is too large",
                   {.found = std::to_string(points_.size() - 1) + " points",
                    .expected = "fewer than 2^32 tetrahedra"});
  vertices_.emplace_back();
  neighbors_.emplace_back();
  looks_.push_back(0);
  return static_cast<std::uint32_t>(vertices_.size() - 1);
}

/// The numbers of the tetrahedra; kNone for places that hold none.
std::vector<std::uint32_t> Insertion::numbers() {
  for (const std::uint32_t cell : free_) vertices_[cell].fill(kInfinite);
  std::vector<std::uint32_t> number = std::move(looks_);
  for (std::size_t c = 0; c < number.size(); ++c)
    number[c] = *std::min_element(vertices_[c].begin(), vertices_[c].end());
  number_by(number, points_.size() - 1);
  return number;
}

void Insertion::rename(std::span<const std::uint32_t> indices) {
  std::vector<std::uint32_t> names(indices.begin(), indices.end());
  for (const Copy& copy : copies_)
    names[copy.vertex] = std::min(names[copy.vertex], indices[copy.point]);
  for (auto& vertices : vertices_)
    for (std::uint32_t& vertex : vertices) vertex = vertex == infinite_ ? kInfinite : names[vertex];
  infinite_ = kInfinite;
}

Tetrahedra Insertion::take(std::span<const std::uint32_t> indices, const StopToken* stop) {
  rename(indices);
  const std::vector<std::uint32_t> number = numbers();
  check_stop(stop);
  const std::size_t count = number.size() - free_.size();
  Tetrahedra result;
  result.vertices.resize(count);
  result.finite.resize(count);
  for (std::uint32_t c = 0; c < number.size(); ++c) {
    if (number[c] == kNone) continue;
    result.vertices[number[c]] = vertices_[c];
    result.finite[number[c]] = is_finite(c) ? 1 : 0;
  }
  check_stop(stop);
  result.neighbors = std::move(vertices_);  // the memory, which is much
  result.neighbors.resize(count);
  for (std::size_t c = 0; c < number.size(); ++c)
    for (std::size_t place = 0; place < 4 && number[c] != kNone; ++place)
      result.neighbors[number[c]][place] = number[neighbors_[c][place]];
  return result;
}

}  // namespace orbweave::voronoi
