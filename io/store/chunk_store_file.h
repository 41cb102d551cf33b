// One result of the chunk store as an HDF5 file. HDF5 lays the file out; the bytes of the arrays
// go past it (their places in the file are fixed), so they are copied once and in parallel.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/store/chunk_store.h"
#include "io/store/result_identity.h"
#include "io/system/file_descriptor.h"

namespace orbweave {

inline constexpr std::uint64_t kRowsPerChecksum = 1024;

/// Where a packed block of rows is.
struct StoredBlock {
  std::uint64_t offset = 0;  ///< first byte in the file
  std::uint64_t bytes = 0;
};

/// An array's shape, its place in the file and its checksums.
struct StoredArray {
  std::string name;
  ScalarType type = ScalarType::kUint8;
  std::uint32_t columns = 1;
  std::uint64_t rows = 0;
  std::uint64_t offset = 0;              ///< first byte in the file; of no meaning with blocks
  std::uint64_t checksum_offset = 0;     ///< first byte of the stored checksums in the file
  std::vector<std::uint64_t> checksums;  ///< one per kRowsPerChecksum rows
  std::vector<StoredBlock> blocks;       ///< likewise, of a compressed array; empty otherwise
  std::uint64_t seed = 0;                ///< of the checksums: of the result and the array's name

  std::size_t row_bytes() const { return columns * size_of(type); }
  std::size_t block_bytes() const { return kRowsPerChecksum * row_bytes(); }
};

/// Of the checksums of an array's blocks.
std::uint64_t seed_of_checksums(const ResultIdentity& identity, const std::string& array);
/// Of a block of rows, given by its number.
std::uint64_t block_checksum(const StoredArray& array, std::uint64_t block, const void* data,
                             std::size_t bytes);

/// The name of a chunk's result in its stage's folder, "000037.h5".
std::string result_name(ChunkId chunk);
/// Of a file with such a name.
std::optional<ChunkId> chunk_of_result(const std::filesystem::path& file);

/// What is in a result file.
struct ResultIndex {
  std::vector<StoredArray> arrays;
  std::uint64_t file_bytes = 0;  ///< of arrays and checksums
};

/// A result file that was just written.
struct WrittenResult {
  FileDescriptor file;
  std::shared_ptr<const ResultIndex> index;
};
/// Fills a result file that was made for it, its larger arrays packed where that is wanted. What is
/// left on failure (Error, resource) is for the caller to remove.
WrittenResult write_result_file(const std::filesystem::path& path,
                                std::span<const ArrayView> arrays, bool packed,
                                const ResultIdentity& identity);

/// Where the result in a file belongs. Empty: it is no result, or its structures are damaged.
std::optional<ResultIdentity> identity_of_result(const std::filesystem::path& path);

/// Throws Error (usage) where a directory has the name of a file that the program reads or
/// writes: only the user can have put a directory there.
void refuse_directory(const std::filesystem::path& path);
/// Throws CorruptResult where the file is too short or unreadable, Error (resource) otherwise.
void read_rows(const std::filesystem::path& path, int file, void* data, std::size_t bytes,
               std::uint64_t offset);

/// Reads what a result file holds. Throws CorruptResult, also where it holds the result of another
/// identity, and Error (resource) where a directory has its name.
std::shared_ptr<const ResultIndex> read_result_index(const std::filesystem::path& path, int file,
                                                     const ResultIdentity& identity);

/// An open result file. Adds what it reads to `bytes_read`.
std::unique_ptr<StoredResult> make_file_result(std::filesystem::path path, FileDescriptor file,
                                               std::shared_ptr<const ResultIndex> index,
                                               std::atomic<std::uint64_t>& bytes_read);

}  // namespace orbweave
