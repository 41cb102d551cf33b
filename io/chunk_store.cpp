#include "io/chunk_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <thread>
#include <unordered_map>

#include "io/atomic_file.h"
#include "io/chunk_store_commits.h"
#include "io/chunk_store_file.h"
#include "io/store_lock.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStoreFile = "orbweave-store.json";
constexpr const char* kKeyFile = "key.json";
constexpr const char* kEndedFile = "ended.json";
constexpr const char* kFormat = "orbweave chunk store";

[[noreturn]] void throw_directory_error(const fs::path& path, const std::string& reason) {
  throw_resource("cannot use the work directory",
                 {.file = path.string(),
                  .found = reason,
                  .advice = "Name another with run.work_dir or --work-dir"});
}

std::string hex(std::uint64_t value) {
  std::array<char, 17> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, 16).ptr;
  const std::string digits(text.data(), end);
  return std::string(16 - digits.size(), '0') + digits;
}

std::string fingerprint(const std::string& text) {
  const XXH128_hash_t hash = XXH3_128bits(text.data(), text.size());
  return hex(hash.high64) + hex(hash.low64);
}

std::optional<std::string> read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  return file.bad() ? std::nullopt : std::optional(text.str());
}

void write_text(const fs::path& path, const std::string& text) {
  AtomicFile file(path);
  file.write(std::string_view(text));
  file.commit();
}

nlohmann::json parse_json(const std::optional<std::string>& text) {
  return text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
}

std::string string_member(const nlohmann::json& json, const char* name) {
  if (!json.is_object() || !json.contains(name) || !json[name].is_string()) return {};
  return json[name].get<std::string>();
}

bool is_leftover(const fs::path& path) { return path.extension() == ".part"; }

void remove_leftovers(const fs::path& directory) {
  std::error_code ignored;
  std::vector<fs::path> leftovers;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, ignored)) {
    if (entry.is_directory(ignored)) {
      for (const fs::directory_entry& inner : fs::directory_iterator(entry.path(), ignored))
        if (is_leftover(inner.path())) leftovers.push_back(inner.path());
    } else if (is_leftover(entry.path())) {
      leftovers.push_back(entry.path());
    }
  }
  for (const fs::path& path : leftovers) fs::remove(path, ignored);
}

/// A directory may become a store when it has nothing in it but what an interrupted start or an
/// interrupted removal left.
bool is_vacant(const fs::path& directory) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    const fs::path name = entry.path().filename();
    // NFS keeps what is removed and still open under a name of its own.
    const bool is_ghost = name.native().starts_with(".nfs");
    if (!is_lock_file(name) && name != kEndedFile && !is_leftover(name) && !is_ghost) return false;
  }
  if (error) throw_directory_error(directory, error.message());
  return true;
}

void make_directory(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error && !fs::is_directory(path, error) && !error)
    error = std::make_error_code(std::errc::not_a_directory);
  if (error) throw_directory_error(path, error.message());
}

/// Refuses directories that are something else, before anything in them is touched.
void check_identity(const fs::path& directory) {
  const fs::path path = directory / kStoreFile;
  if (!fs::exists(path)) {
    if (is_vacant(directory)) return;
    throw_usage("the directory holds something else than a job's work",
                {.file = directory.string(),
                 .expected = "an empty or a new directory",
                 .advice = "Name another with run.work_dir or --work-dir"});
  }
  const nlohmann::json json = parse_json(read_text(path));
  if (string_member(json, "format") == kFormat && json.contains("layout_version") &&
      json["layout_version"] == ChunkStore::kLayoutVersion)
    return;
  throw_usage("the work directory was written by another version of the program, or is damaged",
              {.file = path.string(),
               .expected = "layout version " + std::to_string(ChunkStore::kLayoutVersion),
               .advice = "Remove the directory, or name another with run.work_dir or --work-dir"});
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
    : Error(ExitStatus::kResource, "a stored result is damaged",
            {.file = path.string(),
             .found = what_was_found,
             .advice = "The same command computes it again"}),
      path_(std::move(path)) {}

struct ChunkStore::State {
  fs::path directory;
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
  static constexpr std::size_t kKnownLimit = 16384;
  mutable std::mutex mutex;
  std::unordered_map<std::string, Known> known;

  CommitQueue commits;  // ends first: its thread refers to nothing above, but its files do

  fs::path target(const std::string& stage, ChunkId chunk) const {
    std::array<char, 24> name{};
    std::snprintf(name.data(), name.size(), "%06u.h5", chunk);
    return directory / stage / name.data();
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
  WrittenResult write(const fs::path& part, std::span<const ArrayView> arrays) const;
};

void ChunkStore::State::throw_absent(const fs::path& path, int reason) const {
  std::error_code ignored;
  if (reason == ENOENT && fs::exists(directory, ignored)) throw CorruptResult(path, "no such file");
  throw_read_error(path, reason);
}

/// Writes a part file; makes the stage's directory when this is its first result.
WrittenResult ChunkStore::State::write(const fs::path& part,
                                       std::span<const ArrayView> arrays) const {
  const fs::path stage = part.parent_path();
  if (::mkdir(stage.c_str(), 0777) == 0) {
    flush_directory(directory);
  } else if (errno != EEXIST) {
    throw_directory_error(stage, std::strerror(errno));
  }
  return write_result_file(part, arrays, packs);
}

ChunkStore::ChunkStore(std::filesystem::path directory) : state_(std::make_unique<State>()) {
  state_->directory = std::move(directory);
  make_directory(state_->directory);
  check_identity(state_->directory);
  state_->lock = lock_as_owner(state_->directory);
  remove_leftovers(state_->directory);
  state_->disk.add(room_of_directory(state_->directory));
  if (fs::exists(state_->directory / kStoreFile)) return;
  const nlohmann::json json = {{"format", kFormat}, {"layout_version", kLayoutVersion}};
  write_text(state_->directory / kStoreFile, json.dump(2) + "\n");
}

ChunkStore::ChunkStore() : state_(std::make_unique<State>()) {}

std::unique_ptr<ChunkStore> ChunkStore::join(fs::path directory, int rank) {
  std::unique_ptr<ChunkStore> store(new ChunkStore);
  store->state_->directory = std::move(directory);
  const fs::path& path = store->state_->directory;
  if (!fs::exists(path / kStoreFile))
    throw_directory_error(path,
                          "not there for every process; it has to be on a shared file system");
  check_identity(path);
  store->state_->lock = lock_as_member(path, rank);
  return store;
}

ChunkStore::~ChunkStore() = default;

const std::filesystem::path& ChunkStore::directory() const { return state_->directory; }
void ChunkStore::set_compression(bool on) { state_->packs = on; }

bool ChunkStore::has_key(const std::string& stage, const std::string& key) const {
  const nlohmann::json stored = parse_json(read_text(state_->directory / stage / kKeyFile));
  return string_member(stored, "xxh3") == fingerprint(key);
}

std::optional<std::string> ChunkStore::key(const std::string& stage) const {
  const nlohmann::json stored = parse_json(read_text(state_->directory / stage / kKeyFile));
  std::string key = string_member(stored, "key");
  return key.empty() ? std::nullopt : std::optional(std::move(key));
}

bool ChunkStore::begin_stage(const std::string& stage, const std::string& key) {
  if (has_key(stage, key)) return true;
  const fs::path folder = state_->directory / stage;
  const std::string print = fingerprint(key);
  discard_stage(stage);
  make_directory(folder);
  flush_directory(state_->directory);
  const nlohmann::json json = {{"key", key}, {"xxh3", print}};
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
  write_text(folder / kKeyFile, json.dump(2, ' ', false, kReplace) + "\n");
  return false;
}

// A document lies beside its checksum, so that it stays plain JSON. The checksum is written
// last: a document without its own checksum was never committed.
void ChunkStore::commit_document(const std::string& stage, const std::string& name,
                                 const std::string& text) {
  const fs::path folder = state_->directory / stage;
  if (!fs::is_directory(folder) && fs::is_directory(state_->directory)) make_directory(folder);
  write_text(folder / (name + ".json"), text);
  write_text(folder / (name + ".json.xxh3"), fingerprint(text) + "\n");
  state_->bytes_written += text.size();
  state_->disk.add(room_of_file(text.size()) + room_of_file(1));
}

std::optional<std::string> ChunkStore::document(const std::string& stage,
                                                const std::string& name) const {
  const fs::path folder = state_->directory / stage;
  std::optional<std::string> text = read_text(folder / (name + ".json"));
  if (!text || read_text(folder / (name + ".json.xxh3")) != fingerprint(*text) + "\n")
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
  WrittenResult written = state_->write(part, arrays);
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
      index = read_result_index(path, file.get());
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
  if (::unlink(target.c_str()) != 0 && errno != ENOENT)
    throw_directory_error(target, std::strerror(errno));
}

void ChunkStore::discard_stage(const std::string& stage) {
  state_->commits.finish();
  state_->forget_all();
  const fs::path folder = state_->directory / stage;
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  state_->disk.remove(room_of_directory(folder));
  // The key goes first and for good: a key that outlived some of its results would be harmless,
  // results that came back after a crash under a new key would not.
  fs::remove(folder / kKeyFile, error);
  if (!error) fs::remove_all(folder, error);
  if (error) throw_directory_error(folder, error.message());
  flush_directory(state_->directory);
}

void ChunkStore::discard_results(const std::string& stage) {
  state_->commits.finish();
  state_->forget_all();
  const fs::path folder = state_->directory / stage;
  std::error_code error;
  std::vector<fs::path> results;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".h5") results.push_back(entry.path());
  if (error == std::errc::no_such_file_or_directory) return;
  const std::uint64_t held = room_of_directory(folder);
  for (std::size_t i = 0; i < results.size() && !error; ++i) fs::remove(results[i], error);
  state_->disk.remove(held - std::min(held, room_of_directory(folder)));
  if (error) throw_directory_error(folder, error.message());
}

// Results whose key is gone are never used, and what is left at every moment is a store or vacant.
void ChunkStore::remove_all() {
  state_->commits.drop();
  state_->forget_all();
  std::error_code error;
  const fs::path& directory = state_->directory;
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error))
    entries.push_back(entry.path());
  for (const fs::path& entry : entries) {
    const fs::path name = entry.filename();
    if (name == kStoreFile || name == kOwnerLock || name == kEndedFile) continue;
    std::error_code ignored;
    fs::remove(entry / kKeyFile, ignored);
    if (!error) fs::remove_all(entry, error);
  }
  for (const char* last : {kStoreFile, kOwnerLock, kEndedFile})
    if (!error) fs::remove(directory / last, error);
  // A file system over a network keeps the name of what is open.
  state_->lock = FileDescriptor();
  if (!error) fs::remove(directory, error);
  // By now another job may have begun there; and a log that is still open may be left.
  const bool gone = !error || error == std::errc::no_such_file_or_directory ||
                    error == std::errc::directory_not_empty;
  if (!gone) throw_directory_error(directory, error.message());
}

void ChunkStore::set_ended(const std::string& how) {
  const nlohmann::json json = {{"how", how}, {"xxh3", fingerprint(how)}};
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
  write_text(state_->directory / kEndedFile, json.dump(2, ' ', false, kReplace) + "\n");
}

bool ChunkStore::has_ended(const std::string& how) const {
  const nlohmann::json stored = parse_json(read_text(state_->directory / kEndedFile));
  return string_member(stored, "xxh3") == fingerprint(how);
}

void ChunkStore::clear_ended() {
  std::error_code error;
  const fs::path path = state_->directory / kEndedFile;
  fs::remove(path, error);
  if (error) throw_directory_error(path, error.message());
}

std::uint64_t ChunkStore::bytes_written() const { return state_->bytes_written; }
std::uint64_t ChunkStore::bytes_read() const { return state_->bytes_read; }
DiskUsage& ChunkStore::disk() const { return state_->disk; }

}  // namespace orbweave
