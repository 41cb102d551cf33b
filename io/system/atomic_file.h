// A file that is there whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "io/system/temporary_name.h"

namespace orbweave {

class OwnedFiles;

/// Writes beside the target (".<name>.<random>.part" in the same directory) and renames on
/// commit, after flushing to the device unless told otherwise; a file that is replaced keeps its
/// permissions. Destroyed without commit, it removes what it wrote. A target that is a link is
/// written through: the temporary lies beside the file that the link leads to, and the link stays.
/// A target that exists and is no regular file (a pipe, a device) is written to directly. The
/// temporary is on the process's record (io/system/owned_files.h), where it has one: the next run
/// removes what a killed one left. Every failure is an Error (resource) that names the target and
/// the system's reason.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path target);
  /// In a work directory: neither links nor files that are not on the record are written to
  /// (Error, usage).
  AtomicFile(std::filesystem::path target, std::shared_ptr<OwnedFiles> record);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  std::uint64_t bytes_written() const { return bytes_written_; }
  /// Where the bytes are until commit; empty for a target that is no regular file.
  const std::filesystem::path& temporary() const { return temporary_; }
  enum class Flush { kYes, kNo };
  /// Flush, fsync, rename, fsync of the directory. `kNo` leaves both fsyncs to the system: a power
  /// cut may take the bytes or the name.
  void commit(Flush flush = Flush::kYes);

 private:
  void open_target_itself();
  void open_temporary();
  int create_temporary() const;
  void give_name();
  void remove_temporary() noexcept;
  void write_all(const std::byte* bytes, std::size_t count);
  [[noreturn]] void fail(const char* problem) const;

  std::filesystem::path name_;    ///< as it was given
  std::filesystem::path target_;  ///< the file behind links
  std::filesystem::path temporary_;
  std::shared_ptr<OwnedFiles> record_;
  bool replaces_any_ = true;
  TemporaryAtRisk at_risk_;
  int descriptor_ = -1;
  std::uint64_t bytes_written_ = 0;
  std::uint64_t bytes_flushing_ = 0;  ///< handed to the device already
};

}  // namespace orbweave
