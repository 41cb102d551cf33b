// Streams of bytes from a file, from memory or from a compressed stream; what readers stand on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace orbweave {

/// Bytes, once, front to back.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Fills `out` from its front and returns the number of bytes: less than asked only at the
  /// end. Throws Error (bad input) where the stream cannot be read.
  virtual std::size_t read(std::span<std::byte> out) = 0;
  /// Drops bytes; returns how many there were to drop. Where the stream is a file, without reading
  /// them.
  virtual std::uint64_t skip(std::uint64_t bytes);
  /// Bytes of the underlying file consumed so far (compressed ones of a compressed file).
  virtual std::uint64_t bytes_read() const = 0;
  /// Size of the underlying file; 0 where it has none (a pipe).
  virtual std::uint64_t bytes_total() const = 0;
  /// Length of the stream that `read` delivers; nothing where that is not known beforehand.
  virtual std::optional<std::uint64_t> length() const = 0;
  /// What the user calls it; for messages.
  virtual const std::string& name() const = 0;
};

/// Opens a file, or standard input for "-". A gzip-compressed file (by content or by the
/// extension .gz) is decompressed on the way. Throws Error (bad input) for a missing file, a
/// directory, an unreadable file and an empty one.
std::unique_ptr<ByteSource> open_byte_source(const std::filesystem::path& path);

/// Reads `bytes`, which must outlive the source; `name` is used in messages.
std::unique_ptr<ByteSource> memory_byte_source(std::span<const std::byte> bytes, std::string name);

}  // namespace orbweave
