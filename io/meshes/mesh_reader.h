// Meshes from files, in core.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

class StopToken;

/// True when the file's header says that it holds faces (PLY with a non-empty face element,
/// OBJ, STL, GLB). Reads the header, so that the file has to be one that can be read again: throws
/// Error for standard input and for a pipe.
bool holds_faces(const std::filesystem::path& path);

/// Throws Error (usage) for a name whose format is not read at all, such as .vtp: whether the file
/// is a mesh or a cloud is not known then. One that is missing or a directory is told as that.
void require_read_format(const std::filesystem::path& path);

/// Reads .ply (also .gz), .obj, .stl (binary or text; vertices with equal coordinates are
/// joined) and .glb and .gltf (docs/formats.md) as triangles; polygons are fanned from their first
/// corner. A PLY face property "hole", and _HOLE of GLB vertices, become TriangleMesh::hole. Where
/// the shift of its coordinates lies beside the file (io/meshes/shift_file.h), vertices are where
/// the world has them. `left_out` gets what PLY and OBJ files hold beside that, in words ("face
/// properties red, green, blue"). Throws Error (bad input) for damaged files and for indices
/// outside the vertices, and (interrupted) where `stop`, which may be null, asks for it between
/// pieces of the file.
TriangleMesh read_mesh(const std::filesystem::path& path,
                       std::vector<std::string>* left_out = nullptr,
                       const StopToken* stop = nullptr);

}  // namespace orbweave
