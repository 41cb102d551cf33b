// The coordinate system beside a file: the same name with .prj, without a .gz.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace orbweave {

/// Where the coordinate system of a file goes; empty: a stream or a device has no place beside it.
std::filesystem::path coordinate_system_file(const std::filesystem::path& file);

/// The system that lies beside a file whose format has no place for one, or beside the directory of
/// the tile that it is, as system_of_text() has it. Empty where none does, or something else.
std::string coordinate_system_beside(const std::filesystem::path& file);

/// What lies there in words that PROJ makes nothing of, on one line. Empty where nothing does, or a
/// document of another program.
std::string unknown_system_beside(const std::filesystem::path& file);

/// What of a system goes into such a file.
struct WrittenSystem {
  std::string text;     ///< WKT; a code where PROJ has no database; empty: nothing is written
  std::string problem;  ///< why it is no WKT; empty: it is
};
WrittenSystem written_system(const std::string& system);

/// Writes it where there is a system and a place for it. Returns the file; empty: none is written.
std::filesystem::path write_coordinate_system(const std::filesystem::path& file,
                                              const std::string& system);

/// What is to be warned of where a file of points with this system was written and `written` is
/// what write_coordinate_system() returned: a system that is no WKT, and a file beside it that was
/// there before and says something else. `in`: what the points came from.
std::vector<std::string> doubts_of_written_system(const std::filesystem::path& file,
                                                  const std::string& in, const std::string& system,
                                                  const std::filesystem::path& written);

}  // namespace orbweave
