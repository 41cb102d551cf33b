// Small files that are read whole.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

namespace orbweave {

/// The bytes of the file, at most `most` of them. Nothing where it cannot be opened or read: errno
/// says why. Streams of the standard library do not tell a failure of the device from an end.
std::optional<std::string> small_file_text(
    const std::filesystem::path& path, std::size_t most = std::numeric_limits<std::size_t>::max());

}  // namespace orbweave
