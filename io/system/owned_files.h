// What a run makes, on record beforehand: nothing that is not on it is ever removed or replaced.
//
// Every process of a run appends to a file of its own in the work directory, "orbweave-record.0"
// for the leader, one line at a time:
//
//   orbweave record 5 <store>   the layout version, and the store that the following lines are of
//   run <run> <inode>           a run begins; the inode of this very file
//   0 <name>                    a file or directory of that name, not there yet, is to be made
//   <inode> <name>              it was made, and is empty so far
//   copied                      the work directory was copied here: names count without inodes
//
// Names are relative to the work directory, those of directories end in "/"; what is made outside
// of it has an absolute name. A file is the program's when name and inode are on record, or the
// name is and the file is empty: a process that is killed at any moment leaves nothing else. Lines
// are not flushed to the device. What a power cut takes of them, and what is damaged, is made up
// for by the files themselves: the store knows its own files by their checksums (set_proof()).
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include "io/system/file_descriptor.h"

namespace orbweave {

/// The layout version of a work directory: of its record and of what the chunk store keeps in it.
inline constexpr int kWorkLayoutVersion = 5;
inline constexpr std::string_view kRecordName = "orbweave-record.";

/// Many hashes in little memory: eight bytes each, but for the latest.
class HashSet {
 public:
  void insert(std::uint64_t hash);
  bool contains(std::uint64_t hash) const;

 private:
  static constexpr std::size_t kMostRecent = 4096;
  std::vector<std::uint64_t> sorted_;
  std::unordered_set<std::uint64_t> recent_;
};

/// Thread-safe. Failures of the system are an Error (resource).
class OwnedFiles {
 public:
  /// What became of a file that was to be removed.
  enum class Removal { kRemoved, kAbsent, kStranger };
  /// Is given a file and its name on the record.
  using Proof = std::function<bool(const std::filesystem::path&, const std::string& name)>;

  /// Reads what all processes recorded for this store and appends to the file of `rank` from now
  /// on. Throws Error (usage) where something else has that file's name.
  OwnedFiles(std::filesystem::path directory, std::string store, int rank);
  /// Reads only; what is made is not recorded.
  OwnedFiles(std::filesystem::path directory, std::string store);
  OwnedFiles(const OwnedFiles&) = delete;
  OwnedFiles& operator=(const OwnedFiles&) = delete;

  /// What else tells a file of the program's, where the record does not.
  void set_proof(Proof proof) { proof_ = std::move(proof); }

  /// Makes an empty file. Not valid where that is impossible, errno says why.
  FileDescriptor try_create(const std::filesystem::path& path);
  /// The same; replaces a file of the program's. Throws Error (usage) where a stranger is there.
  FileDescriptor create(const std::filesystem::path& path);
  /// Makes a directory. False where that is impossible, errno says why.
  bool make_directory(const std::filesystem::path& path);
  /// Gives a file of the program's another name. Throws Error (usage) where a stranger has it;
  /// with `replaces_any`, whatever file has that name is replaced. False: errno says why not.
  bool rename(const std::filesystem::path& from, const std::filesystem::path& to,
              bool replaces_any = false);

  /// Nothing is recorded any more: the work directory is about to go.
  void close();
  /// Removes a record of this store, at the end; other files stay.
  void remove_record(const std::filesystem::path& file);
  /// Puts a name on record that is about to be made and is not there.
  void announce(const std::filesystem::path& path);
  /// Puts what is at `from` on record under the name `to`, which it is about to get.
  void expect(const std::filesystem::path& to, const std::filesystem::path& from);

  /// Whether the program made what is there. Links are not, nor is what is absent.
  bool owns(const std::filesystem::path& path) const;
  /// Removes a file of the program's, or a directory of its own that is empty.
  Removal remove(const std::filesystem::path& path);
  /// The same. Throws Error (usage) for a stranger.
  void remove_or_refuse(const std::filesystem::path& path);
  /// Directories that runs before this one made outside of the work directory and that are there,
  /// with their inodes; the work directory itself may be one.
  std::vector<std::pair<std::uint64_t, std::string>> directories_outside() const;
  /// Removes what runs before this one left outside of the work directory: files on their way
  /// beside outputs, and directories of them.
  void remove_abandoned();

 private:
  using Line = std::pair<std::uint64_t, std::string>;

  std::string name_of(const std::filesystem::path& path) const;
  /// How far a record was read.
  struct Reading {
    std::uint64_t offset = 0;
    bool is_this_store = false;
  };
  void read(const std::filesystem::path& file) const;
  void refresh() const;
  void take(std::uint64_t inode, const std::string& name, bool by_name) const;
  void append(const std::string& text);
  void record(ino_t inode, const std::string& name);
  bool on_record(std::uint64_t inode, const std::string& name) const;
  bool recorded(const std::filesystem::path& path) const;

  std::filesystem::path directory_;
  std::string store_;
  Proof proof_;
  std::filesystem::path file_;
  FileDescriptor output_;
  mutable std::mutex mutex_;
  bool torn_ = false;      ///< the last line is incomplete
  mutable HashSet known_;  ///< hashes of names with their inodes
  mutable std::map<std::filesystem::path, Reading> readings_;
  mutable std::vector<Line> outside_;  ///< that earlier runs made
};

/// Throws Error (usage) where something else has the name of a rank's record.
void check_record_place(const std::filesystem::path& directory, int rank);
/// Whether a file is a record of this or another store, or the empty beginning of one, by its name
/// and content.
bool is_record(const std::filesystem::path& file);
/// Whether a file is a record that has lines of a store.
bool is_record_of(const std::filesystem::path& file, const std::string& store);
/// The store and the layout version that a record is of; empty where it does not say.
std::pair<std::string, int> store_of_record(const std::filesystem::path& file);

/// Removes a directory that the caller knows to be the program's, where it is empty.
void remove_if_empty(const std::filesystem::path& directory);

[[noreturn]] void throw_stranger(const std::filesystem::path& path);

/// While it lives, what this process writes beside its outputs (io/system/atomic_file.h) is on
/// `record`.
class RecordScope {
 public:
  explicit RecordScope(std::shared_ptr<OwnedFiles> record);
  ~RecordScope();
  RecordScope(const RecordScope&) = delete;
  RecordScope& operator=(const RecordScope&) = delete;

 private:
  std::shared_ptr<OwnedFiles> record_;
};
/// Null where there is none: commands without a work directory.
std::shared_ptr<OwnedFiles> current_record();

}  // namespace orbweave
