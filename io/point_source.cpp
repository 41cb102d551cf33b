#include "io/point_source.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

#include "io/byte_source.h"
#include "io/e57/e57_source.h"
#include "io/error.h"
#include "io/las/las_source.h"
#include "io/lower_case.h"
#include "io/mesh_parsers.h"
#include "io/pcd_source.h"
#include "io/ply_source.h"
#include "io/ptx_source.h"
#include "io/random_access.h"
#include "io/text_source.h"

namespace orbweave {
namespace {

/// The vertices of a mesh whose format does not list them plainly (OBJ, STL): read in core.
class MeshVertices final : public PointSource {
 public:
  MeshVertices(ByteReader reader, MeshFormat format)
      : bytes_total_(reader.source().bytes_total()),
        vertices_(read_mesh(std::move(reader), format).vertices) {}
  const PointSchema& schema() const override { return vertices_.schema; }
  std::optional<std::uint64_t> declared_points() const override { return vertices_.size(); }
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
  std::uint64_t bytes_total_;
  PointCloud vertices_;
  std::size_t next_ = 0;
};

bool is_text_extension(const std::string& extension) {
  return extension == ".xyz" || extension == ".txt" || extension == ".csv" || extension == ".pts";
}

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

std::unique_ptr<PointSource> open_ptx_file(const std::filesystem::path& path, ByteReader reader) {
  // A pipe can be read only once.
  if (!std::filesystem::is_regular_file(path)) return open_ptx_source(std::move(reader));
  return open_ptx_source(std::move(reader), [&] { return ByteReader(open_byte_source(path)); });
}

}  // namespace

std::string format_extension(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".gz" ? lower_case(path.stem().extension().string()) : extension;
}

std::unique_ptr<PointSource> open_point_source(const std::filesystem::path& path,
                                               const PointSourceOptions& options) {
  const std::string extension = format_extension(path);
  if (extension == ".las" || extension == ".laz") return open_las_source(open_random_access(path));
  if (extension == ".e57") return open_e57_source(open_random_access(path));
  // Opened first: a file that is missing or a directory should be told as that.
  ByteReader reader(open_byte_source(path));
  const bool is_stream = path == "-";
  if (extension == ".ply") return open_ply_source(std::move(reader));
  if (extension == ".pcd") return open_pcd_source(std::move(reader));
  if (extension == ".ptx") return open_ptx_file(path, std::move(reader));
  if (is_stream || is_text_extension(extension)) {
    refuse_binary_scan(reader);
    if (looks_like_ply(reader)) return open_ply_source(std::move(reader));
    if (looks_like_pcd(reader)) return open_pcd_source(std::move(reader));
    if (looks_like_ptx(reader)) return open_ptx_file(path, std::move(reader));
    return open_text_source(std::move(reader), options.text, extension == ".pts");
  }
  if (extension == ".obj")
    return std::make_unique<MeshVertices>(std::move(reader), MeshFormat::kObj);
  if (extension == ".stl")
    return std::make_unique<MeshVertices>(std::move(reader), MeshFormat::kStl);
  throw_usage(
      "no reader for this extension",
      {.file = path.string(),
       .found = extension.empty() ? "none" : extension,
       .expected =
           ".ply, .xyz, .txt, .csv, .pts, .ptx, .pcd, .obj or .stl, each also with .gz; .las, "
           ".laz or .e57"});
}

PointCloud read_all(PointSource& source) {
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
  PointCloud cloud;
  cloud.schema = source.schema();
  // A count is believed only as far as the file could hold it: the narrowest point has 3 bytes.
  const std::uint64_t room = source.bytes_total() / 3;
  cloud.reserve(static_cast<std::size_t>(std::min(source.declared_points().value_or(0), room)));
  PointCloud batch;
  while (source.read(batch, kBatchPoints)) cloud.append(batch);
  return cloud;
}

}  // namespace orbweave
