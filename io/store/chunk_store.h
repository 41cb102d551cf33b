// The chunk store: everything a job knows between its stages, one HDF5 file per chunk and stage
// in the job's work directory. docs/dev/chunk-store.md describes the layout.
//
// A result is committed (written aside, checksummed, flushed, renamed) or absent; nothing is
// ever half there. Every array carries an XXH3 checksum per block of rows, verified whenever
// rows are read. HDF5 calls are serialised inside (the library is not thread-safe), checksums
// and copies are not, so all methods may be called from many threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/error.h"
#include "io/point_cloud.h"
#include "io/system/disk_space.h"
#include "io/system/owned_files.h"

namespace orbweave {

class OwnedFiles;

/// Index of a chunk: its rank among the octree's leaves in Morton order.
using ChunkId = std::uint32_t;

/// One array of a stage's result, as it is handed in. `columns` values per row.
struct ArrayView {
  std::string name;
  ScalarType type = ScalarType::kUint8;
  std::uint32_t columns = 1;
  std::uint64_t rows = 0;
  const void* data = nullptr;
};

/// A stored result whose bytes do not match their checksums, or that cannot be parsed.
/// The pipeline recomputes what it concerns.
class CorruptResult : public Error {
 public:
  CorruptResult(std::filesystem::path path, const std::string& what_was_found);
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// An open result; reads verify checksums and throw CorruptResult.
class StoredResult {
 public:
  virtual ~StoredResult() = default;
  virtual std::uint64_t rows(const std::string& array) const = 0;
  virtual bool has(const std::string& array) const = 0;
  /// Copies rows [first, first + count) to `out` (native byte order).
  virtual void read(const std::string& array, std::uint64_t first, std::uint64_t count,
                    void* out) const = 0;
  template <class T>
  std::vector<T> read_all(const std::string& array) const {
    std::vector<T> values(rows(array) * row_bytes(array) / sizeof(T));
    read(array, 0, rows(array), values.data());
    return values;
  }
  virtual std::size_t row_bytes(const std::string& array) const = 0;
};

/// What lies in a job's work directory. A store that joined sees what others commit, replace and
/// remove; callers take care that no process reads what another removes.
class ChunkStore {
 public:
  static constexpr int kLayoutVersion = kWorkLayoutVersion;

  /// Opens or creates the directory and locks it (flock). Throws Error: resource when it cannot
  /// be created or written or when another process holds it (says which process id) or members of
  /// an earlier holder's team still run, usage when the directory holds something that is no chunk
  /// store.
  explicit ChunkStore(std::filesystem::path directory);
  /// Opens a directory that another process of the same job holds the lock of, and until its end
  /// keeps it from the next holder (io/store/store_lock.h). Throws Error (resource) where there is
  /// none.
  static std::unique_ptr<ChunkStore> join(std::filesystem::path directory, int rank);
  /// Opens a directory to read what an earlier run left there. Changes nothing in it and keeps
  /// no run from it: what a run replaces or removes meanwhile is a CorruptResult or another Error,
  /// never a wrong result. None where a run is at work there, or there is no sound store.
  static std::unique_ptr<const ChunkStore> look(std::filesystem::path directory);
  ~ChunkStore();
  ChunkStore(const ChunkStore&) = delete;
  ChunkStore& operator=(const ChunkStore&) = delete;

  const std::filesystem::path& directory() const;
  /// Whether the directory was made for the job: it goes with the job.
  bool is_made() const;
  /// Whether results are compressed from now on. What is there is read either way.
  void set_compression(bool on);

  /// Declares what `stage` depends on. When the stored key differs, the stage's results are
  /// removed; returns true when results under the same key may be there.
  bool begin_stage(const std::string& stage, const std::string& key);
  /// Begins the stage and removes results under the same key, too: earlier results are no longer
  /// taken, even where a user puts them back.
  void begin_stage_anew(const std::string& stage, const std::string& key);
  /// What the stage's results depend on; empty: there is no such stage.
  std::optional<std::string> key(const std::string& stage) const;
  /// Whether the stage's results, where there are any, depend on just that; changes nothing.
  bool has_key(const std::string& stage, const std::string& key) const;
  /// A small document that a stage leaves for later ones (JSON text), committed like a result.
  void commit_document(const std::string& stage, const std::string& name, const std::string& text);
  /// Empty: it was never committed, or is damaged.
  std::optional<std::string> document(const std::string& stage, const std::string& name) const;
  /// A document that has to be there. Throws CorruptResult where it is not.
  std::string expected_document(const std::string& stage, const std::string& name) const;

  bool has(const std::string& stage, ChunkId chunk) const;
  /// Writes aside, then makes the result durable and visible. With `wait` false the flush to the
  /// device and the rename happen on a background thread, in order of commit; the result can be
  /// opened at once by this process. finish_commits() waits for them and rethrows their errors.
  void commit(const std::string& stage, ChunkId chunk, std::span<const ArrayView> arrays,
              bool wait = false);
  void finish_commits();
  /// Commits begun so far, and how many of these, the first ones, are durable for certain: what
  /// their results were made from may go.
  std::uint64_t commits_begun() const;
  std::uint64_t commits_durable() const;
  /// Waits until so many are.
  void await_durable(std::uint64_t commits);
  std::unique_ptr<StoredResult> open(const std::string& stage, ChunkId chunk) const;
  /// Removes a result (corrupt, or no longer needed).
  void discard(const std::string& stage, ChunkId chunk);
  /// Removes those of a stage's results that cannot be opened, or belong elsewhere.
  void discard_damaged(const std::string& stage);
  void discard_stage(const std::string& stage);
  /// Removes a stage's results; its key and its documents stay.
  void discard_results(const std::string& stage);
  /// Drops pending flushes, unlocks and removes what the program wrote in the directory, and the
  /// directory where the program made it: the job is done. Returns the names of what is left since
  /// the program did not write it; the directory is left with that.
  std::vector<std::string> remove_all();

  /// Writes what tells this run from others to the members that join it (kTeamMark). Before the
  /// first commit: what a team stores is flushed from the beginning.
  void mark_team(const std::string& run);
  /// Makes an empty file of a job's own in the directory, or takes the one of an earlier run. False
  /// where there is one that the program did not write.
  bool claim(const std::filesystem::path& path);
  /// What this process makes, on record.
  std::shared_ptr<OwnedFiles> record() const;
  /// For the user: what was amiss with the directory; empty: nothing.
  const std::string& note() const;

  /// Leaves word that the job's outputs are all written, `how` saying which; goes last when the
  /// directory is removed, so that a removal that is cut short does not start the job again.
  void set_ended(const std::string& how);
  bool has_ended(const std::string& how) const;
  void clear_ended();

  std::uint64_t bytes_written() const;
  std::uint64_t bytes_read() const;
  /// What the directory holds, and whatever else of the job is told to it.
  DiskUsage& disk() const;

 private:
  struct State;
  ChunkStore();
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
