// What a reconstruction of the Voronoi family tells beside its mesh.
#pragma once

#include <cstdint>

namespace orbweave {

/// Of a chunk, or of all of them.
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

}  // namespace orbweave
