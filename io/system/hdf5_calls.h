// What all files that call HDF5 share: its lock, identifiers that close themselves, types, arrays.
// The library's own header stays out of this one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/scalar_types.h"

namespace orbweave {

/// As HDF5 defines hid_t and herr_t.
using Hdf5Id = std::int64_t;
using Hdf5Closer = int (*)(Hdf5Id);

/// An HDF5 identifier that closes itself.
class Hdf5Handle {
 public:
  Hdf5Handle(Hdf5Id id, Hdf5Closer closer) : id_(id), close_(closer) {}
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  Hdf5Id get() const { return id_; }
  bool valid() const { return id_ >= 0; }
  /// Closes now; false when that fails.
  bool close() { return close_(std::exchange(id_, -1)) >= 0; }

 private:
  Hdf5Id id_;
  Hdf5Closer close_;
};

/// HDF5 is not thread-safe: every call to it happens while an object of this class exists. HDF5's
/// own complaints on standard error are switched off meanwhile (per thread where HDF5 was built for
/// several); afterwards the host program's error handler is in its place again.
class Hdf5Calls {
 public:
  Hdf5Calls();
  ~Hdf5Calls();
  Hdf5Calls(const Hdf5Calls&) = delete;
  Hdf5Calls& operator=(const Hdf5Calls&) = delete;

 private:
  struct Held;
  std::unique_ptr<Held> held_;
};

/// A file could not be closed, as its disk is full, or not for sure: of what it opened in a damaged
/// file HDF5 may keep something. Call while an Hdf5Calls exists.
void note_unclosed_hdf5_file();

Hdf5Id hdf5_type(ScalarType type);

/// Creates an array whose bytes lie together, with nothing in it, and tells where in the file they
/// are. False on failure.
bool create_hdf5_array(Hdf5Id file, const std::string& name, Hdf5Id type,
                       std::span<const std::uint64_t> shape, std::uint64_t& offset);

/// Whether a file that is there is one of HDF5 and has arrays of these names. False where it cannot
/// be read.
bool has_hdf5_arrays(const std::filesystem::path& path, std::span<const std::string> names);

/// An array of a file that is made as a whole.
struct Hdf5Array {
  std::string name;
  ScalarType type = ScalarType::kFloat64;
  std::vector<std::uint64_t> shape;
};
/// Fills a file that is there with empty arrays, in a form that HDF5 1.8 and later read, and
/// returns where the bytes of each lie. The same arrays make the same bytes. Throws Error
/// (resource), with `name` for the file.
std::vector<std::uint64_t> make_hdf5_file(const std::filesystem::path& path,
                                          const std::filesystem::path& name,
                                          std::span<const Hdf5Array> arrays);

}  // namespace orbweave
