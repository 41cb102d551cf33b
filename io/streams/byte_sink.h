// Where writers put their bytes: a file that appears whole, a compressed one, standard output.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "io/error.h"

namespace orbweave {

/// The reader of standard output has closed it and wants no more.
class ClosedOutput : public Error {
 public:
  ClosedOutput();
};

/// Bytes to a file, front to back. Nothing is there under the file's name before finish().
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Throws Error (resource) where it cannot be written.
  virtual void write(std::span<const std::byte> bytes) = 0;
  virtual void finish() = 0;
  /// Bytes that reached the file (compressed ones of a compressed file).
  virtual std::uint64_t bytes_written() const = 0;

  void write(std::string_view text) {
    write(std::span(reinterpret_cast<const std::byte*>(text.data()), text.size()));
  }
};

/// Opens a file for writing, standard output for "-"; a name that ends in .gz is compressed
/// (its bytes depend on the content alone). Small writes are gathered.
std::unique_ptr<ByteSink> open_byte_sink(const std::filesystem::path& path);

}  // namespace orbweave
