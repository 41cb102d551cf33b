// A sample of a file's content: what tells two files of equal size and time apart, at a cost that
// does not grow with the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace orbweave {

inline constexpr std::size_t kSampleBlockBytes = 4096;
inline constexpr std::size_t kSampleBlocks = 64;
/// Files up to that size are hashed whole.
inline constexpr std::uint64_t kWholeSampleBytes = kSampleBlocks * kSampleBlockBytes;

struct FileSample {
  std::uint64_t bytes_hashed = 0;
  std::string fingerprint;  ///< 16 hexadecimal digits: XXH3-64 of the blocks, one after the other
};

/// Blocks of a regular file, `most_blocks` (at least 2) of kSampleBlockBytes: the first, the last,
/// and others spread evenly between. Empty: it is no regular file, or cannot be opened.
/// Throws Error as throw_unread() where it cannot be read.
std::optional<FileSample> sample_file(const std::filesystem::path& path,
                                      std::size_t most_blocks = kSampleBlocks);

/// Blocks per file where so many files are sampled together: few thousand blocks are read in all,
/// or three of each.
std::size_t sample_blocks_of(std::size_t files);

}  // namespace orbweave
