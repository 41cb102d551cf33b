// Errors (resource) where the system refuses something about the work directory.
#pragma once

#include <filesystem>
#include <string>

namespace orbweave {

/// `problem` says what could not be done with `path`. `reason` is a value of errno; found and
/// advice follow from it.
[[noreturn]] void throw_refusal(const char* problem, const std::filesystem::path& path, int reason);

/// "cannot write to the work directory". Reason 0: a failure of HDF5, which does not say why.
[[noreturn]] void throw_write_error(const std::filesystem::path& path, int reason);
/// "cannot read from the work directory".
[[noreturn]] void throw_read_error(const std::filesystem::path& path, int reason);
/// "cannot use the work directory": the directory itself, or what tells whose it is.
[[noreturn]] void throw_directory_error(const std::filesystem::path& path, int reason);
/// The same for a reason that errno does not know.
[[noreturn]] void throw_directory_error(const std::filesystem::path& path,
                                        const std::string& reason);

}  // namespace orbweave
