#include "io/system/nameless_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace orbweave {

FileDescriptor nameless_file(const std::filesystem::path& directory) {
#ifdef O_TMPFILE
  FileDescriptor nameless(
      ::open(directory.c_str(), O_TMPFILE | O_EXCL | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (nameless.valid()) return nameless;
#endif
  std::string name = (directory / ".spool-XXXXXX").string();
  FileDescriptor named(::mkostemp(name.data(), O_CLOEXEC));
  if (named.valid()) ::unlink(name.c_str());
  return named;
}

}  // namespace orbweave
