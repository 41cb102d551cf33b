#include "io/meshes/file_with_places.h"

#include <optional>
#include <string>
#include <system_error>

#include "io/error.h"
#include "io/text/file_format.h"

namespace orbweave {

std::filesystem::path file_with_places(const std::filesystem::path& path, const char* format) {
  std::error_code absent;
  const auto status = std::filesystem::status(path, absent);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw_usage(std::string(format) + " cannot be written to a pipe or a device",
                {.file = path.string(),
                 .expected = "a regular file",
                 .advice = "Its bytes are not written from front to back. Name a file, or write "
                           "PLY to the pipe"});
  return path;
}

void check_file_with_places(const std::filesystem::path& mesh) {
  const std::optional<NamedFormat> named = format_of_name(mesh);
  // A directory of that name is refused as one.
  std::error_code absent;
  if (!named || !has_no_text(named->facts.format) || std::filesystem::is_directory(mesh, absent))
    return;
  file_with_places(mesh, spoken_name(named->facts).c_str());
}

}  // namespace orbweave
