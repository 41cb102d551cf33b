// What decides the surface of given points: normals and holes. A job and the library's front door
// (engine/reconstruct.h) take the same options.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "io/vec3.h"

namespace orbweave {

/// Where normals come from.
enum class NormalSource {
  kAuto,      ///< those of the cloud; estimated where it has none
  kFile,      ///< those of the cloud; bad input where it has none
  kEstimate,  ///< estimated, whatever the cloud has
  kPoles      ///< directions to the poles of the Voronoi cells, whatever the cloud has; jobs alone
};

/// What decides to which side of the surface an estimated normal points. Given normals keep theirs.
enum class Orientation {
  kAuto,       ///< the first that is known: scanner, viewpoint, up direction; else propagation
  kScanner,    ///< towards the place of the scanner; needs scans that say it
  kViewpoint,  ///< towards NormalOptions::viewpoint, which has to be given
  kUp,         ///< to the side of NormalOptions::up; +z where it is not given
  kPropagate,  ///< neighbours agree, closed surfaces point outward (docs/normals.md)
  kGround,     ///< scanner or viewpoint; else propagation, with the ground towards the side of up
  kInward,     ///< neighbours agree, closed surfaces point inward: rooms seen from inside
  kNone        ///< no rule: the largest component is positive
};

/// How points get normals.
struct NormalOptions {
  NormalSource source = NormalSource::kAuto;
  /// Neighbours per estimated normal, 3 to 256. More: less noise, less detail, more time.
  int neighbors = 16;
  Orientation orientation = Orientation::kAuto;
  std::optional<Vec3> viewpoint;  ///< world coordinates; normals point towards it
  /// A direction of any length but zero; normals point to its side. For kGround: the normals of the
  /// ground; +z where it is not given.
  std::optional<Vec3> up;
};

/// Radial basis function that shapes a patch: over a plane, in space.
enum class FillKernel {
  kBiharmonic,  ///< r^2 log r, r: the least bending
  kTriharmonic  ///< r^4 log r, r^3: the least change of bending
};

/// Which holes are filled, and how. A limit that is exceeded leaves the hole open, and HoleFacts
/// says so.
struct FillOptions {
  bool enabled = true;  ///< false: no hole is filled, and none is listed
  FillKernel kernel = FillKernel::kBiharmonic;
  /// Radius of the neighbourhood that shapes a patch, in radii of the hole; at least 1. More: the
  /// patch follows the surface farther out, and takes more time.
  double neighborhood = 2.0;
  /// Largest diameter of a loop that is filled, world units; infinity: no limit. Empty: what the
  /// scan says (docs/holes.md): closed objects are closed, and in open scenes gaps of more than
  /// some fifty spacings from side to side stay open, unless keep_outer_border is false.
  std::optional<double> max_diameter;
  /// Largest perimeter of a loop that is filled, world units. Default: infinity, no limit.
  double max_perimeter = std::numeric_limits<double>::infinity();
  std::uint64_t max_edges = 0;  ///< largest number of edges of a loop that is filled; 0: no limit
  /// Where every candidate patch intersects the surface: use the one with the fewest intersections
  /// (true), or its part that intersects nothing, and leave the rest of the hole open (false).
  bool allow_intersections = false;
  /// The outer border of an open sheet stays open (true), or is filled like any hole (false).
  bool keep_outer_border = true;
  /// Triangles of a patch grow with their distance from the rim beyond some dozen of its edges
  /// (true), or are as small everywhere (false).
  bool graded = true;
  /// Components of fewer triangles are removed before holes are looked for; 0: none is. Empty:
  /// crumbs that noise leaves beside a surface, of fewer than 16 triangles where the largest
  /// component has 1,000 or more, and loose sheets of less than a 500th of it beside a closed
  /// object; of a mesh from elsewhere, none.
  std::optional<std::uint64_t> min_triangles;
};

/// How the tiles of levels of detail are compressed. kMeshopt: GLB files with the extension
/// EXT_meshopt_compression, without loss.
enum class TileCompression { kNone, kMeshopt };

/// How far a mesh is to be simplified: one of three limits.
struct SimplifyTarget {
  enum class Kind {
    kRatio,      ///< triangles kept, as a share of all: above 0, at most 1
    kTriangles,  ///< most triangles: an integer of at least 1
    kError       ///< most distance between the two surfaces, world units: above 0, finite
  };
  Kind kind = Kind::kRatio;
  double value = 1.0;
};

}  // namespace orbweave
