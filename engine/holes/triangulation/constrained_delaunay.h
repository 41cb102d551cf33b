// The triangulation behind triangulate_polygon, inside a square frame around all points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/half_edges.h"
#include "engine/holes/triangulation/corner_triangle.h"
#include "engine/holes/triangulation/plane_point.h"

namespace orbweave {

class ConstrainedDelaunay {
 public:
  /// Points are numbered as in triangulate_polygon; all within kPlaneExtent.
  ConstrainedDelaunay(std::span<const PlanePoint> points, std::uint32_t corners);

  /// Triangulates the corners with the polygon's edges and tells inside from outside. False where
  /// the polygon is not weakly simple.
  bool insert_polygon();
  /// Inserts the other points, those inside.
  void insert_interior();
  /// Gives every corner its own triangles where corners coincide. False where they are not one
  /// fan. No point may be inserted after it.
  bool separate_corners();
  void avoid_chords(const ForbiddenChord& is_forbidden);
  std::vector<CornerTriangle> inside() const;

 private:
  struct Location {
    std::uint32_t h = 0;  ///< of the triangle, or the edge, or starting at the vertex
    enum class At : std::uint8_t { kTriangle, kEdge, kVertex } at = At::kTriangle;
  };
  struct Crossed;
  enum class Side : std::uint8_t { kUnknown, kInside, kOutside };

  PlanePoint at(std::uint32_t vertex) const { return points_[vertex]; }
  std::int64_t turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return orientation(at(a), at(b), at(c));
  }
  bool is_constrained(std::uint32_t h) const {
    return corner_[h] != kNone32 || (mesh_.twin[h] != kNone32 && corner_[mesh_.twin[h]] != kNone32);
  }
  bool is_inside(std::uint32_t h) const { return side_[h / 3] == Side::kInside; }

  Location locate(PlanePoint p);
  void insert(std::uint32_t vertex, const Location& where);
  void split_triangle(std::uint32_t h, std::uint32_t vertex);
  void split_edge(std::uint32_t h, std::uint32_t vertex);
  void flip(std::uint32_t h);
  void legalize();

  bool constrain(std::uint32_t corner);
  std::uint32_t first_crossed(std::uint32_t a, std::uint32_t b, bool& exists) const;
  bool collect_crossed(std::uint32_t a, std::uint32_t b, std::uint32_t h, Crossed& crossed) const;
  void fill_side(std::uint32_t a, std::uint32_t b, std::span<const std::uint32_t> chain,
                 std::vector<CornerTriangle>& out) const;
  void replace(const Crossed& crossed, std::span<const CornerTriangle> triangles);
  bool tag(std::uint32_t h, std::uint32_t corner);
  bool find_sides();
  bool spread(std::uint32_t h, Side side, std::vector<std::uint32_t>& reached);
  bool chord_can_flip(std::uint32_t h, const ForbiddenChord& is_forbidden) const;
  bool is_bad_chord(std::uint32_t a, std::uint32_t b, const ForbiddenChord& is_forbidden) const {
    return a < corners_ && b < corners_ && is_forbidden(a, b);
  }

  std::vector<PlanePoint> points_;  ///< and the four corners of the frame
  std::uint32_t corners_;
  HalfEdges mesh_;
  std::vector<std::uint32_t> corner_;   ///< per half-edge: the corner whose polygon edge it is
  std::vector<Side> side_;              ///< per triangle
  std::vector<std::uint32_t> site_;     ///< per corner: the vertex that stands for it
  std::vector<std::uint32_t> suspect_;  ///< half-edges to be legalized, opposite the new vertex
  std::uint32_t last_ = 0;              ///< a half-edge near the last insertion
  std::uint64_t random_ = 0;            ///< state of the choices of the walk
};

}  // namespace orbweave
