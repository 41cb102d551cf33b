// Options and files of commands that measure how far a mesh lies from something else.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/validation/compare.h"
#include "io/job/job.h"
#include "io/system/path_roles.h"
#include "io/triangle_mesh.h"

namespace CLI {
class App;
}

namespace orbweave {

struct ErrorFiles {
  std::string mesh;     ///< PLY with the property `error`; empty: none
  std::string picture;  ///< PNG; empty: none
  bool empty() const { return mesh.empty() && picture.empty(); }
};

/// --errors and --errors-picture. `from`, `to`: whose vertices, and what they are compared with.
void add_error_options(CLI::App& command, ErrorFiles& files, const std::string& from,
                       const std::string& to);

/// --within, with these words about it, and --samples.
void add_measure_options(CLI::App& command, CompareOptions& options, const std::string& within);

/// Throws Error (usage) where the mesh's name is not one of a PLY, or the picture's not one of a
/// PNG.
void check_error_files(const ErrorFiles& files);
std::vector<PathRole> roles_of(const ErrorFiles& files);

/// Writes the mesh with its errors, one per vertex, in place of other attributes, and the picture.
/// Returns a line about the colours of the picture, with its newline; empty where there is none.
std::string write_errors(const ErrorFiles& files, TriangleMesh mesh, std::span<const double> errors,
                         UpAxis up);

}  // namespace orbweave
