// The coordinate system beside a file: the same name with .prj.
#pragma once

#include <filesystem>
#include <string>

namespace orbweave {

/// Where the coordinate system of a file goes; empty: a stream or a device has no place beside it.
std::filesystem::path coordinate_system_file(const std::filesystem::path& file);

/// What lies beside a file whose format has no place for a coordinate system: WKT or a code. Empty
/// where nothing does, or something else.
std::string coordinate_system_beside(const std::filesystem::path& file);

/// What of a system goes into such a file.
struct WrittenSystem {
  std::string text;     ///< WKT; a code where PROJ has no database; empty: nothing is written
  std::string problem;  ///< why it is no WKT; empty: it is
};
WrittenSystem written_system(const std::string& system);

/// Writes it where there is a system and a place for it. Returns the file; empty: none is written.
std::filesystem::path write_coordinate_system(const std::filesystem::path& file,
                                              const std::string& system);

}  // namespace orbweave
