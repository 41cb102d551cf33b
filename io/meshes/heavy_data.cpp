#include "io/meshes/heavy_data.h"

#include <algorithm>
#include <array>
#include <string>
#include <system_error>

#include "io/error.h"
#include "io/shown_text.h"
#include "io/system/hdf5_calls.h"

namespace orbweave {
namespace {

/// The document names the file of its numbers, and XML is UTF-8 without control characters.
void check_name(const std::string& name) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
  if (is_utf8(name) && std::ranges::none_of(name, is_control)) return;
  throw_usage("an XDMF document cannot name the file of its numbers",
              {.file = name,
               .expected = "a name of UTF-8 without control characters",
               .advice = "Give the .xdmf another name"});
}

}  // namespace

void check_heavy_data(const std::filesystem::path& mesh) {
  const std::filesystem::path numbers = heavy_data_file(mesh);
  if (!numbers.empty()) check_name(numbers.filename().string());
  std::error_code ignored;
  if (numbers.empty() || !std::filesystem::exists(numbers, ignored)) return;
  const std::array<std::string, 2> arrays = {"Points", "connectivity"};
  if (std::filesystem::is_regular_file(numbers, ignored) && has_hdf5_arrays(numbers, arrays))
    return;
  throw_usage("the numbers of " + mesh.string() + " go to a file that is there and has no mesh",
              {.file = numbers.string(),
               .expected = "no such file, or an HDF5 file with the arrays Points and connectivity",
               .advice = "Move it, or give the .xdmf another name"});
}

}  // namespace orbweave
