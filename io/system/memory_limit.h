// How much memory the system lets this process have.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace orbweave {

/// The least of the machine's memory and of the limits of the control groups (versions 1 and 2)
/// that the process is in, as containers and batch systems set them. A process that takes more may
/// be killed. Empty where the system does not say. `root` is where proc and sys are mounted.
std::optional<std::uint64_t> memory_limit_bytes(const std::filesystem::path& root = "/");

}  // namespace orbweave
