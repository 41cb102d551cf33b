// The readers behind read_mesh, one per format; PLY's is in io/ply_source.h.
#pragma once

#include <filesystem>
#include <string>

#include "io/byte_reader.h"
#include "io/triangle_mesh.h"

namespace orbweave {

enum class MeshFormat { kPly, kObj, kStl };

/// As read_mesh, from any stream.
TriangleMesh read_mesh(ByteReader reader, MeshFormat format);

TriangleMesh read_obj_mesh(ByteReader reader);
TriangleMesh read_stl_mesh(ByteReader reader);

/// The extension in lower case, without a further ".gz": ".ply" of "A.PLY.gz".
std::string format_extension(const std::filesystem::path& path);

}  // namespace orbweave
