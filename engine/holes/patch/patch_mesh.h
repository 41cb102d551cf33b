// A patch while it is made: triangles of a disc with their neighbours, and what may be done to
// them. The rim's edges and the loop's vertices are never touched.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/geometry/half_edges.h"
#include "engine/holes/problem/hole.h"
#include "engine/holes/triangulation/loop_triangulation.h"
#include "engine/holes/triangulation/plane_triangulation.h"

namespace orbweave {

/// The sheet along the rim. Triangles refer to corners by their numbers, to other vertices from
/// the number of corners on.
struct RimSheet {
  std::vector<Vec3> positions;  ///< of the other vertices
  std::vector<CornerTriangle> triangles;
  std::vector<char> is_whole;  ///< per corner: all triangles of the sheet at it are there
};

/// A triangulated disc in space, refined and relaxed. No operation makes an edge that the patch
/// has already between the same mesh vertices, that is forbidden, or that joins corners of one
/// vertex; none turns a face over. All are deterministic, with ties decided by vertex numbers.
class PatchMesh {
 public:
  /// `positions`: first the loop's corners, then interior points (not all need be used);
  /// `vertices`: mesh vertex of each corner; `triangles`: a disc whose boundary is the loop, each
  /// edge once; `forbidden`, `apart` as in HoleProblem. Without triangles where these are no such
  /// disc.
  PatchMesh(std::vector<Vec3> positions, std::span<const std::uint32_t> vertices,
            std::span<const CornerTriangle> triangles,
            std::span<const std::array<std::uint32_t, 2>> forbidden,
            std::span<const std::array<std::uint32_t, 2>> apart = {});

  const std::vector<Vec3>& positions() const { return positions_; }
  std::vector<Vec3>& positions() { return positions_; }
  std::uint32_t corners() const { return corners_; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(positions_.size()); }
  std::vector<CornerTriangle> triangles() const;

  /// Splits edges inside that are longer than `longest` at their midpoints, longest first and with
  /// flips in between, until there is none or `max_points` new ones were made. An edge stays where
  /// the new point would come closer than a quarter of `longest` to a longer edge (beside long
  /// edges of the rim). Returns how many.
  std::uint32_t split_long_edges(double longest, std::uint32_t max_points,
                                 const StopToken* stop = nullptr);
  /// Joins an interior point with its neighbour over edges shorter than `shortest` where the disc
  /// stays sound. Points that are joined keep their number, but no triangle uses them.
  std::uint32_t collapse_short_edges(double shortest);
  /// Flips edges until every edge inside is locally Delaunay in space (opposite angles sum to at
  /// most pi) as far as allowed, and as far as the least angle of the two triangles grows (in
  /// space the two are not the same; it is why this ends). Creases are not made sharper than they
  /// are or than 60 degrees. Returns how many flips were made.
  std::uint32_t flip_to_delaunay();
  /// Splits every edge inside that is forbidden, joins corners of one vertex, or repeats an edge
  /// between the same mesh vertices, at its midpoint (in the middle of its triangles where it has
  /// no length). Returns how many.
  std::uint32_t split_forbidden_chords();
  /// Moves interior points to where the energy of order 1 (membrane: squared gradient) or 2 (thin
  /// plate: squared Laplacian) is least, with cotangents of the patch as it is; the rim stays. With
  /// order 2 the energy counts at corners where the sheet is whole too, and so makes the patch
  /// tangent to it. Where the system cannot be solved nothing moves.
  /// Desbrun, Meyer, Schroeder, Barr: Implicit Fairing, SIGGRAPH 1999, section 4; Liepa 2003,
  /// section 5.
  void smooth(int order, const RimSheet& sheet = {});
  /// Neighbours of every vertex over edges of the patch, its rim among them, ascending.
  std::vector<std::vector<std::uint32_t>> neighbors() const;
  /// What is wrong with the disc: edges of other than two triangles inside or of one at the rim, a
  /// boundary that is not the loop, vertices of several fans, pieces; empty: nothing.
  std::string defect() const;

 private:
  Vec3 at(std::uint32_t vertex) const { return positions_[vertex]; }
  /// The same number for corners of the same mesh vertex, another for everything else.
  std::uint32_t identity(std::uint32_t vertex) const {
    return vertex < corners_ ? first_visit_[vertex] : vertex;
  }
  bool is_forbidden(std::uint32_t a, std::uint32_t b) const;
  bool is_joined(std::uint32_t a, std::uint32_t b) const;
  bool may_join(std::uint32_t a, std::uint32_t b) const;
  bool is_long(std::uint32_t h, double longest) const;
  std::uint32_t split(std::uint32_t h, Vec3 position);
  std::uint32_t split_pass(double longest, std::uint32_t max_points);
  std::vector<std::uint32_t> edges_to_split() const;
  std::uint32_t flip_changed();
  bool flip_improves(std::uint32_t h) const;
  bool flip_keeps_shape(std::uint32_t h) const;
  void drop_unused(std::uint32_t first);
  std::uint32_t collapse_down_to(double shortest, std::uint32_t first);
  std::uint32_t collapse_pass(double shortest, std::uint32_t first);
  bool can_collapse(std::uint32_t h) const;
  void collapse(std::uint32_t h);
  std::uint32_t find_edge(std::uint32_t a, std::uint32_t b) const;

  std::vector<Vec3> positions_;
  std::uint32_t corners_ = 0;
  std::vector<std::uint32_t> vertices_;
  std::vector<std::uint32_t> first_visit_;  ///< per corner: the first corner of its vertex
  std::vector<std::uint32_t> next_visit_;   ///< per corner: the next one of its vertex, in a cycle
  std::vector<std::array<std::uint32_t, 2>> forbidden_, apart_;
  HalfEdges mesh_;
  /// Per triangle: some edge of it may be worth a flip, as far as that is not known to be none.
  std::vector<std::uint8_t> is_changed_;
};

}  // namespace orbweave
