// A job: everything that decides what a run does. Job files and command lines both end here.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "io/point_source.h"

namespace orbweave {

struct InputOptions {
  std::vector<std::string> files;  ///< paths and globs, relative to the job file
  TextOptions text;                ///< columns and separator of text clouds
};

struct PartitionOptions {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< budget of the whole process
  std::uint64_t chunk_points = 0;                       ///< 0: from the budget ("auto")
};

enum class ReconstructionMethod { kBallPivoting };

struct ReconstructOptions {
  ReconstructionMethod method = ReconstructionMethod::kBallPivoting;
  std::vector<double> ball_radii;  ///< ascending, world units; empty: "auto"
  int levels = 1;                  ///< number of automatic radii, 1 to 8
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
  std::string report;            ///< path of the JSON report; empty: none
  std::string picture;           ///< path of a PNG of the mesh; empty: none
  /// Red, green and blue of filled holes in the picture.
  std::array<std::uint8_t, 3> patch_color = {0x80, 0xa8, 0xe2};
};

struct RunOptions {
  int threads = 0;       ///< 0: all
  std::string work_dir;  ///< empty: "<mesh without extension>.work"
  bool keep_work_dir = false;
  bool fresh = false;  ///< drop what an earlier run left (command line only)
};

struct Job {
  InputOptions input;
  PartitionOptions partition;
  ReconstructOptions reconstruct;
  FillOptions fill;
  OutputOptions output;
  RunOptions run;
};

}  // namespace orbweave
