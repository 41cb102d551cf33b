// Where points come from: a stream of batches, whatever the file format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave {

/// Where a scanner stood, or, for one so far away that only its direction matters, where it lies.
struct ScannerPlace {
  Vec3 vector;                ///< a place, or the direction from the points to the scanner
  bool is_direction = false;  ///< `vector` is a direction
  friend bool operator==(const ScannerPlace&, const ScannerPlace&) = default;
};

/// Points left out, by reason.
using DroppedPoints = std::map<std::string, std::uint64_t>;

/// A cloud read once, front to back, in bounded memory.
class PointSource {
 public:
  virtual ~PointSource() = default;
  virtual const PointSchema& schema() const = 0;
  /// Points the file's header promises; nothing where the format does not say. PLY keeps the
  /// promise or read() throws; a .pts file may hold more.
  virtual std::optional<std::uint64_t> declared_points() const = 0;
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
  /// Progress: bytes of the file consumed so far (compressed bytes for .gz), and its size.
  virtual std::uint64_t bytes_read() const = 0;
  virtual std::uint64_t bytes_total() const = 0;
  /// Where the points of the last batch were seen from, in their coordinates, where the file says;
  /// no batch mixes scans that were taken from different places.
  virtual std::optional<ScannerPlace> scanner() const { return std::nullopt; }
  /// Rows of the file that hold no point (a laser pulse without return), so far, by reason.
  virtual DroppedPoints left_out() const { return {}; }
  /// Coordinate reference system: WKT, or "EPSG:26912"; empty where the file does not say.
  virtual std::string coordinate_system() const { return {}; }
};

/// How a text cloud's columns are to be understood; everything has a detected default.
struct TextOptions {
  std::vector<std::string> columns;  ///< e.g. {"x","y","z","nx","ny","nz"}; empty: detect
  char separator = '\0';             ///< '\0': detect (comma, semicolon, tab, blanks)
};

struct PointSourceOptions {
  TextOptions text;
};

/// Opens any supported cloud by extension (.ply .xyz .txt .csv .pts .ptx .pcd, each also with .gz;
/// .las .laz .e57) and by content; docs/formats.md says what each reader takes. A mesh file is read
/// as the cloud of its vertices. Throws Error: usage for an extension nobody reads (message lists
/// those that are), bad input for missing, unreadable and damaged files.
std::unique_ptr<PointSource> open_point_source(const std::filesystem::path& path,
                                               const PointSourceOptions& options = {});

/// Opens one file of several; an empty one stands for open_point_source with no options.
using PointSourceOpener =
    std::function<std::unique_ptr<PointSource>(const std::filesystem::path& path)>;

/// Several files as one stream, in the order given. Its schema carries the attributes (name and
/// type) that all files share; `notes` gets one line per attribute that is left out. A mixture
/// of files with and without normals is an error (bad input).
std::unique_ptr<PointSource> open_point_sources(const std::vector<std::filesystem::path>& paths,
                                                const PointSourceOpener& opener = {},
                                                std::vector<std::string>* notes = nullptr);

/// Reads a whole source into memory.
PointCloud read_all(PointSource& source);

}  // namespace orbweave
