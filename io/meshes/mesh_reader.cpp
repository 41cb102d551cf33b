#include "io/meshes/mesh_reader.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/meshes/mesh_parsers.h"
#include "io/meshes/ply_mesh.h"
#include "io/meshes/shift_file.h"
#include "io/ply/ply_vertices.h"
#include "io/streams/byte_source.h"
#include "io/streams/stoppable.h"
#include "io/system/file_descriptor.h"
#include "io/text/file_format.h"

namespace orbweave {
namespace {

/// Opens first: a file that is missing or a directory should be told as that.
ByteReader open_reader(const std::filesystem::path& path) {
  return ByteReader(open_byte_source(path));
}

[[noreturn]] void refuse_format(const std::filesystem::path& path) {
  throw_usage("cannot read " + files_of_name(path, "meshes") +
                  "; supported: " + extensions_of_read_meshes(),
              {.file = path.string()});
}

MeshFormat format_of(const std::filesystem::path& path) {
  if (path == "-") return MeshFormat::kPly;
  const std::optional<NamedFormat> named = format_of_name(path);
  if (named && named->facts.format == FileFormat::kPly) return MeshFormat::kPly;
  if (named && named->facts.format == FileFormat::kObj) return MeshFormat::kObj;
  if (named && named->facts.format == FileFormat::kStl) return MeshFormat::kStl;
  if (named && named->facts.format == FileFormat::kGlb) return MeshFormat::kGlb;
  if (named && named->facts.format == FileFormat::kGltf) return MeshFormat::kGlb;
  refuse_format(path);
}

}  // namespace

bool holds_faces(const std::filesystem::path& path) {
  require_rereadable(path.string());
  ByteReader reader = open_reader(path);
  if (looks_like_ply(reader)) return ply_holds_faces(std::move(reader));
  const std::optional<NamedFormat> named = format_of_name(path);
  return named && named->facts.holds_faces && named->facts.is_read &&
         named->facts.format != FileFormat::kPly;
}

void require_read_format(const std::filesystem::path& path) {
  open_reader(path);
  const std::optional<NamedFormat> named = format_of_name(path);
  if (!named || !named->facts.is_read) refuse_format(path);
}

TriangleMesh read_mesh(ByteReader reader, MeshFormat format, std::vector<std::string>* left_out) {
  switch (format) {
    case MeshFormat::kPly:
      return read_ply_mesh(std::move(reader), left_out);
    case MeshFormat::kObj:
      return read_obj_mesh(std::move(reader), left_out);
    case MeshFormat::kStl:
      return read_stl_mesh(std::move(reader));
    case MeshFormat::kGlb:
      return read_glb_mesh(std::move(reader));
  }
  return {};
}

TriangleMesh read_mesh(const std::filesystem::path& path, std::vector<std::string>* left_out,
                       const StopToken* stop) {
  ByteReader reader(stoppable(open_byte_source(path), stop));
  TriangleMesh mesh = read_mesh(std::move(reader), format_of(path), left_out);
  add_origin(origin_beside(path), mesh.vertices);
  return mesh;
}

}  // namespace orbweave
