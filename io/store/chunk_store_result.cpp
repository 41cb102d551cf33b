// Reading rows of a stored result: positioned reads, unpacking, checksums. No HDF5 is needed here.
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "io/store/chunk_store_file.h"
#include "io/store/packed_blocks.h"
#include "io/system/file_descriptor.h"
#include "io/system/work_directory_errors.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

class FileResult : public StoredResult {
 public:
  FileResult(std::filesystem::path path, FileDescriptor file,
             std::shared_ptr<const ResultIndex> index, std::atomic<std::uint64_t>& bytes_read)
      : path_(std::move(path)),
        file_(std::move(file)),
        index_(std::move(index)),
        bytes_read_(bytes_read) {}

  std::uint64_t rows(const std::string& array) const override { return find(array).rows; }
  bool has(const std::string& array) const override { return search(array) != nullptr; }
  std::size_t row_bytes(const std::string& array) const override { return find(array).row_bytes(); }

  void read(const std::string& name, std::uint64_t first, std::uint64_t count,
            void* out) const override {
    const StoredArray& array = find(name);
    if (first > array.rows || count > array.rows - first)
      throw std::out_of_range("chunk store: rows outside of array '" + name + "'");
    char* to = static_cast<char*>(out);
    const std::uint64_t last = first + count;
    while (first < last) {
      const std::uint64_t block = first / kRowsPerChecksum;
      const std::uint64_t begin = block * kRowsPerChecksum;
      std::uint64_t end = std::min(begin + kRowsPerChecksum, array.rows);
      if (first > begin || last < end) {
        end = std::min(end, last);
        read_part(array, block, first, end, to);
      } else {
        // Whole blocks go straight to their place; the last block of an array is whole as well.
        end = last == array.rows ? last : last / kRowsPerChecksum * kRowsPerChecksum;
        read_blocks(array, begin, end, to);
      }
      to += (end - first) * array.row_bytes();
      first = end;
    }
  }

 private:
  const StoredArray* search(const std::string& name) const {
    for (const StoredArray& array : index_->arrays)
      if (array.name == name) return &array;
    return nullptr;
  }
  const StoredArray& find(const std::string& name) const {
    if (const StoredArray* array = search(name)) return *array;
    throw CorruptResult(path_, "no array '" + name + "'");
  }

  /// Rows [first, last) of one block.
  void read_part(const StoredArray& array, std::uint64_t block, std::uint64_t first,
                 std::uint64_t last, char* out) const {
    const std::uint64_t begin = block * kRowsPerChecksum;
    const std::uint64_t end = std::min(begin + kRowsPerChecksum, array.rows);
    std::vector<char> rows((end - begin) * array.row_bytes());
    read_blocks(array, begin, end, rows.data());
    std::memcpy(out, rows.data() + (first - begin) * array.row_bytes(),
                (last - first) * array.row_bytes());
  }

  /// Whole blocks, rows [first, last), read and checked in pieces that stay in the cache.
  void read_blocks(const StoredArray& array, std::uint64_t first, std::uint64_t last,
                   char* out) const {
    constexpr std::uint64_t kPieceRows = 32 * kRowsPerChecksum;
    // Fewer are read while a second thread wakes up.
    constexpr std::uint64_t kPiecesOfSeveral = 4;
    const std::size_t row_bytes = array.row_bytes();
    if (!array.blocks.empty()) return read_packed(array, first, last, out);
    const auto read_piece = [&](std::uint64_t piece) {
      const std::uint64_t begin = first + piece * kPieceRows;
      const std::uint64_t end = std::min(begin + kPieceRows, last);
      read_piece_of(array, begin, end, out + (begin - first) * row_bytes);
    };
    const std::uint64_t pieces = (last - first + kPieceRows - 1) / kPieceRows;
    if (pieces < kPiecesOfSeveral) {
      for (std::uint64_t piece = 0; piece < pieces; ++piece) read_piece(piece);
      return;
    }
    for_each_whole(pieces, read_piece);
  }

  /// Whole blocks of an array that is not packed.
  void read_piece_of(const StoredArray& array, std::uint64_t first, std::uint64_t last,
                     char* out) const {
    const std::size_t row_bytes = array.row_bytes();
    read_rows(path_, file_.get(), out, (last - first) * row_bytes,
              array.offset + first * row_bytes);
    bytes_read_ += (last - first) * row_bytes;
    for (std::uint64_t row = first; row < last; row += kRowsPerChecksum) {
      const std::size_t bytes = (std::min(row + kRowsPerChecksum, last) - row) * row_bytes;
      verify(array, row / kRowsPerChecksum, out, bytes);
      out += bytes;
    }
  }

  /// Whole blocks of a packed array, rows [first, last).
  void read_packed(const StoredArray& array, std::uint64_t first, std::uint64_t last,
                   char* out) const {
    std::vector<std::byte> packed;
    for (std::uint64_t row = first; row < last; row += kRowsPerChecksum) {
      const std::uint64_t block = row / kRowsPerChecksum;
      const std::uint64_t rows = std::min(kRowsPerChecksum, array.rows - row);
      const std::span to(reinterpret_cast<std::byte*>(out), rows * array.row_bytes());
      packed.resize(array.blocks[block].bytes);
      read_rows(path_, file_.get(), packed.data(), packed.size(), array.blocks[block].offset);
      bytes_read_ += packed.size();
      if (!unpack_block(packed, size_of(array.type), array.block_bytes(), to))
        throw CorruptResult(path_, "block " + std::to_string(block) + " of array '" + array.name +
                                       "', which cannot be unpacked");
      verify(array, block, out, to.size());
      out += to.size();
    }
  }

  void verify(const StoredArray& array, std::uint64_t block, const char* data,
              std::size_t bytes) const {
    if (block_checksum(array, block, data, bytes) != array.checksums[block])
      throw CorruptResult(path_, "a wrong checksum in block " + std::to_string(block) +
                                     " of array '" + array.name + "'");
  }

  std::filesystem::path path_;
  FileDescriptor file_;
  std::shared_ptr<const ResultIndex> index_;
  std::atomic<std::uint64_t>& bytes_read_;
};

}  // namespace

// Blocks of equal content at other places, of other arrays or other results, have other checksums.
std::uint64_t seed_of_checksums(const ResultIdentity& identity, const std::string& array) {
  const std::string text = identity.text() + array;
  return XXH3_64bits(text.data(), text.size());
}

std::uint64_t block_checksum(const StoredArray& array, std::uint64_t block, const void* data,
                             std::size_t bytes) {
  return XXH3_64bits_withSeed(data, bytes, array.seed + block);
}

void read_rows(const std::filesystem::path& path, int file, void* data, std::size_t bytes,
               std::uint64_t offset) {
  const auto got = read_at(file, offset, {static_cast<std::byte*>(data), bytes});
  if (got == bytes) return;
  if (got) throw CorruptResult(path, "a truncated file");
  if (errno != EIO) throw_read_error(path, errno);
  throw CorruptResult(path, system_reason(errno));
}

std::unique_ptr<StoredResult> make_file_result(std::filesystem::path path, FileDescriptor file,
                                               std::shared_ptr<const ResultIndex> index,
                                               std::atomic<std::uint64_t>& bytes_read) {
  return std::make_unique<FileResult>(std::move(path), std::move(file), std::move(index),
                                      bytes_read);
}

}  // namespace orbweave
