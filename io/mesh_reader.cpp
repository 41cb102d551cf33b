#include "io/mesh_reader.h"

#include <utility>

#include "io/byte_source.h"
#include "io/error.h"
#include "io/mesh_parsers.h"
#include "io/ply_source.h"

namespace orbweave {
namespace {

/// Opens first: a file that is missing or a directory should be told as that.
ByteReader open_reader(const std::filesystem::path& path) {
  return ByteReader(open_byte_source(path));
}

MeshFormat format_of(const std::filesystem::path& path) {
  const std::string extension = format_extension(path);
  if (extension == ".ply" || path == "-") return MeshFormat::kPly;
  if (extension == ".obj") return MeshFormat::kObj;
  if (extension == ".stl") return MeshFormat::kStl;
  throw_usage("no mesh reader for this extension",
              {.file = path.string(),
               .found = extension.empty() ? "none" : extension,
               .expected = ".ply, .obj or .stl, each also with .gz"});
}

}  // namespace

bool holds_faces(const std::filesystem::path& path) {
  ByteReader reader = open_reader(path);
  if (looks_like_ply(reader)) return ply_holds_faces(std::move(reader));
  const std::string extension = format_extension(path);
  return extension == ".obj" || extension == ".stl";
}

TriangleMesh read_mesh(ByteReader reader, MeshFormat format) {
  switch (format) {
    case MeshFormat::kPly:
      return read_ply_mesh(std::move(reader));
    case MeshFormat::kObj:
      return read_obj_mesh(std::move(reader));
    case MeshFormat::kStl:
      return read_stl_mesh(std::move(reader));
  }
  return {};
}

TriangleMesh read_mesh(const std::filesystem::path& path) {
  ByteReader reader = open_reader(path);
  return read_mesh(std::move(reader), format_of(path));
}

}  // namespace orbweave
