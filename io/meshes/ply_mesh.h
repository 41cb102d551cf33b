// PLY files as meshes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/scalar_types.h"
#include "io/streams/byte_reader.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Vertices and faces of a PLY file; as read_mesh.
TriangleMesh read_ply_mesh(ByteReader reader, std::vector<std::string>* left_out = nullptr);

/// The id of the hole that a face fills. Throws Error (bad input) where 32 bits do not hold it.
/// `file`, `face`: for the message.
std::int32_t ply_hole(ScalarType type, const std::byte* value, bool is_swapped,
                      const std::string& file, std::uint64_t face);

/// True when the header has faces or triangle strips, with rows and corners.
bool ply_holds_faces(ByteReader reader);

}  // namespace orbweave
