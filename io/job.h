// A job: everything that decides what a run does. Job files and command lines both end here.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "io/point_source.h"
#include "io/scan_source.h"

namespace orbweave {

struct InputOptions {
  std::vector<std::string> files;  ///< paths and globs, relative to the job file
  TextOptions text;                ///< columns and separator of text clouds
  std::string poses;               ///< path of a Stanford .conf with a pose per scan; empty: none
  std::vector<ScanPose> pose;      ///< poses written in the job file itself, by scan
  std::vector<std::string> pose_lines;  ///< the same as written
  /// Where the scanner stood, or in which direction it lies, in each scan's own coordinates before
  /// its pose; empty: what the file says, and otherwise what its pose implies.
  std::optional<ScannerPlace> scanner;
  std::vector<int> las_classes;  ///< point classes wanted, 0 to 255; empty: all
  ReturnFilter returns = ReturnFilter::kAll;
  double units_per_meter = 1.0;  ///< for sanity checks and reports only
};

/// Optional clean-up, in this order; off by default.
struct PrepareOptions {
  bool automatic = false;  ///< choose all of the below by measuring the scans
  /// A point is an outlier when it lies so many deviations farther from its neighbours than they
  /// lie from theirs; 0: off.
  double outlier_sigma = 0.0;
  double merge_tolerance = 0.0;  ///< points closer than that become one; world units; 0: off
  double smooth_radius = 0.0;    ///< of the moving least squares; world units; 0: off
  int smooth_passes = 2;         ///< projections, 1 to 8
  double thin_to_spacing = 0.0;  ///< world units; 0: off
};

enum class NormalSource { kAuto, kFile, kEstimate };
enum class Orientation { kAuto, kScanner, kViewpoint, kUp, kPropagate, kNone };

struct NormalOptions {
  NormalSource source = NormalSource::kAuto;  ///< kAuto: the file's, estimated where it has none
  int neighbors = 16;                         ///< points that a normal is estimated from, 3 to 256
  Orientation orientation = Orientation::kAuto;
  std::optional<Vec3> viewpoint;  ///< world coordinates; normals point towards it
  std::optional<Vec3> up;         ///< a direction; normals point to its side
};

struct PartitionOptions {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< budget of the whole process
  std::uint64_t chunk_points = 0;                       ///< 0: from the budget ("auto")
};

enum class ReconstructionMethod { kBallPivoting };

struct ReconstructOptions {
  ReconstructionMethod method = ReconstructionMethod::kBallPivoting;
  std::vector<double> ball_radii;  ///< ascending, world units; empty: "auto"
  int levels = 0;                  ///< number of automatic radii, 1 to 8; 0: from the density
};

enum class FillKernel { kBiharmonic, kTriharmonic };

struct FillOptions {
  bool enabled = true;
  FillKernel kernel = FillKernel::kBiharmonic;
  /// Points within this many times the hole's radius of its centre shape the patch; at least 1.
  double neighborhood = 2.0;
  double max_diameter = std::numeric_limits<double>::infinity();   ///< world units
  double max_perimeter = std::numeric_limits<double>::infinity();  ///< world units
  std::uint64_t max_edges = 0;                                     ///< of a loop; 0: no limit
  /// A hole that only a patch closes which meets the surface is closed by the one that does so
  /// least; false: it stays open.
  bool allow_intersections = true;
  bool keep_outer_border = true;    ///< the outer border of an open sheet stays open
  std::uint64_t min_triangles = 0;  ///< separate pieces of fewer triangles are removed; 0: none
};

struct OutputOptions {
  std::string mesh;  ///< path; format by extension
  bool binary = true;
  bool float_positions = false;  ///< "float" coordinates instead of double
  bool attributes = true;        ///< carry normals and attributes to the vertices
  bool tiles = false;            ///< one mesh per chunk instead of one mesh
  std::string report;            ///< path of the JSON report; empty: none
  std::string picture;           ///< path of a PNG of the mesh; empty: none
  /// Red, green and blue of filled holes in the picture.
  std::array<std::uint8_t, 3> patch_color = {0x80, 0xa8, 0xe2};
};

struct RunOptions {
  int threads = 0;       ///< 0: all
  std::string work_dir;  ///< empty: "<mesh without extension>.work"
  bool keep_work_dir = false;
  bool compress = false;  ///< what the work directory holds; takes time, saves space
  bool fresh = false;     ///< drop what an earlier run left (command line only)
};

struct Job {
  InputOptions input;
  PartitionOptions partition;
  PrepareOptions prepare;
  NormalOptions normals;
  ReconstructOptions reconstruct;
  FillOptions fill;
  OutputOptions output;
  RunOptions run;
};

}  // namespace orbweave
