#include "io/meshes/mesh_writer.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "io/cloud_columns.h"
#include "io/error.h"
#include "io/meshes/glb_layout.h"
#include "io/meshes/heavy_data.h"
#include "io/meshes/mesh_formats.h"
#include "io/meshes/obj_colors.h"
#include "io/scalar_types.h"
#include "io/text/file_format.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchRows = std::size_t{1} << 16;

[[noreturn]] void refuse_extension(const std::filesystem::path& path, bool is_cloud) {
  throw_usage("cannot write " + files_of_name(path, is_cloud ? "clouds" : "meshes") +
                  "; supported: " +
                  (is_cloud ? extensions_of_written_clouds() : extensions_of_written_meshes()),
              {.file = path.string()});
}

/// The format to write; throws Error (usage) where the name stands for none.
FileFormat written_format(const std::filesystem::path& path, bool is_cloud) {
  if (path == "-") return FileFormat::kPly;
  const std::optional<NamedFormat> named = format_of_name(path);
  const bool is_written = named &&
                          (is_cloud ? named->facts.writes_cloud : named->facts.writes_mesh) &&
                          (!named->is_gzipped || named->facts.writes_gzip);
  if (!is_written) refuse_extension(path, is_cloud);
  return named->facts.format;
}

bool is_format(const std::filesystem::path& path, FileFormat format) {
  const std::optional<NamedFormat> named = format_of_name(path);
  return named && named->facts.format == format;
}

void check_glb_size(const std::filesystem::path& path, const MeshHeader& header,
                    const MeshWriterOptions& options) {
  const std::uint64_t bytes = GlbLayout(header, options).file_bytes();
  if (bytes <= kMostGlbBytes) return;
  throw_usage(
      "too many vertices and triangles for GLB",
      {.file = path.string(),
       .found = std::to_string(header.vertices) + " vertices, " + std::to_string(header.triangles) +
                " triangles, " + std::to_string(bytes) + " bytes",
       .expected = "at most " + std::to_string(kMostGlbBytes) + " bytes",
       .advice = "Name a .ply file and make tiles of it"});
}

template <class T>
void add_as(TextBuilder& text, const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  text.add_number(value);
}

/// Copies points [first, first + count).
PointCloud slice(const PointCloud& cloud, std::size_t first, std::size_t count) {
  PointCloud part;
  part.schema = cloud.schema;
  const auto range = [&](const auto& values, std::size_t width) {
    return std::pair(values.begin() + static_cast<std::ptrdiff_t>(first * width),
                     values.begin() + static_cast<std::ptrdiff_t>((first + count) * width));
  };
  const auto [p, p_end] = range(cloud.positions, 1);
  part.positions.assign(p, p_end);
  if (cloud.schema.has_normals) {
    const auto [n, n_end] = range(cloud.normals, 1);
    part.normals.assign(n, n_end);
  }
  const auto [a, a_end] = range(cloud.attributes, cloud.schema.attribute_bytes());
  part.attributes.assign(a, a_end);
  return part;
}

void write_all_vertices(MeshWriter& writer, const PointCloud& vertices) {
  for (std::size_t first = 0; first < vertices.size(); first += kBatchRows)
    writer.write_vertices(slice(vertices, first, std::min(kBatchRows, vertices.size() - first)));
}

/// Holds what a program filled in to what is read of it.
void check_rows(const std::filesystem::path& path, const PointCloud& cloud) {
  check_columns(cloud);
  if (cloud.schema.has_normals && cloud.normals.size() != cloud.size())
    throw_usage("the schema has normals, and the points have none", {.file = path.string()});
}

void check_triangles(const std::filesystem::path& path, const TriangleMesh& mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::uint32_t largest = *std::ranges::max_element(mesh.triangles[i]);
    if (largest >= mesh.vertices.size())
      throw_usage("a triangle names a vertex that is not there",
                  {.file = path.string(),
                   .place = "triangle " + std::to_string(i),
                   .found = std::to_string(largest),
                   .expected = "a number below " + std::to_string(mesh.vertices.size())});
  }
}

/// A text where the format has none, and a file of numbers beside it that is something else.
void check_file(const std::filesystem::path& path, const MeshWriterOptions& options) {
  const std::optional<NamedFormat> named = format_of_name(path);
  if (!options.binary && named && has_no_text(named->facts.format))
    throw_usage(spoken_name(named->facts) + " has no text encoding",
                {.file = path.string(), .expected = "binary rows, or a .ply, .obj or .stl file"});
  check_heavy_data(path);
}

}  // namespace

void RowCounter::vertices(std::uint64_t count) {
  if (count > vertices_left_) throw std::logic_error("more vertices than the mesh header says");
  vertices_left_ -= count;
}

void RowCounter::triangles(std::uint64_t count) {
  if (vertices_left_ != 0) throw std::logic_error("triangles before the last vertex");
  if (count > triangles_left_) throw std::logic_error("more triangles than the mesh header says");
  triangles_left_ -= count;
}

void RowCounter::finish() const {
  if (vertices_left_ != 0 || triangles_left_ != 0)
    throw std::logic_error("fewer vertices or triangles than the mesh header says");
}

void TextBuilder::add_value(ScalarType type, const std::byte* from) {
  visit_scalar(type, [&](auto kind) { add_as<decltype(kind)>(*this, from); });
}

std::unique_ptr<MeshWriter> open_mesh_writer(const std::filesystem::path& path,
                                             const MeshHeader& header,
                                             const MeshWriterOptions& options) {
  // The extension and the size are judged before a file is touched.
  const FileFormat format = written_format(path, header.is_cloud);
  check_mesh_size(path, header, options);
  switch (format) {
    case FileFormat::kXyz:
      return make_text_writer(open_byte_sink(path), header, options, ' ');
    case FileFormat::kCsv:
      return make_text_writer(open_byte_sink(path), header, options, ',');
    case FileFormat::kObj:
      return make_obj_writer(open_byte_sink(path), header, options);
    case FileFormat::kStl:
      return make_stl_writer(open_byte_sink(path), header, options, path);
    case FileFormat::kGlb:
      return make_glb_writer(path, header, options);
    case FileFormat::kVtp:
      return make_vtp_writer(path, header, options);
    case FileFormat::kXdmf:
      return make_xdmf_writer(path, header, options);
    default:
      return make_ply_writer(open_byte_sink(path), header, options);
  }
}

std::vector<std::string> columns_without_place(const std::filesystem::path& path,
                                               const PointSchema& schema) {
  if (is_format(path, FileFormat::kGlb)) return columns_without_place_in_glb(schema);
  const bool is_obj = is_format(path, FileFormat::kObj);
  if (!is_obj && !is_format(path, FileFormat::kStl)) return {};
  std::vector<std::string> names;
  if (!is_obj && schema.has_normals) names.emplace_back("normals");
  const bool keeps_colors = is_obj && ObjColors(schema).all_are_there();
  for (const AttributeField& field : schema.attributes)
    if (!keeps_colors || !is_color_channel(field)) names.push_back(field.name);
  return names;
}

std::vector<std::string> patches_without_place(const std::filesystem::path& path,
                                               bool has_confidence) {
  if (path == "-" || is_format(path, FileFormat::kPly)) return {};
  std::vector<std::string> names;
  const bool keeps_ids = is_format(path, FileFormat::kVtp) || is_format(path, FileFormat::kXdmf);
  if (!keeps_ids) names.emplace_back("hole (of faces)");
  if (has_confidence) names.emplace_back("confidence (of faces)");
  return names;
}

bool has_float_coordinates(const std::filesystem::path& path, const MeshWriterOptions& options) {
  if (is_format(path, FileFormat::kStl)) return options.binary;
  if (is_format(path, FileFormat::kGlb)) return true;
  const bool has_a_choice = path == "-" || is_format(path, FileFormat::kPly) ||
                            is_format(path, FileFormat::kVtp) || is_format(path, FileFormat::kXdmf);
  return options.float_positions && has_a_choice;
}

void check_mesh_size(const std::filesystem::path& path, const MeshHeader& header,
                     const MeshWriterOptions& options) {
  if (is_format(path, FileFormat::kGlb)) return check_glb_size(path, header, options);
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (!is_format(path, FileFormat::kStl) || !options.binary || header.triangles <= kMost) return;
  throw_usage("too many triangles for binary STL",
              {.file = path.string(),
               .found = std::to_string(header.triangles),
               .expected = "at most " + std::to_string(kMost),
               .advice = "Name a .ply file, or write text with output.format = \"text\""});
}

void MeshWriter::write_polygons(const PolygonFaces&) {
  throw std::logic_error("the format has no polygons");
}

bool holds_polygons(const std::filesystem::path& path) {
  return path == "-" || is_format(path, FileFormat::kPly) || is_format(path, FileFormat::kObj);
}

void write_polygons(const std::filesystem::path& path, const PointCloud& vertices,
                    const PolygonFaces& faces, const MeshWriterOptions& options) {
  if (!holds_polygons(path))
    throw_usage("polygons are written as PLY or OBJ", {.file = path.string()});
  MeshHeader header;
  header.vertices = vertices.size();
  header.triangles = faces.size();
  header.schema = vertices.schema;
  for (std::size_t f = 0; f < faces.size(); ++f)
    header.most_corners =
        std::max(header.most_corners, static_cast<std::uint32_t>(faces.of(f).size()));
  const auto writer = open_mesh_writer(path, header, options);
  write_all_vertices(*writer, vertices);
  writer->write_polygons(faces);
  writer->finish();
}

std::unique_ptr<MeshRows> mesh_rows(const std::filesystem::path& path, const MeshHeader& header,
                                    const MeshWriterOptions& options) {
  if (is_format(path, FileFormat::kGlb)) return std::make_unique<GlbLayout>(header, options);
  const bool is_plain_ply =
      path != "-" && path.extension() != ".gz" && is_format(path, FileFormat::kPly);
  return is_plain_ply && options.binary ? make_ply_rows(header, options) : nullptr;
}

void write_mesh(const std::filesystem::path& path, const TriangleMesh& mesh,
                const MeshWriterOptions& options) {
  check_file(path, options);
  check_rows(path, mesh.vertices);
  check_triangles(path, mesh);
  if (!mesh.hole.empty() && mesh.hole.size() != mesh.triangles.size())
    throw_usage("there are not as many numbers of holes as triangles",
                {.file = path.string(),
                 .found = std::to_string(mesh.hole.size()) + " numbers for " +
                          std::to_string(mesh.triangles.size()) + " triangles"});
  MeshHeader header;
  header.vertices = mesh.vertices.size();
  header.triangles = mesh.triangles.size();
  header.has_hole = !mesh.hole.empty();
  header.schema = mesh.vertices.schema;
  const auto writer = open_mesh_writer(path, header, options);
  write_all_vertices(*writer, mesh.vertices);
  std::vector<Triangle64> batch;
  for (std::size_t first = 0; first < mesh.triangles.size(); first += kBatchRows) {
    const std::size_t count = std::min(kBatchRows, mesh.triangles.size() - first);
    batch.clear();
    for (std::size_t i = first; i < first + count; ++i) {
      const Triangle& t = mesh.triangles[i];
      batch.push_back({t[0], t[1], t[2]});
    }
    const std::span<const std::int32_t> hole(mesh.hole);
    writer->write_triangles(batch, hole.empty() ? hole : hole.subspan(first, count));
  }
  writer->finish();
}

void write_cloud(const std::filesystem::path& path, const PointCloud& cloud,
                 const MeshWriterOptions& options) {
  check_rows(path, cloud);
  MeshHeader header;
  header.vertices = cloud.size();
  header.is_cloud = true;
  header.schema = cloud.schema;
  const auto writer = open_mesh_writer(path, header, options);
  write_all_vertices(*writer, cloud);
  writer->finish();
}

}  // namespace orbweave
