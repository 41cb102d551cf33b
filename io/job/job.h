// A job: all options of a run. Job files and command lines are both parsed into a Job.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/clouds/scan_source.h"
#include "io/clouds/text_layout.h"
#include "io/points/point_source.h"
#include "io/surface_options.h"

namespace orbweave {

struct InputOptions {
  std::vector<std::string> files;  ///< paths and globs, relative to the job file
  TextOptions text;                ///< columns and separator of text clouds
  std::string poses;               ///< path of a Stanford .conf with a pose per scan; empty: none
  std::vector<ScanPose> pose;      ///< poses written in the job file itself, by scan
  std::vector<std::string> pose_lines;  ///< the same as written
  /// Position of the scanner, or direction towards the scanner, in the coordinates of each scan
  /// before its pose. Empty: what the file says, else what the pose implies.
  std::optional<ScannerPlace> scanner;
  /// Places of the scanners of merged scans, by the value of an attribute, which all of them name.
  std::vector<ScannerOfValue> scanners;
  std::vector<std::string> scanner_lines;   ///< the same as written
  std::string trajectory;                   ///< path of the scanner's own path; empty: none
  std::vector<int> las_classes;             ///< point classes to keep, 0 to 255; empty: all
  std::vector<int> drop_classes = {7, 18};  ///< classes to leave out, where las_classes is empty
  ReturnFilter returns = ReturnFilter::kAll;
  /// World coordinates; points outside are left out. A crop of x and y alone has no limits in z.
  std::optional<Box> crop;
  std::string crop_area;    ///< WKT of polygons, or the path of a WKT or GeoJSON file; empty: none
  std::uint64_t every = 1;  ///< keeps one in so many points; 1: all
  /// Keeps no-data values, missing returns at (0, 0, 0) and strays.
  bool keep_strays = false;
  /// For sanity checks and reports only. Empty: what the coordinate system of the scans says.
  std::optional<double> units_per_meter;
};

/// Optional cleaning, in this order; off by default.
struct CleaningOptions {
  bool automatic = false;  ///< derives the options below from the measured noise
  /// Outlier threshold in standard deviations: drops a point whose mean neighbour distance exceeds
  /// the mean of its neighbours by more than this. 0 disables it.
  double outlier_sigma = 0.0;
  double merge_tolerance = 0.0;  ///< points closer than this are merged; world units; 0: off
  double smooth_radius = 0.0;    ///< of the moving least squares; world units; 0: off
  int smooth_passes = 2;         ///< projections, 1 to 8
  double thin_to_spacing = 0.0;  ///< world units; 0: off
  /// Clusters of fewer points that lie apart from everything else are dropped; 0: off. Unset: 0, or
  /// what automatic cleaning chooses.
  std::optional<std::uint64_t> cluster_points;
  /// Points are dropped whose neighbours lie less like a surface: 1 a surface, 0 a line or a cloud.
  double min_surfaceness = 0.0;
};

struct PartitionOptions {
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  ///< budget of the whole process
  std::uint64_t chunk_points = 0;                       ///< 0: from the budget ("auto")
};

/// All but ball pivoting and Super Cocone work on the whole cloud at once, and so does Cocone where
/// the cloud fits the memory budget (docs/methods.md).
enum class ReconstructionMethod {
  kBallPivoting,
  kCrust,
  kPowerCrust,
  kCocone,
  kTightCocone,
  kSuperCocone
};

struct ReconstructOptions {
  ReconstructionMethod method = ReconstructionMethod::kBallPivoting;
  std::vector<double> ball_radii;  ///< ascending, world units; empty: "auto"
  int levels = 0;                  ///< number of automatic radii, 1 to 8; 0: from the density
};

/// What the colours of a picture tell: filled holes, how far their patches can be trusted, the
/// colours (else the intensity) of the scan, which triangles belong together, or where the scan is
/// sampled too sparsely.
enum class PictureColors { kPatches, kConfidence, kPoints, kComponent, kUndersampled };

/// Whether a picture shows the back faces of triangles. kAuto: they are left out of the picture of
/// an interior, so that one looks into it.
enum class PictureBacks { kAuto, kShown, kCulled };

/// Where the coordinates of a mesh file are counted from: kAuto: where those of the scans are, or,
/// where the file's numbers are too narrow for that, a place among the points.
enum class OriginRule { kAuto, kNone, kGiven };

/// Axis of the coordinates that is drawn upright. kAuto: what the scans imply.
enum class UpAxis { kAuto, kX, kY, kZ };

struct OutputOptions {
  std::string mesh;              ///< path; format by extension
  bool binary = true;            ///< where the format has a binary encoding
  bool requires_binary = false;  ///< refuses a format without one
  bool float_positions = false;  ///< "float" coordinates instead of double
  OriginRule origin_rule = OriginRule::kAuto;
  Vec3 origin;                  ///< of kGiven: is subtracted from coordinates; world units
  int color_bits = 8;           ///< most bits of a colour's channels: 8, or 16
  bool attributes = true;       ///< carries normals and attributes to the vertices
  bool confidence = false;      ///< PLY: faces carry the confidence of their patches
  bool vertex_quality = false;  ///< PLY: vertices carry spacing, noise, move and normal's origin
  bool vertex_undersampled = false;  ///< PLY: vertices carry where sampling is too sparse
  bool tiles = false;                ///< several meshes instead of one mesh
  double tile_size = 0.0;            ///< edge of the tiles' cells, world units; 0: by chunk
  std::string tileset;               ///< directory of 3D Tiles of the mesh; empty: none
  TileCompression tileset_compression = TileCompression::kNone;  ///< of its tiles
  std::string polygons;                    ///< path of a Power Crust's polygons; empty: none
  std::string medial_axis;                 ///< path of the balls of its medial axis; empty: none
  std::optional<SimplifyTarget> simplify;  ///< of a further, simplified mesh; none: no such mesh
  std::string simplified;                  ///< path of the simplified mesh; empty: beside the mesh
  bool check_surface = false;         ///< counts crossings of the whole mesh, not of patches alone
  std::string report;                 ///< path of the JSON report; empty: none
  std::string picture;                ///< path of a PNG of the mesh; empty: none
  UpAxis picture_up = UpAxis::kAuto;  ///< axis that is upright in the picture
  PictureColors picture_colors = PictureColors::kPatches;
  PictureBacks picture_backs = PictureBacks::kAuto;
  /// Red, green and blue of filled holes in the picture.
  std::array<std::uint8_t, 3> patch_color = {0x80, 0xa8, 0xe2};
};

struct RunOptions {
  int threads = 0;       ///< 0: all
  std::string work_dir;  ///< empty: "<mesh without extension>.work"
  bool keep_work_dir = false;
  bool compress = false;  ///< compresses the work directory: less space, more time
  bool fresh = false;     ///< drops what an earlier run left (command line only)
  /// Messages name options of the command line instead of keys of a job file.
  bool is_from_command_line = false;
};

struct Job {
  InputOptions input;
  PartitionOptions partition;
  CleaningOptions cleaning;
  NormalOptions normals;
  ReconstructOptions reconstruct;
  FillOptions fill;
  OutputOptions output;
  RunOptions run;
};

}  // namespace orbweave
