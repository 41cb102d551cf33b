#include "io/system/file_sample.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <vector>

#include "io/hex_digits.h"
#include "io/system/file_descriptor.h"
#include "io/system/running_checksum.h"

namespace orbweave {
namespace {

/// Where the blocks begin, ascending.
std::vector<std::uint64_t> offsets(std::uint64_t file_bytes, std::size_t most_blocks) {
  std::vector<std::uint64_t> begins;
  if (file_bytes <= kWholeSampleBytes) {
    for (std::uint64_t at = 0; at < file_bytes; at += kSampleBlockBytes) begins.push_back(at);
    return begins;
  }
  const std::uint64_t last = file_bytes - kSampleBlockBytes;
  const std::uint64_t steps = std::max<std::size_t>(most_blocks, 2) - 1;
  for (std::uint64_t i = 0; i <= steps; ++i)  // the product last * i might overflow
    begins.push_back(last / steps * i + last % steps * i / steps);
  return begins;
}

}  // namespace

std::optional<FileSample> sample_file(const std::filesystem::path& path, std::size_t most_blocks) {
  // A pipe is not waited for.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat facts {};
  if (!file.valid() || fstat(file.get(), &facts) != 0 || !S_ISREG(facts.st_mode))
    return std::nullopt;
  RunningChecksum checksum;
  FileSample sample;
  std::vector<std::byte> block;
  for (const std::uint64_t begin :
       offsets(static_cast<std::uint64_t>(facts.st_size), most_blocks)) {
    block.resize(kSampleBlockBytes);
    const auto got = read_at(file.get(), begin, block);
    // A sample that could not be taken would be taken for a change of the file.
    if (!got)
      throw_unread("cannot read the file",
                   {.file = path.string(), .place = "byte " + std::to_string(begin)}, errno);
    block.resize(*got);
    checksum.add(block.data(), block.size());
    sample.bytes_hashed += block.size();
  }
  sample.fingerprint = hex_digits(checksum.value());
  return sample;
}

std::size_t sample_blocks_of(std::size_t files) {
  constexpr std::size_t kBlocksInAll = 4096;
  constexpr std::size_t kLeast = 3;
  return std::clamp(kBlocksInAll / std::max<std::size_t>(files, 1), kLeast, kSampleBlocks);
}

}  // namespace orbweave
