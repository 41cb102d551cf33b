// Any bytes as an E57 cloud: either points or an Error, nothing else. The checksums of the pages
// are made right first, or no change would ever get past them; one bit of the input leaves them.
#include <cstring>
#include <string>
#include <vector>

#include "io/clouds/e57/crc32c.h"
#include "io/clouds/e57/e57_source.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

constexpr std::size_t kHeaderBytes = 48;
constexpr std::size_t kPageSizeAt = 40;
constexpr std::size_t kLengthAt = 16;

std::uint64_t integer_at(const std::vector<std::byte>& file, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(file[at + i]) << (8 * i);
  return value;
}

/// Cuts the file to whole pages, says so in its header and gives each page its checksum.
void repair(std::vector<std::byte>& file) {
  if (file.size() < kHeaderBytes) return;
  const std::uint64_t page = integer_at(file, kPageSizeAt);
  if (page < kHeaderBytes || page > file.size()) return;
  file.resize(file.size() / page * page);
  for (std::size_t i = 0; i < 8; ++i)
    file[kLengthAt + i] = static_cast<std::byte>(file.size() >> (8 * i) & 0xFF);
  for (std::size_t at = 0; at < file.size(); at += page) {
    const std::uint32_t crc =
        orbweave::crc32c(std::span<const std::byte>(file).subspan(at, page - 4));
    for (std::size_t i = 0; i < 4; ++i)
      file[at + page - 1 - i] = static_cast<std::byte>(crc >> (8 * i) & 0xFF);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = orbweave::fuzz::bytes_of(data, size);
  std::vector<std::byte> file(input.begin(), input.end());
  // The minor version means nothing to the reader.
  const bool as_it_is = size > 12 && (data[12] & 0x80) != 0;
  if (!as_it_is) repair(file);
  try {
    const auto source = orbweave::open_e57_source(orbweave::memory_random_access(file, "input"));
    orbweave::fuzz::drain(*source, 1 + size % 7 * 300);
    if (source->bytes_read() > source->bytes_total())
      throw std::logic_error("more bytes read than there are");
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
