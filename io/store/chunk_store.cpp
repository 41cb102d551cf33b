#include "io/store/chunk_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <system_error>
#include <thread>
#include <unordered_map>

#include "io/shown_text.h"
#include "io/store/chunk_store_commits.h"
#include "io/store/chunk_store_file.h"
#include "io/store/result_identity.h"
#include "io/store/store_identity.h"
#include "io/store/store_lock.h"
#include "io/store/work_directory.h"
#include "io/system/atomic_file.h"
#include "io/system/directory.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"
#include "io/system/path_roles.h"
#include "io/system/work_directory_errors.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// Whether one call flushes whatever was written before: what was not flushed at first is then.
#ifdef __linux__
constexpr bool kFlushesAllAtOnce = true;
#else
constexpr bool kFlushesAllAtOnce = false;
#endif

/// What goes with the work directory itself.
constexpr std::array<const char*, 3> kLastFiles = {kStoreFile, kOwnerLock, kEndedFile};

/// Names of what it holds, each with the directory's.
std::vector<fs::path> listed(const fs::path& directory) {
  std::error_code error;
  std::vector<fs::path> entries = entries_of(directory, error);
  if (error && error != std::errc::no_such_file_or_directory)
    throw_directory_error(directory, error.value());
  return entries;
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(fs::symlink_status(path, ignored));
}

/// What runs before this one were writing when they were killed.
void remove_leftovers(OwnedFiles& record, const fs::path& directory) {
  std::vector<fs::path> entries = listed(directory);
  for (std::size_t i = 0, top = entries.size(); i < top; ++i)
    if (is_folder(entries[i]))
      for (fs::path& inner : listed(entries[i])) entries.push_back(std::move(inner));
  for (const fs::path& path : entries)
    if (path.extension() == ".part") record.remove(path);
}

/// What is left in it, sorted; nothing where it is gone.
std::vector<std::string> names_of_strangers(const fs::path& directory) {
  std::vector<std::string> names;
  for (const fs::path& entry : listed(directory)) {
    if (is_ghost(entry)) continue;
    names.push_back(entry.filename().string());
    if (!is_folder(entry)) continue;
    names.pop_back();
    const std::vector<fs::path> inside = listed(entry);
    for (const fs::path& inner : inside)
      names.push_back((entry.filename() / inner.filename()).string());
    if (inside.empty()) names.push_back(entry.filename().string());
  }
  return names;
}

/// Tells a file from the one that had its name before.
struct FileVersion {
  ino_t node = 0;
  off_t bytes = 0;
  time_t seconds = 0;
  long nanoseconds = 0;
  friend bool operator==(const FileVersion&, const FileVersion&) = default;
};

FileVersion version_of(int file) {
  struct stat facts {};
  if (fstat(file, &facts) != 0) return {};
  return {facts.st_ino, facts.st_size, facts.st_mtim.tv_sec, facts.st_mtim.tv_nsec};
}

std::uint64_t room_of_open_file(int file) {
  struct stat facts {};
  return fstat(file, &facts) == 0 ? room_of_file(static_cast<std::uint64_t>(facts.st_size)) : 0;
}

}  // namespace

CorruptResult::CorruptResult(std::filesystem::path path, const std::string& what_was_found)
    : Error(ErrorKind::kResource, "a stored result is damaged",
            {.file = path.string(),
             .found = what_was_found,
             .advice = "The same command computes it again"}),
      path_(std::move(path)) {}

struct ChunkStore::State {
  fs::path directory;
  StoreIdentity identity;
  std::shared_ptr<OwnedFiles> record;
  std::string note;
  FileDescriptor lock;
  std::atomic<std::uint64_t> bytes_written{0};
  std::atomic<std::uint64_t> bytes_read{0};
  DiskUsage disk;
  std::atomic<bool> packs{false};

  // What is known of files that were written or opened; spares HDF5 a look at them. Another member
  // of the team may have replaced them since.
  struct Known {
    FileVersion version;
    std::shared_ptr<const ResultIndex> index;
  };
  /// A stage's key as its file had it.
  struct KnownKey {
    FileVersion version;
    std::optional<StageKey> key;
  };
  static constexpr std::size_t kKnownLimit = 16384;
  mutable std::mutex mutex;
  std::unordered_map<std::string, Known> known;
  mutable std::unordered_map<std::string, KnownKey> known_keys;  // by stage

  CommitQueue commits;  // ends first: its thread refers to nothing above, but its files do

  /// What is known of the directory when this process holds its lock.
  struct Place {
    std::vector<MadeDirectory> made;
    bool has_begun_anew = false;
  };
  Place take_place();
  Place take_place_for_sure();

  void write_text(const fs::path& path, const std::string& text) const;
  /// What a directory lists, where files are flushed by now.
  void flush_names_of(const fs::path& folder) const {
    if (commits.flushes()) flush_names(folder);
  }
  fs::path target(const std::string& stage, ChunkId chunk) const {
    return directory / stage / result_name(chunk);
  }

  /// `file`: the path's, open.
  std::shared_ptr<const ResultIndex> find_known(const fs::path& path, int file) const {
    const FileVersion version = version_of(file);
    const std::scoped_lock guard(mutex);
    const auto found = known.find(path.native());
    return found != known.end() && found->second.version == version ? found->second.index : nullptr;
  }
  void set_known(const fs::path& path, int file, std::shared_ptr<const ResultIndex> index) {
    const FileVersion version = version_of(file);
    const std::scoped_lock guard(mutex);
    if (known.size() >= kKnownLimit) known.clear();
    known[path.native()] = {version, std::move(index)};
  }
  void forget(const fs::path& path) {
    const std::scoped_lock guard(mutex);
    known.erase(path.native());
  }
  void forget_all() {
    const std::scoped_lock guard(mutex);
    known.clear();
  }

  [[noreturn]] void throw_absent(const fs::path& path, int reason) const;
  WrittenResult write(const fs::path& part, std::span<const ArrayView> arrays,
                      const ResultIdentity& belongs_to) const;
  void open_record(int rank);
  void restore_identity();
  void take_over(const fs::path& path) const;
  void make_folder(const fs::path& folder) const;
  void clear_folder(const fs::path& folder) const;
  bool remove_whole(const std::vector<MadeDirectory>& made);

  std::optional<StageKey> key_of(const std::string& stage) const;
  ResultIdentity identity_of(const std::string& stage, const std::string& place) const;
  ResultIdentity identity_of(const std::string& stage, ChunkId chunk) const {
    return identity_of(stage, place_of_chunk(chunk));
  }
};

/// The file is opened each time: over a network only that tells whether it is another one now.
std::optional<StageKey> ChunkStore::State::key_of(const std::string& stage) const {
  const fs::path path = directory / stage / kKeyFile;
  refuse_directory(path);
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.valid() && (errno == ENOENT || errno == ENOTDIR)) return std::nullopt;
  if (!file.valid()) throw_directory_error(path, errno);
  const FileVersion version = version_of(file.get());
  const std::scoped_lock guard(mutex);
  const auto found = known_keys.find(stage);
  if (found != known_keys.end() && found->second.version == version) return found->second.key;
  const std::optional<std::string> text = read_text(path);
  std::optional<StageKey> key = text ? stage_key_from(identity.id, stage, *text) : std::nullopt;
  known_keys[stage] = {version, key};
  return key;
}

ResultIdentity ChunkStore::State::identity_of(const std::string& stage,
                                              const std::string& place) const {
  const std::optional<StageKey> key = key_of(stage);
  return {identity.id, stage, key ? key->edition : std::string(), place};
}

void ChunkStore::State::write_text(const fs::path& path, const std::string& text) const {
  AtomicFile file(path, record);
  file.write(std::string_view(text));
  file.commit(commits.flushes() ? AtomicFile::Flush::kYes : AtomicFile::Flush::kNo);
}

void ChunkStore::State::throw_absent(const fs::path& path, int reason) const {
  std::error_code ignored;
  if (reason == ENOENT && fs::exists(directory, ignored)) throw CorruptResult(path, "no such file");
  throw_read_error(path, reason);
}

void ChunkStore::State::open_record(int rank) {
  record = std::make_shared<OwnedFiles>(directory, identity.id, rank);
  record->set_proof([store = identity.id](const fs::path& file, const std::string& name) {
    return is_proven(store, file, name);
  });
  commits.use(*record);
}

void ChunkStore::State::restore_identity() {
  for (const auto& [inode, path] : record->directories_outside())
    identity.made.push_back({inode, path});
  write_identity(directory, identity, false);
}

/// A file of this store's that lies in a place that is needed goes on record there, wherever it
/// belongs: it was exchanged with another.
void ChunkStore::State::take_over(const fs::path& path) const {
  if (::access(path.c_str(), F_OK) != 0 || record->owns(path)) return;
  const std::optional<ResultIdentity> found = identity_of_stored_file(path);
  if (found && found->store == identity.id) record->expect(path, path);
}

/// A stage's, where it is not there.
void ChunkStore::State::make_folder(const fs::path& folder) const {
  if (record->make_directory(folder)) return flush_names_of(directory);
  if (errno != EEXIST) throw_directory_error(folder, errno);
  if (!fs::is_directory(folder)) throw_stranger(folder);
}

/// Removes a stage's files, its key first, and the folder unless strangers are in it. The key goes
/// for good: one that outlived some of its results would be harmless, results that came back after
/// a crash under a new key would not.
void ChunkStore::State::clear_folder(const fs::path& folder) const {
  if (!fs::is_directory(folder)) throw_stranger(folder);
  take_over(folder / kKeyFile);
  record->remove_or_refuse(folder / kKeyFile);
  for (const fs::path& path : listed(folder)) {
    if (chunk_of_result(path)) take_over(path);  // its place is needed
    record->remove(path);
  }
  record->remove(folder);
}

/// Removes a directory that was made for the job and holds nothing but what goes last. False: it
/// stays under its name, with what it holds.
bool ChunkStore::State::remove_whole(const std::vector<MadeDirectory>& made) {
  const auto is_last = [&](const fs::path& path) {
    return std::ranges::find(kLastFiles, path.filename()) != kLastFiles.end() && record->owns(path);
  };
  if (!orbweave::is_made(directory, made) || !std::ranges::all_of(listed(directory), is_last))
    return false;
  const fs::path aside = put_aside(directory);
  if (aside.empty()) return false;
  // A file system over a network keeps the name of what is open.
  lock = FileDescriptor();
  remove_aside(aside);
  if (take_back(aside, directory)) return false;
  remove_made(directory, made);
  return true;
}

/// Writes a part file; makes the stage's directory when this is its first result.
WrittenResult ChunkStore::State::write(const fs::path& part, std::span<const ArrayView> arrays,
                                       const ResultIdentity& belongs_to) const {
  make_folder(part.parent_path());
  record->create(part);
  try {
    return write_result_file(part, arrays, packs, belongs_to);
  } catch (...) {
    record->remove(part);
    throw;
  }
}

ChunkStore::State::Place ChunkStore::State::take_place() {
  const std::vector<MadeDirectory> made = make_work_directory(directory);
  StoreIdentity found = identify_store(directory);
  const bool has_begun_anew = found.is_new;
  if (found.state == StoreIdentity::State::kVacant) {
    found.made.insert(found.made.end(), made.begin(), made.end());
    if (!write_identity(directory, found, true)) found = identify_store(directory);
  }
  check_record_place(directory, 0);
  lock = lock_as_owner(directory, found.id, kDyingTime, [&](const fs::path& path) {
    return OwnedFiles(directory, found.id).owns(path);
  });
  return {made, has_begun_anew};
}

/// A run that is ending removes its directory while the next one looks at it, or waits for its
/// lock.
ChunkStore::State::Place ChunkStore::State::take_place_for_sure() {
  constexpr int kTries = 3;
  for (int tries = 1;; ++tries) {
    try {
      return take_place();
    } catch (const Error&) {
      std::error_code ignored;
      if (tries == kTries || fs::exists(directory, ignored)) throw;
    }
  }
}

ChunkStore::ChunkStore(std::filesystem::path directory) : state_(std::make_unique<State>()) {
  using Found = StoreIdentity::State;
  State& state = *state_;
  state.directory = std::move(directory);
  const auto [made, has_begun_anew] = state.take_place_for_sure();
  if ((has_begun_anew || !made.empty()) && kFlushesAllAtOnce)
    state.commits.set_first_flush(std::chrono::steady_clock::now() + time_unflushed);
  // No other process changes the identity from here on.
  state.identity = identify_store(state.directory);
  if (state.identity.state != Found::kSound) {
    state.identity.made.insert(state.identity.made.end(), made.begin(), made.end());
    state.note = (state.directory / kStoreFile).string() + ": " + state.identity.damage +
                 "; it is written anew, and what the directory holds counts where its checksums do";
  }
  state.open_record(0);
  if (!state.note.empty()) state.restore_identity();
  for (const MadeDirectory& one : made) state.record->expect(one.path, one.path);
  // The word of its end outlives the store that it was of.
  for (const char* name : kLastFiles)
    if (name != kEndedFile || has_begun_anew)
      state.record->expect(state.directory / name, state.directory / name);
  remove_leftovers(*state.record, state.directory);
  state.record->remove_abandoned();
  state.disk.add(room_of_directory(state.directory));
}

ChunkStore::ChunkStore() : state_(std::make_unique<State>()) {}

std::unique_ptr<ChunkStore> ChunkStore::join(fs::path directory, int rank) {
  std::unique_ptr<ChunkStore> store(new ChunkStore);
  store->state_->directory = std::move(directory);
  const fs::path& path = store->state_->directory;
  if (!fs::exists(path / kStoreFile))
    throw_directory_error(path,
                          "not there for every process; it has to be on a shared file system");
  State& state = *store->state_;
  state.identity = identify_store(path);
  state.open_record(rank);
  const fs::path lock = member_lock(path, rank);
  state.record->announce(lock);
  state.lock = lock_as_member(path, rank, state.identity.id, kDyingTime,
                              [&](const fs::path& file) { return state.record->owns(file); });
  state.record->expect(lock, lock);
  return store;
}

std::unique_ptr<const ChunkStore> ChunkStore::look(fs::path directory) {
  std::error_code ignored;
  if (!fs::exists(directory / kStoreFile, ignored) || is_owned(directory)) return nullptr;
  std::unique_ptr<ChunkStore> store(new ChunkStore);
  State& state = *store->state_;
  state.directory = std::move(directory);
  state.identity = identify_store(state.directory);
  return state.identity.state == StoreIdentity::State::kSound ? std::move(store) : nullptr;
}

ChunkStore::~ChunkStore() = default;

const std::filesystem::path& ChunkStore::directory() const { return state_->directory; }
bool ChunkStore::is_made() const {
  return orbweave::is_made(state_->directory, state_->identity.made);
}
void ChunkStore::set_compression(bool on) { state_->packs = on; }

bool ChunkStore::has_key(const std::string& stage, const std::string& key) const {
  const std::optional<StageKey> stored = state_->key_of(stage);
  return stored && stored->key == key;
}

std::optional<std::string> ChunkStore::key(const std::string& stage) const {
  std::optional<StageKey> stored = state_->key_of(stage);
  return stored ? std::optional(std::move(stored->key)) : std::nullopt;
}

bool ChunkStore::begin_stage(const std::string& stage, const std::string& key) {
  if (has_key(stage, key)) return true;
  begin_stage_anew(stage, key);
  return false;
}

void ChunkStore::begin_stage_anew(const std::string& stage, const std::string& key) {
  discard_stage(stage);
  const fs::path folder = state_->directory / stage;
  state_->make_folder(folder);
  state_->write_text(folder / kKeyFile,
                     stage_key_document(state_->identity.id, stage, {key, new_id()}));
}

// A document lies beside its checksum, so that it stays plain JSON. The checksum is written
// last: a document without its own checksum was never committed.
void ChunkStore::commit_document(const std::string& stage, const std::string& name,
                                 const std::string& text) {
  const fs::path folder = state_->directory / stage;
  if (!fs::is_directory(folder) && fs::is_directory(state_->directory)) state_->make_folder(folder);
  const ResultIdentity identity = state_->identity_of(stage, place_of_document(name));
  for (const char* ending : {".json", ".json.xxh3"}) state_->take_over(folder / (name + ending));
  state_->write_text(folder / (name + ".json"), text);
  state_->write_text(folder / (name + ".json.xxh3"), document_mark(identity, text));
  state_->bytes_written += text.size();
  state_->disk.add(room_of_file(text.size()) + room_of_file(1));
}

std::optional<std::string> ChunkStore::document(const std::string& stage,
                                                const std::string& name) const {
  const fs::path folder = state_->directory / stage;
  for (const char* ending : {".json", ".json.xxh3"}) refuse_directory(folder / (name + ending));
  std::optional<std::string> text = read_text(folder / (name + ".json"));
  const std::optional<std::string> mark = read_text(folder / (name + ".json.xxh3"));
  if (!text || !mark) return std::nullopt;
  if (identity_of_document(*text, *mark) != state_->identity_of(stage, place_of_document(name)))
    return std::nullopt;
  state_->bytes_read += text->size();
  return text;
}

std::string ChunkStore::expected_document(const std::string& stage, const std::string& name) const {
  std::optional<std::string> text = document(stage, name);
  if (!text) throw CorruptResult(state_->directory / stage / (name + ".json"), "no such document");
  return std::move(*text);
}

bool ChunkStore::has(const std::string& stage, ChunkId chunk) const {
  return state_->commits.with_current_name(state_->target(stage, chunk), [](const fs::path& path) {
    return ::access(path.c_str(), F_OK) == 0;
  });
}

void ChunkStore::commit(const std::string& stage, ChunkId chunk, std::span<const ArrayView> arrays,
                        bool wait) {
  const fs::path target = state_->target(stage, chunk);
  std::string part_name(".");
  part_name.append(target.filename().native()).append(".part");
  fs::path part = target.parent_path() / part_name;
  state_->commits.await(target);
  refuse_directory(target);
  state_->take_over(target);
  WrittenResult written = state_->write(part, arrays, state_->identity_of(stage, chunk));
  state_->bytes_written += written.index->file_bytes;
  state_->disk.add(room_of_open_file(written.file.get()));
  state_->set_known(target, written.file.get(), written.index);
  state_->commits.push(std::move(part), target, std::move(written.file));
  if (wait) finish_commits();
}

void ChunkStore::finish_commits() { state_->commits.finish(); }
std::uint64_t ChunkStore::commits_begun() const { return state_->commits.pushed(); }
std::uint64_t ChunkStore::commits_durable() const { return state_->commits.settled(); }
void ChunkStore::await_durable(std::uint64_t commits) { state_->commits.await_settled(commits); }

std::unique_ptr<StoredResult> ChunkStore::open(const std::string& stage, ChunkId chunk) const {
  const fs::path target = state_->target(stage, chunk);
  return state_->commits.with_current_name(target, [&](const fs::path& path) {
    FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.valid()) state_->throw_absent(path, errno);
    std::shared_ptr<const ResultIndex> index = state_->find_known(target, file.get());
    if (index == nullptr) {
      index = read_result_index(path, file.get(), state_->identity_of(stage, chunk));
      state_->set_known(target, file.get(), index);
    }
    return make_file_result(target, std::move(file), std::move(index), state_->bytes_read);
  });
}

void ChunkStore::discard(const std::string& stage, ChunkId chunk) {
  const fs::path target = state_->target(stage, chunk);
  state_->commits.await(target);
  state_->forget(target);
  std::error_code absent;
  const std::uint64_t bytes = fs::file_size(target, absent);
  if (!absent) state_->disk.remove(room_of_file(bytes));
  state_->take_over(target);
  state_->record->remove_or_refuse(target);
}

void ChunkStore::discard_damaged(const std::string& stage) {
  state_->commits.finish();
  std::error_code error;
  std::vector<ChunkId> chunks;
  for (const fs::directory_entry& entry : fs::directory_iterator(state_->directory / stage, error))
    if (const auto chunk = chunk_of_result(entry.path())) chunks.push_back(*chunk);
  for (const ChunkId chunk : chunks) {
    try {
      open(stage, chunk);
    } catch (const CorruptResult&) {
      discard(stage, chunk);
    }
  }
}

void ChunkStore::discard_stage(const std::string& stage) {
  const fs::path folder = state_->directory / stage;
  std::error_code error;
  // A stage that has nothing is not waited for: others may have results on their way.
  if (!fs::exists(folder, error)) return;
  state_->commits.finish();
  state_->forget_all();
  state_->disk.remove(room_of_directory(folder));
  state_->clear_folder(folder);
  state_->flush_names_of(state_->directory);
}

void ChunkStore::discard_results(const std::string& stage) {
  state_->commits.finish();
  state_->forget_all();
  const fs::path folder = state_->directory / stage;
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  const std::uint64_t held = room_of_directory(folder);
  for (const fs::path& path : listed(folder))
    if (path.extension() == ".h5") state_->record->remove(path);
  state_->disk.remove(held - std::min(held, room_of_directory(folder)));
}

// Results whose key is gone are never used, and what is left at every moment is a store, or vacant,
// or only strangers.
std::vector<std::string> ChunkStore::remove_all() {
  state_->commits.drop();
  state_->forget_all();
  const fs::path& directory = state_->directory;
  OwnedFiles& record = *state_->record;
  const auto goes_last = [&](const fs::path& path) {
    const fs::path name = path.filename();
    return std::ranges::find(kLastFiles, name) != kLastFiles.end() ||
           is_record_of(path, state_->identity.id);
  };
  std::vector<MadeDirectory> made = state_->identity.made;
  for (const auto& [inode, path] : record.directories_outside()) made.push_back({inode, path});
  for (const fs::path& entry : listed(directory)) {
    if (goes_last(entry) || is_ghost(entry)) continue;
    if (!is_folder(entry)) {
      record.remove(entry);
    } else if (record.owns(entry) || record.owns(entry / kKeyFile)) {
      record.remove(entry / kKeyFile);
      for (const fs::path& path : listed(entry)) record.remove(path);
      remove_if_empty(entry);
    }
  }
  record.close();
  for (const fs::path& entry : listed(directory)) record.remove_record(entry);
  if (state_->remove_whole(made)) return {};
  for (const char* name : kLastFiles) record.remove(directory / name);
  // A file system over a network keeps the name of what is open.
  state_->lock = FileDescriptor();
  std::vector<std::string> strangers = names_of_strangers(directory);
  if (strangers.empty()) remove_made(directory, made);
  return strangers;
}

void ChunkStore::set_ended(const std::string& how) {
  // It outlives the id of the store, and speaks of the job, its inputs and its outputs as they are:
  // it is true of no other.
  state_->write_text(state_->directory / kEndedFile,
                     ended_document(state_->identity, escaped_text(how)));
}

bool ChunkStore::has_ended(const std::string& how) const {
  return member_of(state_->directory / kEndedFile, "xxh3") == content_checksum(escaped_text(how));
}

void ChunkStore::clear_ended() { state_->record->remove_or_refuse(state_->directory / kEndedFile); }

void ChunkStore::mark_team(const std::string& run) {
  // Over a network others see for certain what was flushed.
  state_->commits.set_first_flush({});
  state_->write_text(state_->directory / kTeamMark, lock_text(run, state_->identity.id));
}

bool ChunkStore::claim(const std::filesystem::path& path) {
  if (state_->record->owns(path)) {
    // One that a kill left empty is known by its name alone so far.
    state_->record->expect(path, path);
    return true;
  }
  const bool made = state_->record->try_create(path).valid();
  if (!made && errno != EEXIST) throw_directory_error(path, errno);
  return made;
}

const std::string& ChunkStore::note() const { return state_->note; }
std::shared_ptr<OwnedFiles> ChunkStore::record() const { return state_->record; }

std::uint64_t ChunkStore::bytes_written() const { return state_->bytes_written; }
std::uint64_t ChunkStore::bytes_read() const { return state_->bytes_read; }
DiskUsage& ChunkStore::disk() const { return state_->disk; }

}  // namespace orbweave
