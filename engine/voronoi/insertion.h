// The Delaunay triangulation of points that are inserted one by one.
// Bowyer, Computing Dirichlet tessellations, 1981; Watson, Computing the n-dimensional Delaunay
// tessellation, 1981.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/directed_edges.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

/// The triangulation so far, which the order of insertion does not decide. Some 300 bytes per
/// point of a surface.
class Insertion {
 public:
  /// The tetrahedron of four points that do not lie in one plane, and those at infinity around it.
  /// Insertion is fast where the points come in order, and each lies near the one before.
  Insertion(std::vector<Vec3> points, const std::array<std::uint32_t, 4>& first);

  /// Inserts a point. One that lies exactly on a vertex is no other.
  void add(std::uint32_t point);

  /// The tetrahedra, ordered by their vertices. These get indices of their own, those of the points
  /// in order; of several points in one place, the smallest. The insertion ends with it.
  Tetrahedra take(std::span<const std::uint32_t> indices, const StopToken* stop);

 private:
  /// A facet between a tetrahedron that the point takes away and one that stays.
  struct Rim {
    std::array<std::uint32_t, 4> vertices{};  ///< of the new tetrahedron, the point among them
    std::uint32_t outside = 0;                ///< the tetrahedron that stays
    std::uint32_t cell = 0;                   ///< the new tetrahedron
    std::uint32_t place = 0;                  ///< of the point
    std::uint32_t outside_place = 0;          ///< of the facet, in the tetrahedron that stays
  };

  /// A point in the place of a vertex.
  struct Copy {
    std::uint32_t vertex = 0, point = 0;
  };

  bool is_finite(std::uint32_t cell) const;
  std::uint32_t locate(const Vec3& p) const;
  std::uint32_t next_on_way(std::uint32_t cell, std::uint32_t from, const Vec3& p) const;
  int side_with(std::uint32_t cell, std::size_t place, const Vec3& p) const;
  bool is_known(std::uint32_t cell, std::uint32_t point);
  bool takes_away_exactly(std::uint32_t cell, const Vec3& p) const;
  void find_taken(std::uint32_t first, const Vec3& p);
  void ask_neighbors(std::uint32_t cell);
  void answer(const Vec3& p);
  std::array<bool, 2> are_inside(std::uint32_t first, std::uint32_t second, const Vec3& p) const;
  void take_away(std::uint32_t cell, bool is_inside);
  void make_room();
  void find_rim(std::uint32_t point);
  void fill();
  std::uint32_t new_cell();
  void connect();
  std::vector<std::uint32_t> numbers();
  void rename(std::span<const std::uint32_t> indices);

  /// Numbers of two tetrahedra side by side.
  using Two = double __attribute__((vector_size(16)));
  static constexpr std::size_t kAskedAtOnce = 16;
  static constexpr std::uint32_t kTaken = 1;  ///< added to a look: the tetrahedron is taken away

  std::vector<Vec3> points_;  // and behind them one that is no number
  std::uint32_t infinite_;    // the vertex at infinity: the index of that one
  double least_error_;        // squared: smaller ones may be those of what underflows
  std::vector<std::array<std::uint32_t, 4>> vertices_;  // per tetrahedron, as Tetrahedra has them
  std::vector<std::array<std::uint32_t, 4>> neighbors_;
  std::vector<std::uint32_t> free_;   // places of no tetrahedron
  std::vector<std::uint32_t> looks_;  // per tetrahedron, when it was looked at, and what came of it
  std::uint32_t look_ = 0;            // of the point that is inserted
  std::uint32_t last_ = 0;            // a tetrahedron of the point before
  // Tetrahedra whose spheres have the point inside, and behind them room for others.
  std::vector<std::uint32_t> taken_;
  std::size_t taken_count_ = 0;
  std::array<std::uint32_t, kAskedAtOnce + 5> asked_{};  // tetrahedra beside those
  std::size_t asked_count_ = 0;
  std::vector<Rim> rim_;
  DirectedEdges edges_;
  std::vector<Copy> copies_;
};

}  // namespace orbweave::voronoi
