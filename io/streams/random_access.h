// Bytes of a file at any place; what readers stand on whose formats point back and forth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace orbweave {

/// A file, or memory, that is read in any order. Safe for reads from many threads.
class RandomAccess {
 public:
  virtual ~RandomAccess() = default;
  virtual std::uint64_t size() const = 0;  ///< bytes
  /// What the user calls it; for messages.
  virtual const std::string& name() const = 0;
  /// Fills `out` from byte `offset` on. Throws Error (bad input) with the place where the file ends
  /// before that or cannot be read.
  void read(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  virtual void read_inside(std::uint64_t offset, std::span<std::byte> out) const = 0;
};

/// Opens a regular file. Throws Error (bad input) for a missing file, a directory, a pipe, an
/// unreadable file, an empty one and one that is compressed by gzip.
std::unique_ptr<RandomAccess> open_random_access(const std::filesystem::path& path);

/// Reads `bytes`, which must outlive the object; `name` is used in messages.
std::unique_ptr<RandomAccess> memory_random_access(std::span<const std::byte> bytes,
                                                   std::string name);

}  // namespace orbweave
