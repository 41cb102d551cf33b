#include "io/clouds/open_point_source.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "io/clouds/e57/e57_source.h"
#include "io/clouds/las/las_source.h"
#include "io/clouds/pcd_source.h"
#include "io/clouds/ply_source.h"
#include "io/clouds/ptx_source.h"
#include "io/clouds/text_source.h"
#include "io/error.h"
#include "io/meshes/mesh_parsers.h"
#include "io/meshes/shift_file.h"
#include "io/ply/ply_vertices.h"
#include "io/points/coordinate_system_file.h"
#include "io/streams/byte_source.h"
#include "io/streams/random_access.h"
#include "io/streams/stoppable.h"
#include "io/text/file_format.h"

namespace orbweave {
namespace {

/// The vertices of a mesh whose format does not list them plainly (OBJ, STL): read in core.
class MeshVertices final : public PointSource {
 public:
  MeshVertices(ByteReader reader, MeshFormat format)
      : format_(format),
        bytes_total_(reader.source().bytes_total()),
        vertices_(read_mesh(std::move(reader), format).vertices) {}
  const PointSchema& schema() const override { return vertices_.schema; }
  std::optional<std::uint64_t> declared_points() const override { return vertices_.size(); }
  FileFacts facts() const override {
    FileFacts facts;
    facts.format = format_ == MeshFormat::kObj   ? "OBJ"
                   : format_ == MeshFormat::kGlb ? "GLB"
                                                 : "STL";
    return facts;
  }
  std::uint64_t bytes_read() const override { return bytes_total_; }
  std::uint64_t bytes_total() const override { return bytes_total_; }

  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.clear();
    batch.schema = vertices_.schema;
    const std::size_t end = next_ + std::min(capacity, vertices_.size() - next_);
    for (; next_ < end; ++next_) batch.append(vertices_, next_);
    return !batch.empty();
  }

 private:
  MeshFormat format_;
  std::uint64_t bytes_total_;
  PointCloud vertices_;
  std::size_t next_ = 0;
};

/// A scan whose format takes its name, or a file that can be read in any order, to be known.
void refuse_binary_scan(ByteReader& reader) {
  for (const auto& [front, names] : {std::pair(std::string_view("LASF"), ".las or .laz"),
                                     std::pair(std::string_view("ASTM-E57"), ".e57")})
    if (reader.ensure(front.size()) && std::memcmp(reader.data(), front.data(), front.size()) == 0)
      throw_bad_input("this format cannot be read from standard input or under this name",
                      {.file = reader.name(),
                       .found = "\"" + std::string(front) + "\"",
                       .expected = std::string("a file named ") + names});
}

/// Files are decompressed on the way; what is still compressed came from standard input, or is of
/// an archive in an archive.
void refuse_compressed(ByteReader& reader) {
  constexpr std::string_view kGzip = "\x1f\x8b";
  if (!reader.ensure(kGzip.size()) || std::memcmp(reader.data(), kGzip.data(), kGzip.size()) != 0)
    return;
  throw_bad_input("the cloud is compressed by gzip",
                  {.file = reader.name(),
                   .expected = "a cloud that is not compressed",
                   .advice = "Decompress it first: gunzip -c FILE.gz | orbweave ..."});
}

[[noreturn]] void throw_unknown_extension(const std::filesystem::path& path) {
  throw_usage("cannot read " + files_of_name(path, "clouds") +
                  "; supported: " + extensions_of_read_clouds(),
              {.file = path.string()});
}

/// The format that a name stands for, where it is read.
std::optional<NamedFormat> read_format(const std::filesystem::path& path) {
  const std::optional<NamedFormat> named = format_of_name(path);
  return named && named->facts.is_read ? named : std::nullopt;
}

std::unique_ptr<PointSource> open_ptx_file(const std::filesystem::path& path, ByteReader reader,
                                           const StopToken* stop) {
  // A pipe can be read only once.
  if (!std::filesystem::is_regular_file(path)) return open_ptx_source(std::move(reader));
  return open_ptx_source(std::move(reader),
                         [&] { return ByteReader(stoppable(open_byte_source(path), stop)); });
}

}  // namespace

void check_scan_name(const std::filesystem::path& path) {
  if (!read_format(path)) throw_unknown_extension(path);
}

namespace {

TextKind kind_of(FileFormat format) {
  switch (format) {
    case FileFormat::kPts:
      return TextKind::kPts;
    case FileFormat::kXyzn:
      return TextKind::kNormals;
    case FileFormat::kXyzrgb:
      return TextKind::kColors;
    default:
      return TextKind::kAny;
  }
}

std::unique_ptr<PointSource> open_format(const std::filesystem::path& path,
                                         const PointSourceOptions& options) {
  const bool is_stream = path == "-";
  const std::optional<NamedFormat> named = read_format(path);
  const FileFormat format = named ? named->facts.format : FileFormat::kTxt;
  if (format == FileFormat::kLas || format == FileFormat::kLaz)
    return open_las_source(stoppable(open_random_access(path), options.stop));
  if (format == FileFormat::kE57)
    return open_e57_source(stoppable(open_random_access(path), options.stop));
  // Opened first: a file that is missing or a directory should be told as that.
  ByteReader reader(stoppable(open_byte_source(path), options.stop));
  if (!named && !is_stream) throw_unknown_extension(path);
  switch (format) {
    case FileFormat::kPly:
      return open_ply_source(std::move(reader));
    case FileFormat::kPcd:
      return open_pcd_source(std::move(reader));
    case FileFormat::kPtx:
      return open_ptx_file(path, std::move(reader), options.stop);
    case FileFormat::kObj:
      return std::make_unique<MeshVertices>(std::move(reader), MeshFormat::kObj);
    case FileFormat::kStl:
      return std::make_unique<MeshVertices>(std::move(reader), MeshFormat::kStl);
    case FileFormat::kGlb:
    case FileFormat::kGltf:
      return std::make_unique<MeshVertices>(std::move(reader), MeshFormat::kGlb);
    default:
      break;
  }
  // A text cloud, or what its content says.
  refuse_compressed(reader);
  refuse_binary_scan(reader);
  skip_byte_order_mark(reader);
  if (looks_like_ply(reader)) return open_ply_source(std::move(reader));
  if (looks_like_pcd(reader)) return open_pcd_source(std::move(reader));
  if (looks_like_ptx(reader)) return open_ptx_file(path, std::move(reader), options.stop);
  return open_text_source(std::move(reader), options.text, kind_of(format));
}

/// A cloud with what lies beside its file: its coordinate system, and the origin that its
/// coordinates are counted from.
class WithFilesBeside final : public PointSource {
 public:
  WithFilesBeside(std::unique_ptr<PointSource> source, std::string system, Vec3 origin)
      : source_(std::move(source)),
        schema_(source_->schema()),
        system_(std::move(system)),
        origin_(origin) {
    if (origin != Vec3{}) schema_.position_type = ScalarType::kFloat64;
  }
  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override {
    return source_->declared_points();
  }
  bool keeps_declared_points() const override { return source_->keeps_declared_points(); }
  bool read(PointCloud& batch, std::size_t capacity) override {
    const bool any = source_->read(batch, capacity);
    add_origin(origin_, batch);
    batch.schema = schema_;
    return any;
  }
  bool restrict_rows(std::uint64_t first, std::uint64_t count) override {
    return source_->restrict_rows(first, count);
  }
  bool has_row_access() const override { return source_->has_row_access(); }
  void skip_parts(const std::function<bool(const Box& bounds)>& is_outside) override {
    source_->skip_parts([is_outside, origin = origin_](const Box& part) {
      return is_outside(moved(part, origin));
    });
  }
  std::uint64_t bytes_read() const override { return source_->bytes_read(); }
  std::uint64_t bytes_total() const override { return source_->bytes_total(); }
  std::optional<ScannerPlace> scanner() const override { return moved(source_->scanner()); }
  ScanNumber scan() const override { return source_->scan(); }
  FileFacts facts() const override {
    FileFacts facts = source_->facts();
    if (facts.declared_bounds) facts.declared_bounds = moved(*facts.declared_bounds, origin_);
    for (ScanFacts& scan : facts.scans) {
      if (scan.pose) scan.pose->translation = scan.pose->translation + origin_;
      scan.scanner = moved(scan.scanner);
    }
    return facts;
  }
  DroppedPoints left_out() const override { return source_->left_out(); }
  std::string coordinate_system() const override { return system_; }
  std::optional<Vec3> meters_per_unit() const override {
    const std::optional<Vec3> unit = source_->meters_per_unit();
    return unit ? unit : PointSource::meters_per_unit();
  }

 private:
  static Box moved(const Box& box, Vec3 origin) { return {box.min + origin, box.max + origin}; }
  std::optional<ScannerPlace> moved(std::optional<ScannerPlace> place) const {
    if (place && !place->is_direction) place->vector = place->vector + origin_;
    return place;
  }

  std::unique_ptr<PointSource> source_;
  PointSchema schema_;
  std::string system_;
  Vec3 origin_;
};

}  // namespace

std::unique_ptr<PointSource> open_point_source(const std::filesystem::path& path,
                                               const PointSourceOptions& options) {
  std::unique_ptr<PointSource> source = open_format(path, options);
  std::string system = source->coordinate_system();
  if (system.empty()) system = coordinate_system_beside(path);
  const Vec3 origin = origin_beside(path);
  if (system == source->coordinate_system() && origin == Vec3{}) return source;
  return std::make_unique<WithFilesBeside>(std::move(source), std::move(system), origin);
}

std::string system_from_beside(const std::filesystem::path& path,
                               const PointSourceOptions& options) {
  std::string system = coordinate_system_beside(path);
  const bool counts = !system.empty() && open_format(path, options)->coordinate_system().empty();
  return counts ? std::move(system) : std::string();
}

}  // namespace orbweave
