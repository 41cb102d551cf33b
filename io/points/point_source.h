// Where points come from: a stream of batches, whatever the file format.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/box.h"
#include "io/point_cloud.h"
#include "io/points/dropped_points.h"
#include "io/points/scan_pose.h"

namespace orbweave {

/// Where a scanner stood, or, for one so far away that only its direction matters, where it lies.
struct ScannerPlace {
  Vec3 vector;                ///< a place, or the direction from the points to the scanner
  bool is_direction = false;  ///< `vector` is a direction
  friend bool operator==(const ScannerPlace&, const ScannerPlace&) = default;
};

/// Which scan of several files points are of; both numbers count from 0.
struct ScanNumber {
  std::uint32_t file = 0;  ///< of a list of files
  std::uint32_t scan = 0;  ///< of those in the file
  friend auto operator<=>(const ScanNumber&, const ScanNumber&) = default;
};

/// One of the scans of a file.
struct ScanFacts {
  std::string name;    ///< may be empty
  std::string sensor;  ///< vendor and model, where the file says
  std::uint64_t points = 0;
  std::optional<RigidMotion> pose;  ///< from the scan's own coordinates; a matrix of PTX may scale
  std::optional<ScannerPlace> scanner;  ///< in the coordinates of the points
};

/// What a file says of itself, beside its points.
struct FileFacts {
  std::string format;    ///< "LAS", "E57", "text", ...
  std::string version;   ///< of the format, such as "1.2"; empty where formats have none
  std::string encoding;  ///< such as "binary_little_endian"; empty where the format has but one
  std::optional<int> point_format;       ///< of LAS
  std::string software;                  ///< that wrote the file, where it says
  std::optional<Box> declared_bounds;    ///< by the header, which may be wrong
  std::vector<ScanFacts> scans;          ///< of formats that hold scans; as far as they were read
  std::string faces;                     ///< of a mesh, whose points alone are read, in words
  std::vector<std::string> lost_values;  ///< of its points, that no attribute has, in words
  std::vector<std::string> left_out;     ///< what else it holds and no point has, in words
  bool has_unused_normals = false;       ///< normals that are there and not taken
};

/// A cloud read once, front to back, in bounded memory. Damaged and hostile files end in an Error.
/// A source is for one thread at a time; several sources may be read at once, of one file too.
class PointSource {
 public:
  virtual ~PointSource() = default;
  virtual const PointSchema& schema() const = 0;
  /// Points the file's header promises; nothing where the format does not say. PLY keeps the
  /// promise or read() throws; a .pts file may hold more, a LAS file fewer (left_out()).
  virtual std::optional<std::uint64_t> declared_points() const = 0;
  /// Whether as many points as declared come out, or read() throws.
  virtual bool keeps_declared_points() const { return declared_points().has_value(); }
  /// Replaces batch by the next points, at most `capacity` of them, in file order, values
  /// unfiltered (NaN included). Returns false, with an empty batch, at the end.
  /// Throws Error (bad input) with file and place where the file is damaged.
  virtual bool read(PointCloud& batch, std::size_t capacity) = 0;
  /// Before the first read(): leaves rows [first, first + count) of those declared and no others,
  /// so that several processes can share a file. Returns false, and changes nothing, where the
  /// format has no way to get there without reading what comes before.
  virtual bool restrict_rows(std::uint64_t /*first*/, std::uint64_t /*count*/) { return false; }
  /// Whether restrict_rows() leaves exactly the rows asked for, whichever these are. A list of
  /// files does not where it has one that is read as a whole or not at all.
  virtual bool has_row_access() const { return false; }
  /// Before the first read(): parts of the file (the whole of it, or a scan) may be passed over
  /// where `is_outside` says so of the bounds that the file declares for them, in the coordinates
  /// of the points. Their points count as left out (kOutsideCrop). Bounds that the first points of
  /// a part contradict are not believed.
  virtual void skip_parts(const std::function<bool(const Box& bounds)>& /*is_outside*/) {}
  /// Before the first read(): attributes that `is_wanted` does not want may be passed over, where
  /// the format can do so; schema() lacks them then.
  virtual void skip_attributes(const std::function<bool(const std::string& name)>& /*is_wanted*/) {}
  /// Progress: bytes of the file consumed so far (compressed bytes for .gz), and its size.
  virtual std::uint64_t bytes_read() const = 0;
  virtual std::uint64_t bytes_total() const = 0;
  /// Where the points of the last batch were seen from, in their coordinates, where the file says;
  /// no batch mixes scans that were taken from different places.
  virtual std::optional<ScannerPlace> scanner() const { return std::nullopt; }
  /// Which scan the points of the last batch are of; no batch mixes scans.
  virtual ScanNumber scan() const { return {}; }
  /// What the file says of itself; at the end of the file it is all known.
  virtual FileFacts facts() const { return {}; }
  /// Rows of the file that hold no point (a laser pulse without return), so far, by reason.
  virtual DroppedPoints left_out() const { return {}; }
  /// Coordinate reference system: WKT, "EPSG:26912", "EPSG:26912+5703" with heights, or the file's
  /// own words; empty where the file does not say.
  virtual std::string coordinate_system() const { return {}; }
  /// Metres per unit of x, y and z, where the file says; by default what coordinate_system() says.
  virtual std::optional<Vec3> meters_per_unit() const;
};

/// All that a file holds and no point has, in words.
std::vector<std::string> not_read(const FileFacts& facts);

/// Where the scanners of a file stood whose points were read, where it says.
std::vector<ScannerPlace> scanner_places(const PointSource& source);

/// Reads a whole source into memory.
PointCloud read_all(PointSource& source);

}  // namespace orbweave
