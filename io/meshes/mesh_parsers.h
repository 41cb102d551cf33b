// The readers behind read_mesh, one per format; PLY's is in io/meshes/ply_mesh.h.
#pragma once

#include <string>
#include <vector>

#include "io/streams/byte_reader.h"
#include "io/triangle_mesh.h"

namespace orbweave {

enum class MeshFormat { kPly, kObj, kStl, kGlb };

/// As read_mesh, from any stream.
TriangleMesh read_mesh(ByteReader reader, MeshFormat format,
                       std::vector<std::string>* left_out = nullptr);

TriangleMesh read_obj_mesh(ByteReader reader, std::vector<std::string>* left_out = nullptr);
TriangleMesh read_stl_mesh(ByteReader reader);
TriangleMesh read_glb_mesh(ByteReader reader);

}  // namespace orbweave
