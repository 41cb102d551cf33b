#include "engine/voronoi/power_faces.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "engine/voronoi/facets.h"
#include "engine/voronoi/poles.h"

namespace orbweave::voronoi {
namespace {

std::size_t at(int place) { return static_cast<std::size_t>(place); }

/// Collects the faces between inner and outer balls.
class FaceWalk {
 public:
  FaceWalk(const Tetrahedra& power, std::span<const std::uint8_t> inner)
      : power_(power), inner_(inner) {}

  /// Rings of tetrahedra, counter-clockwise seen from outside; a ring ends where the next begins.
  void run(const StopToken* stop) {
    begin_.push_back(0);
    for (std::uint32_t c = 0; c < power_.size(); ++c) {
      if (c % kStopBlock == 0) check_stop(stop);
      if (!power_.is_finite(c)) continue;
      std::array<bool, 4> inside{};
      for (std::size_t i = 0; i < 4; ++i) inside[i] = inner_[power_.vertices[c][i]] != 0;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          if (inside[at(i)] && !inside[at(j)]) add_ring(c, i, j);
    }
  }

  const std::vector<std::uint32_t>& cells() const { return cells_; }
  const std::vector<std::size_t>& begin() const { return begin_; }

 private:
  /// Once per edge: from the first of its tetrahedra.
  void add_ring(std::uint32_t first, int i, int j) {
    // Two of three tetrahedra have a smaller neighbour in the ring.
    const int next = next_place(i, j), before = next_place(j, i);
    if (power_.neighbors[first][at(next)] < first || power_.neighbors[first][at(before)] < first)
      return;
    const std::uint32_t in = power_.vertices[first][at(i)], out = power_.vertices[first][at(j)];
    const std::size_t size_before = cells_.size();
    std::uint32_t cell = first;
    do {
      if (cell < first) {
        cells_.resize(size_before);
        return;
      }
      cells_.push_back(cell);
      const int k = next_place(power_.place_of_vertex(cell, in), power_.place_of_vertex(cell, out));
      cell = power_.neighbors[cell][at(k)];
    } while (cell != first);
    begin_.push_back(cells_.size());
  }

  const Tetrahedra& power_;
  std::span<const std::uint8_t> inner_;
  std::vector<std::uint32_t> cells_;
  std::vector<std::size_t> begin_;
};

/// The nearest of the points that the balls of a tetrahedron touch, the first of equals.
struct NearestSample {
  std::uint32_t point = kNone;
  double square = std::numeric_limits<double>::infinity();  ///< of its distance

  void look_at(std::span<const Vec3> points, const PolarBalls& balls,
               std::span<const std::uint32_t> tetrahedron, Vec3 place) {
    for (const std::uint32_t ball : tetrahedron)
      for (const std::uint32_t p : balls.touched_by(ball)) {
        const double other = squared_norm(points[p] - place);
        if (std::tie(other, p) < std::tie(square, point)) {
          point = p;
          square = other;
        }
      }
  }
};

/// The centre of a tetrahedron.
struct Place {
  Vec3 position;
  std::array<std::uint32_t, 4> balls{};  ///< its vertices, ascending
  std::uint32_t cell = 0;
};

/// The vertices of a surface: places that the corners of faces have. Tetrahedra whose centres are
/// equal share a vertex until the vertex is split.
class Corners {
 public:
  Corners(const FaceWalk& faces, const Tetrahedra& power)
      : number_(power.size(), kNone), places_(places_of(faces, power)) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (i == 0 || places_[i].position != places_[i - 1].position)
        group_begin_.push_back(static_cast<std::uint32_t>(i));
    }
    group_begin_.push_back(static_cast<std::uint32_t>(places_.size()));
    split_.assign(group_begin_.size() - 1, 0);
    number();
  }

  /// Of a tetrahedron.
  std::uint32_t vertex(std::uint32_t cell) const { return number_[cell]; }
  bool is_shared(std::uint32_t vertex) const { return is_shared_[vertex] != 0; }
  bool has_shared() const {
    return std::find(is_shared_.begin(), is_shared_.end(), 1) != is_shared_.end();
  }

  /// Gives each tetrahedron of some shared vertices (ascending) a vertex of its own.
  void split(std::span<const std::uint32_t> vertices) {
    for (const std::uint32_t vertex : vertices) split_[group_of_[vertex]] = 1;
    number();
  }

  void put_vertices(std::span<const Vec3> points, const PolarBalls& balls,
                    PowerCrustSurface& surface) const {
    std::vector<NearestSample> nearest(group_of_.size());
    surface.vertices.resize(group_of_.size());
    for (const Place& place : places_) {
      const std::uint32_t vertex = number_[place.cell];
      surface.vertices[vertex] = place.position;
      nearest[vertex].look_at(points, balls, place.balls, place.position);
    }
    for (const NearestSample& sample : nearest) surface.samples.push_back(sample.point);
  }

 private:
  /// The corners' places in the order of their coordinates.
  static std::vector<Place> places_of(const FaceWalk& faces, const Tetrahedra& power) {
    std::vector<std::uint8_t> used(power.size(), 0);
    for (const std::uint32_t cell : faces.cells()) used[cell] = 1;
    std::vector<Place> places;
    for (std::uint32_t cell = 0; cell < used.size(); ++cell) {
      if (used[cell] == 0) continue;
      places.push_back({power.centers[cell], power.vertices[cell], cell});
      std::sort(places.back().balls.begin(), places.back().balls.end());
    }
    sort_places(places);
    return places;
  }

  /// Sorts by coordinates, of which the first nearly always decides. The places move once, within
  /// their memory.
  static void sort_places(std::span<Place> places) {
    struct Key {
      double x = 0.0;
      std::uint32_t place = 0;
    };
    std::vector<Key> order;
    order.reserve(places.size());
    for (std::uint32_t i = 0; i < places.size(); ++i) order.push_back({places[i].position.x, i});
    std::sort(order.begin(), order.end(), [&](const Key& p, const Key& q) {
      if (p.x != q.x) return p.x < q.x;
      const Place &a = places[p.place], &b = places[q.place];
      return std::tie(a.position.y, a.position.z, a.balls) <
             std::tie(b.position.y, b.position.z, b.balls);
    });
    for (std::uint32_t first = 0; first < places.size(); ++first) {
      if (order[first].place == first) continue;
      const Place moved = places[first];
      std::uint32_t to = first;
      for (std::uint32_t from = order[to].place; from != first; from = order[to].place) {
        places[to] = places[from];
        order[to].place = to;
        to = from;
      }
      places[to] = moved;
      order[to].place = to;
    }
  }

  void number() {
    group_of_.clear();
    is_shared_.clear();
    for (std::uint32_t group = 0; group < split_.size(); ++group) {
      const std::uint32_t begin = group_begin_[group], end = group_begin_[group + 1];
      for (std::uint32_t i = begin; i < end; ++i) {
        if (i == begin || split_[group] != 0) {
          group_of_.push_back(group);
          is_shared_.push_back(split_[group] == 0 && end - begin > 1 ? 1 : 0);
        }
        number_[places_[i].cell] = static_cast<std::uint32_t>(group_of_.size() - 1);
      }
    }
  }

  std::vector<std::uint32_t> number_;  // per tetrahedron
  std::vector<Place> places_;
  std::vector<std::uint32_t> group_begin_;  // of the places that are equal, and their number
  std::vector<std::uint8_t> split_;         // per group
  std::vector<std::uint32_t> group_of_;     // per vertex
  std::vector<std::uint8_t> is_shared_;     // per vertex
};

/// Polygons as spans of one list of corners.
struct Polygons {
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> begin = {0};  ///< and the number of corners

  std::size_t size() const { return begin.size() - 1; }
  std::span<const std::uint32_t> of(std::size_t polygon) const {
    return std::span(corners).subspan(begin[polygon], begin[polygon + 1] - begin[polygon]);
  }
  void add(std::span<const std::uint32_t> polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    begin.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  /// The smallest corner first. Fewer than three corners are none.
  void add_simple(std::span<std::uint32_t> polygon) {
    if (polygon.size() < 3) return;
    std::rotate(polygon.begin(), std::min_element(polygon.begin(), polygon.end()), polygon.end());
    add(polygon);
  }
};

/// Cuts rings of corners where they come by a corner again, which sides of no length do.
class RingCutter {
 public:
  void cut(std::span<const std::uint32_t> ring, Polygons& to) {
    open_.clear();
    for (const std::uint32_t corner : ring) {
      const auto before = std::find(open_.begin(), open_.end(), corner);
      if (before != open_.end()) {
        to.add_simple(std::span(before, open_.end()));
        open_.erase(before, open_.end());
      }
      open_.push_back(corner);
    }
    to.add_simple(open_);
  }

 private:
  std::vector<std::uint32_t> open_;
};

Polygons polygons_of(const FaceWalk& faces, const Corners& corners) {
  Polygons polygons;
  polygons.corners.reserve(faces.cells().size());
  polygons.begin.reserve(faces.begin().size());
  RingCutter cutter;
  std::vector<std::uint32_t> ring;
  for (std::size_t f = 0; f + 1 < faces.begin().size(); ++f) {
    ring.clear();
    for (std::size_t i = faces.begin()[f]; i < faces.begin()[f + 1]; ++i)
      ring.push_back(corners.vertex(faces.cells()[i]));
    // A ring that begins with its smallest corner is cut alike wherever the walk began.
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
    cutter.cut(ring, polygons);
  }
  return polygons;
}

/// Shared vertices at directed edges that several triangles of the polygons have. Ascending.
std::vector<std::uint32_t> vertices_of_crowded_edges(const Polygons& polygons,
                                                     const Corners& corners) {
  if (!corners.has_shared()) return {};
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    if (corners.is_shared(a) || corners.is_shared(b)) edges.emplace_back(a, b);
  };
  for (std::size_t f = 0; f < polygons.size(); ++f) {
    const auto polygon = polygons.of(f);
    add(polygon.back(), polygon.front());
    for (std::size_t i = 1; i < polygon.size(); ++i) {
      add(polygon[i - 1], polygon[i]);
      if (i == 1 || i + 1 == polygon.size()) continue;
      add(polygon.front(), polygon[i]);
      add(polygon[i], polygon.front());
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<std::uint32_t> found;
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (edges[i] != edges[i - 1]) continue;
    for (const std::uint32_t vertex : {edges[i].first, edges[i].second})
      if (corners.is_shared(vertex)) found.push_back(vertex);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

/// The numbers of the polygons in the order of their corners: in lists of the first corners, below
/// `vertices`, each of those few by the others.
std::vector<std::uint32_t> order_of(const Polygons& polygons, std::size_t vertices) {
  std::vector<std::uint32_t> begin(vertices + 2, 0);
  for (std::size_t f = 0; f < polygons.size(); ++f) ++begin[polygons.of(f).front() + 2];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> order(polygons.size());
  for (std::uint32_t f = 0; f < polygons.size(); ++f)
    order[begin[polygons.of(f).front() + 1]++] = f;
  for (std::size_t v = 0; v < vertices; ++v)
    std::sort(order.begin() + begin[v], order.begin() + begin[v + 1],
              [&](std::uint32_t a, std::uint32_t b) {
                return std::ranges::lexicographical_compare(polygons.of(a), polygons.of(b));
              });
  return order;
}

/// The polygons in the order of their corners.
void put_polygons(const Polygons& polygons, PowerCrustSurface& surface) {
  const std::vector<std::uint32_t> sorted = order_of(polygons, surface.vertices.size());
  surface.corners.reserve(polygons.corners.size());
  surface.polygon_begin.reserve(polygons.begin.size());
  surface.polygon_begin.push_back(0);
  for (const std::uint32_t f : sorted) {
    const auto polygon = polygons.of(f);
    surface.corners.insert(surface.corners.end(), polygon.begin(), polygon.end());
    surface.polygon_begin.push_back(static_cast<std::uint32_t>(surface.corners.size()));
  }
}

}  // namespace

PowerCrustSurface faces_between(std::span<const Vec3> points, const PolarBalls& balls,
                                const Tetrahedra& power, std::span<const std::uint8_t> inner,
                                const StopToken* stop) {
  FaceWalk faces(power, inner);
  faces.run(stop);
  Corners corners(faces, power);
  Polygons polygons = polygons_of(faces, corners);
  // Where every tetrahedron has a vertex of its own, an edge has two triangles: the faces are the
  // border of a union of cells, of which three meet at an edge.
  for (auto crowded = vertices_of_crowded_edges(polygons, corners); !crowded.empty();
       crowded = vertices_of_crowded_edges(polygons, corners)) {
    check_stop(stop);
    corners.split(crowded);
    polygons = polygons_of(faces, corners);
  }
  PowerCrustSurface surface;
  corners.put_vertices(points, balls, surface);
  put_polygons(polygons, surface);
  return surface;
}

std::vector<Triangle> triangles_of(const PowerCrustSurface& surface) {
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < surface.polygons(); ++f) {
    const std::uint32_t begin = surface.polygon_begin[f], end = surface.polygon_begin[f + 1];
    for (std::uint32_t i = begin + 1; i + 1 < end; ++i)
      triangles.push_back(smallest_first(
          Triangle{surface.corners[begin], surface.corners[i], surface.corners[i + 1]}));
  }
  sort_triangles(surface.vertices.size(), triangles);
  return triangles;
}

}  // namespace orbweave::voronoi
