// What is written beside its target until it is whole: ".<target>.<16 digits>.part", locked by
// whoever writes it, so that what a killed process left can be told from what is being written.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace orbweave {

/// Where a target lies; "." where it is a name alone.
std::filesystem::path directory_of(const std::filesystem::path& target);

/// A new name beside the target.
std::filesystem::path temporary_beside(const std::filesystem::path& target);

/// Whether a file of that name is the temporary of the target `stem`, or of "<stem>.<anything>".
bool is_temporary_of(std::string_view name, const std::string& stem);

/// Locks what was just made under such a name, as long as the descriptor is open. False where
/// somebody took it for abandoned before that and removed it.
bool keep_temporary(int descriptor);

}  // namespace orbweave
