#include "io/system/spool_file.h"

#include <cerrno>
#include <optional>
#include <stdexcept>
#include <utility>

#include "io/error.h"
#include "io/system/nameless_file.h"
#include "io/system/system_advice.h"

namespace orbweave {

SpoolFile::SpoolFile(std::filesystem::path directory)
    : directory_(std::move(directory)), file_(nameless_file(directory_)) {
  if (!file_.valid()) fail("cannot make a temporary file", errno);
}

std::uint64_t SpoolFile::append(std::span<const std::byte> bytes) {
  const std::uint64_t offset = bytes_.fetch_add(bytes.size());
  if (!write_at(file_.get(), offset, bytes)) fail("cannot write a temporary file", errno);
  return offset;
}

void SpoolFile::read(std::uint64_t offset, std::span<std::byte> out) const {
  const std::optional<std::size_t> count = read_at(file_.get(), offset, out);
  if (!count) fail("cannot read a temporary file", errno);
  if (*count != out.size()) throw std::logic_error("a temporary file is read beyond its end");
}

void SpoolFile::fail(const char* problem, int error) const {
  throw_resource(problem, {.file = directory_.string(),
                           .found = system_reason(error),
                           .advice = advice_on(error, "choose another place")});
}

}  // namespace orbweave
