// PLY files as meshes.
#pragma once

#include "io/streams/byte_reader.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Vertices and faces of a PLY file; as read_mesh.
TriangleMesh read_ply_mesh(ByteReader reader);

/// True when the header has a face element with rows and corners.
bool ply_holds_faces(ByteReader reader);

}  // namespace orbweave
