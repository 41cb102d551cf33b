// A file that goes with its descriptor.
#pragma once

#include <filesystem>

#include "io/system/file_descriptor.h"

namespace orbweave {

/// A new file of the directory, to be written and read, that never has a name: a kill leaves none.
/// Where the file system has no such files, as those over a network, the file has a name
/// (".spool-" and six letters) for a moment. Invalid, with errno, where no file can be made.
FileDescriptor nameless_file(const std::filesystem::path& directory);

}  // namespace orbweave
