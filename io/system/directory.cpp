#include "io/system/directory.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>

#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"

namespace orbweave {

std::vector<std::filesystem::path> entries_of(const std::filesystem::path& directory,
                                              std::error_code& error) {
  std::vector<std::filesystem::path> entries;
  std::filesystem::directory_iterator entry(directory, error);
  for (const std::filesystem::directory_iterator end; !error && entry != end;
       entry.increment(error))
    entries.push_back(entry->path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

int flush_directory(const std::filesystem::path& directory) {
  const FileDescriptor opened(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened.valid()) return errno;
  if (file_calls.fsync(opened.get()) == 0) return 0;
  return errno == EINVAL || errno == ENOTSUP ? 0 : errno;
}

}  // namespace orbweave
