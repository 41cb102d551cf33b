// A file that is there whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace orbweave {

/// Writes beside the target (".<name>.<random>.part" in the same directory) and renames on
/// commit, after flushing to the device. Destroyed without commit, it removes what it wrote.
/// A target that exists and is no regular file (a pipe, a device) is written to directly.
/// The temporary is locked (flock) as long as it is written, so that remove_abandoned() can tell.
/// Every failure is an Error (resource) that names the target and the system's reason.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  std::uint64_t bytes_written() const { return bytes_written_; }
  /// Where the bytes are until commit; empty for a target that is no regular file.
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Flush, fsync, rename, fsync of the directory.
  void commit();

 private:
  void open_target_itself();
  void open_temporary();
  void write_all(const std::byte* bytes, std::size_t count);
  [[noreturn]] void fail(const char* problem) const;

  std::filesystem::path target_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
  std::uint64_t bytes_written_ = 0;
  std::uint64_t bytes_flushing_ = 0;  ///< handed to the device already
};

/// Removes what writers that were killed left beside `target` or files that share its name but for
/// the extension. Temporaries that a process holds are left alone; so is what cannot be removed.
void remove_abandoned(const std::filesystem::path& target);

}  // namespace orbweave
