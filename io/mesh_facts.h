// Facts of a mesh.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>

#include "io/box.h"

namespace orbweave {

/// Facts of a mesh; also what `inspect --json` prints for one.
struct MeshFacts {
  std::uint64_t vertices = 0;  ///< vertices in the file
  std::uint64_t triangles = 0;
  std::uint64_t components = 0;      ///< connected over shared edges
  std::uint64_t boundary_edges = 0;  ///< edges of one triangle
  std::uint64_t boundary_loops = 0;
  std::uint64_t nonmanifold_edges = 0;     ///< edges of more than two triangles
  std::uint64_t nonmanifold_vertices = 0;  ///< vertices with more than one fan
  /// Places where sheets touch in a point, whether or not the vertex there was doubled; empty: not
  /// known.
  std::optional<std::uint64_t> pinches;
  /// Triangles of the scan that were taken out so that holes are closed soundly.
  std::uint64_t mended_triangles = 0;
  std::uint64_t inconsistent_edges = 0;    ///< directed edges used twice
  std::uint64_t degenerate_triangles = 0;  ///< two equal vertices
  std::uint64_t duplicate_triangles = 0;
  std::uint64_t unreferenced_vertices = 0;
  /// Pairs of triangles that intersect beyond what they share; empty: not looked for.
  std::optional<std::uint64_t> crossing_pairs;
  /// Those of them with a triangle of a filled hole.
  std::optional<std::uint64_t> patch_crossing_pairs;
  std::int64_t euler_characteristic = 0;  ///< of the referenced vertices
  double area = 0.0;                      ///< square world units
  /// Within the triangles of the scan, counted from the middle of the points, cubic world units;
  /// negative: they face inward. Rough unless the surface is closed without patches.
  double scanned_volume = 0.0;
  double patch_area = 0.0;  ///< of filled holes, as far as they are known
  bool watertight = false;  ///< closed, manifold, consistently oriented
  std::string checksum;     ///< of coordinates and oriented triangles only
  Box bounds;
};

/// What a reconstruction of the Voronoi family tells beside its mesh, of a chunk or of all of them.
struct VoronoiFacts {
  std::uint64_t undersampled_points = 0;  ///< too sparse for the shape that they lie on
  /// Points whose Voronoi cell may be another one in the whole cloud; 0 where that was at hand.
  std::uint64_t uncertified_points = 0;
  std::uint64_t grown_boxes = 0;  ///< chunks that were computed again with more around them
  /// Triangles across chunks that some of the chunks concerned have and others do not.
  std::uint64_t contested_triangles = 0;
  std::uint64_t seam_triangles = 0;  ///< triangles across chunks that all of them have

  VoronoiFacts& operator+=(const VoronoiFacts& other) {
    undersampled_points += other.undersampled_points;
    uncertified_points += other.uncertified_points;
    grown_boxes += other.grown_boxes;
    contested_triangles += other.contested_triangles;
    seam_triangles += other.seam_triangles;
    return *this;
  }
};

/// Whether normals that were given fit the points and each other. Counts of one in one_in() points.
struct SideFacts {
  /// Of large clouds fewer points say as much.
  static constexpr std::uint64_t one_in(std::uint64_t points_of_cloud) {
    constexpr std::uint64_t kLeast = 4, kEnough = std::uint64_t{1} << 17;
    return std::max(kLeast, std::bit_floor(points_of_cloud / kEnough));
  }
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::uint64_t looked = 0;  ///< those that have enough neighbours
  std::uint64_t steep = 0;  ///< most neighbours lie in the normal's direction rather than beside it
  std::uint64_t smooth = 0;  ///< the point and its neighbours lie on one surface, by their normals
  std::uint64_t seams = 0;  ///< of the smooth points, those with neighbours that face the other way
  std::uint64_t upward = 0;          ///< normals within 45 degrees of the positive z axis
  std::uint64_t downward = 0;        ///< and of the negative one
  std::uint64_t first_seam = kNone;  ///< canonical number of the first of them
  Vec3 place;                        ///< of that one

  SideFacts& operator+=(const SideFacts& other) {
    looked += other.looked;
    steep += other.steep;
    smooth += other.smooth;
    seams += other.seams;
    upward += other.upward;
    downward += other.downward;
    if (other.first_seam < first_seam) {
      first_seam = other.first_seam;
      place = other.place;
    }
    return *this;
  }
};

}  // namespace orbweave
