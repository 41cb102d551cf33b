// What all readers check when they open a file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace orbweave {

/// What errno means, whatever the locale.
std::string system_reason(int error);
/// Opens for reading. Throws Error (bad input).
int open_or_throw(const std::string& name);
/// The size of a regular file, nothing for a pipe or a device. Throws Error (bad input) for what
/// cannot be a scan: a directory, an empty file.
std::optional<std::uint64_t> checked_size(int descriptor, const std::string& name);
bool starts_like_gzip(int descriptor);

}  // namespace orbweave
