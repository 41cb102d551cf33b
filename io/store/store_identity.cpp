#include "io/store/store_identity.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include "io/error.h"
#include "io/json_nesting.h"
#include "io/shown_text.h"
#include "io/store/chunk_store.h"
#include "io/store/chunk_store_file.h"
#include "io/store/json_member.h"
#include "io/store/result_identity.h"
#include "io/store/store_lock.h"
#include "io/system/directory.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"
#include "io/system/path_roles.h"
#include "io/system/small_file.h"
#include "io/system/temporary_name.h"
#include "io/system/work_directory_errors.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using State = StoreIdentity::State;

constexpr const char* kFormat = "orbweave chunk store";
constexpr const char* kChecksumKey = "xxh3";
constexpr std::string_view kChecksumSuffix = ".xxh3";
constexpr const char* kHow = "how";
constexpr const char* kStore = "store";
nlohmann::json parse_json(const std::optional<std::string>& text) {
  return text ? json_of(*text) : nlohmann::json();
}

nlohmann::json to_json(const std::vector<MadeDirectory>& made) {
  nlohmann::json json = nlohmann::json::array();
  for (const MadeDirectory& directory : made)
    json.push_back({{"inode", directory.inode}, {"path", escaped_text(directory.path)}});
  return json;
}

std::vector<fs::path> listed(const fs::path& directory) {
  std::error_code error;
  std::vector<fs::path> entries = entries_of(directory, error);
  if (error) throw_directory_error(directory, error.value());
  return entries;
}

std::vector<MadeDirectory> made_of(const nlohmann::json& json) {
  std::vector<MadeDirectory> made;
  if (!json.is_object() || !json.contains("made") || !json["made"].is_array()) return made;
  for (const nlohmann::json& directory : json["made"]) {
    if (!directory.is_object() || !directory.contains("inode") ||
        !directory["inode"].is_number_unsigned())
      continue;
    made.push_back({directory["inode"].get<std::uint64_t>(),
                    unescaped_text(string_member(directory, "path"))});
  }
  return made;
}

nlohmann::json identity_json(const StoreIdentity& identity) {
  return {{"format", kFormat},
          {"layout_version", ChunkStore::kLayoutVersion},
          {"id", identity.id},
          {"made", to_json(identity.made)}};
}

/// Empty: damaged.
std::optional<StoreIdentity> sound_identity(nlohmann::json json) {
  const std::string checksum = string_member(json, kChecksumKey);
  if (checksum.empty()) return std::nullopt;
  json.erase(kChecksumKey);
  if (content_checksum(json.dump()) != checksum) return std::nullopt;
  return StoreIdentity{State::kSound, string_member(json, "id"), made_of(json), {}};
}

/// The version that another program wrote; empty: the file does not say one.
std::optional<int> other_version(const nlohmann::json& json) {
  if (string_member(json, "format") != kFormat || !json.contains("layout_version") ||
      !json["layout_version"].is_number_integer())
    return std::nullopt;
  const int version = json["layout_version"].get<int>();
  const bool has_checksum = json.contains(kChecksumKey);
  if (version == ChunkStore::kLayoutVersion || (has_checksum && !sound_identity(json)))
    return std::nullopt;
  return version;
}

/// The id of the store by the records in it; empty: there is none.
std::string recorded_id(const fs::path& directory) {
  for (const fs::path& entry : listed(directory)) {
    if (!is_record(entry)) continue;
    const auto [id, version] = store_of_record(entry);
    if (!id.empty() && version == ChunkStore::kLayoutVersion) return id;
  }
  return {};
}

/// The id of the store by the key of a stage in it; empty: there is none.
std::string id_by_a_stage(const fs::path& directory) {
  for (const fs::path& entry : listed(directory)) {
    const auto identity = identity_of_key_document(read_text(entry / kKeyFile).value_or(""));
    if (identity && identity->stage == entry.filename()) return identity->store;
  }
  return {};
}

bool is_regular(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(fs::symlink_status(path, ignored));
}

/// Whether a file says that a job has ended, of whatever store.
bool is_word_of_an_end(const fs::path& file) {
  if (file.filename() != kEndedFile || !is_regular(file)) return false;
  const std::string text = member_of(file, kHow);
  return !text.empty() && member_of(file, kChecksumKey) == content_checksum(text);
}

/// What is neither left by a removal that was cut short nor about to become a store; empty: there
/// is nothing.
fs::path first_stranger(const fs::path& directory) {
  for (const fs::path& entry : listed(directory)) {
    const bool is_store = entry.filename() == kStoreFile && is_regular(entry);
    if (!is_store && !is_ghost(entry) && !is_lock_file(entry, {}) && !is_word_of_an_end(entry))
      return entry;
  }
  return {};
}

[[noreturn]] void throw_something_else(const fs::path& directory, const fs::path& stranger) {
  throw_usage(
      "the directory holds something else than a job's work",
      {.file = directory.string(),
       .found = stranger.filename().string(),
       .expected = "an empty or a new directory",
       .advice = "Move it away, or name another directory with run.work_dir or --work-dir"});
}

[[noreturn]] void throw_no_file(const fs::path& path) {
  std::error_code ignored;
  throw_usage("this is not the file that marks a work directory",
              {.file = path.string(),
               .found = fs::is_directory(fs::symlink_status(path, ignored)) ? "a directory"
                        : fs::is_symlink(fs::symlink_status(path, ignored))
                            ? "a link"
                            : "a file that is not on the program's record",
               .expected = "a file that the program wrote, or nothing",
               .advice = "Move it away and repeat the command, which resumes; or name another "
                         "directory with run.work_dir or --work-dir"});
}

[[noreturn]] void throw_other_version(const fs::path& path, int version) {
  throw_usage("the work directory was written by another version of the program",
              {.file = path.string(),
               .found = "layout version " + std::to_string(version),
               .expected = "layout version " + std::to_string(ChunkStore::kLayoutVersion),
               .advice = "Remove " + directory_of(path).string() +
                         ", or name another directory with run.work_dir or --work-dir"});
}

/// `stranger`: the file itself, or what is beside it.
[[noreturn]] void throw_damaged(const fs::path& path, const fs::path& stranger) {
  throw_usage("the file that marks a work directory is damaged, and nothing else here is a job's",
              {.file = path.string(),
               .found = stranger.string(),
               .expected = "a job's work",
               .advice = "Move the file and what is beside it away, or name another directory with "
                         "run.work_dir or --work-dir"});
}

/// Whether the file is the beginning of what the program writes there.
bool is_cut_short(const fs::path& path) {
  const std::string beginning = "{\n  \"format\": \"" + std::string(kFormat) + "\"";
  const std::string text = read_text(path).value_or("");
  return text.starts_with(beginning) || beginning.starts_with(text);
}

/// Of a directory whose orbweave-store.json is missing or of no use.
StoreIdentity identify_by_the_rest(const fs::path& directory, bool is_missing) {
  const std::string damage = is_missing ? "no such file" : "a damaged file";
  const std::string id = recorded_id(directory);
  if (!id.empty() && !is_missing && !OwnedFiles(directory, id).owns(directory / kStoreFile))
    throw_no_file(directory / kStoreFile);
  if (!id.empty()) return {State::kDamaged, id, {}, damage};
  const std::string id_of_stage = id_by_a_stage(directory);
  if (!id_of_stage.empty()) return {State::kDamaged, id_of_stage, {}, damage};
  const fs::path stranger = first_stranger(directory);
  if (!stranger.empty() && is_missing) throw_something_else(directory, stranger);
  if (!stranger.empty()) throw_damaged(directory / kStoreFile, stranger.filename());
  if (!is_missing && !is_cut_short(directory / kStoreFile))
    throw_damaged(directory / kStoreFile, "a file that the program did not write");
  // A removal that was cut short, or a beginning.
  const nlohmann::json ended = parse_json(read_text(directory / kEndedFile));
  return {is_missing ? State::kVacant : State::kDamaged, new_id(), made_of(ended), damage, true};
}

void write_at_once(const fs::path& path, int file, const std::string& text) {
  errno = 0;  // a write that is cut short sets none
  const bool done =
      file_calls.ftruncate(file, 0) == 0 &&
      file_calls.pwrite(file, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()) &&
      file_calls.fsync(file) == 0;
  if (!done) throw_directory_error(path, errno != 0 ? errno : ENOSPC);
}

std::optional<ResultIdentity> identity_beside(const fs::path& document) {
  const std::optional<std::string> text = read_text(document);
  fs::path mark = document;
  mark += kChecksumSuffix;
  if (!text || !is_regular(mark)) return std::nullopt;
  return identity_of_document(*text, read_text(mark).value_or(""));
}

/// Of what lies beside a document (document_mark()).
std::optional<ResultIdentity> identity_of_mark(const fs::path& file) {
  const std::string text = read_text(file).value_or("");
  const std::size_t end = std::min(text.find('\n'), text.size());
  if (!is_new_id(text.substr(0, end))) return std::nullopt;
  return identity_from(std::string_view(text).substr(std::min(end + 1, text.size())));
}

/// What ResultIdentity::place is in a file of that name; empty: no file of a stage has it.
std::string place_of(const std::string& name) {
  constexpr std::string_view kJson = ".json";
  if (name == kKeyFile) return "key";
  if (const auto chunk = chunk_of_result(name)) return place_of_chunk(*chunk);
  std::string document = name;
  if (document.ends_with(kChecksumSuffix)) document.resize(name.size() - kChecksumSuffix.size());
  if (!document.ends_with(kJson)) return {};
  return place_of_document(document.substr(0, document.size() - kJson.size()));
}

/// Of a file of the work directory itself.
bool is_proven_mark(const std::string& store, const fs::path& file, const std::string& name) {
  if (name == kStoreFile) {
    const std::optional<StoreIdentity> identity = sound_identity(parse_json(read_text(file)));
    return identity && identity->id == store;
  }
  if (name == kEndedFile) return is_word_of_an_end(file) && member_of(file, kStore) == store;
  return is_lock_file(file, store);
}

}  // namespace

std::optional<std::string> read_text(const fs::path& path) {
  std::optional<std::string> text = small_file_text(path);
  // A file that cannot be read for the moment is not a file that is absent or damaged.
  const bool is_absent = errno == ENOENT || errno == ENOTDIR || errno == EISDIR || errno == ELOOP;
  if (!text && !is_absent) throw_directory_error(path, errno);
  return text;
}

std::string member_of(const fs::path& file, const char* member) {
  return string_member(parse_json(read_text(file)), member);
}

std::string ended_document(const StoreIdentity& identity, const std::string& how) {
  nlohmann::json json = {{kHow, how}, {kStore, identity.id}, {kChecksumKey, content_checksum(how)}};
  if (!identity.made.empty()) json["made"] = to_json(identity.made);
  return json.dump(2) + "\n";
}

StoreIdentity identify_store(const fs::path& directory) {
  const fs::path path = directory / kStoreFile;
  std::error_code absent;
  const fs::file_status status = fs::symlink_status(path, absent);
  if (!fs::exists(status)) return identify_by_the_rest(directory, true);
  if (!fs::is_regular_file(status)) throw_no_file(path);
  const nlohmann::json json = parse_json(read_text(path));
  if (const std::optional<int> version = other_version(json)) throw_other_version(path, *version);
  if (std::optional<StoreIdentity> identity = sound_identity(json)) return std::move(*identity);
  return identify_by_the_rest(directory, false);
}

bool write_identity(const fs::path& directory, const StoreIdentity& identity, bool is_new,
                    const fs::path& shown) {
  const fs::path path = directory / kStoreFile;
  const fs::path& named = shown.empty() ? path : shown;
  nlohmann::json json = identity_json(identity);
  json[kChecksumKey] = content_checksum(json.dump());
  const int how = O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | (is_new ? O_EXCL : 0);
  const FileDescriptor file(::open(path.c_str(), how, 0666));
  if (!file.valid() && is_new && errno == EEXIST) return false;
  if (!file.valid()) throw_directory_error(named, errno);
  write_at_once(named, file.get(), json.dump(2) + "\n");
  return true;
}

std::optional<ResultIdentity> identity_of_stored_file(const fs::path& file) {
  const std::string name = file.filename().string();
  if (!is_regular(file)) return std::nullopt;
  if (name == kKeyFile) return identity_of_key_document(read_text(file).value_or(""));
  if (name.ends_with(".h5") || name.ends_with(".h5.part")) return identity_of_result(file);
  if (name.ends_with(".json")) return identity_beside(file);
  return name.ends_with(".json.xxh3") ? identity_of_mark(file) : std::nullopt;
}

bool is_proven(const std::string& store, const fs::path& file, const std::string& name) {
  if (!is_regular(file)) return false;
  const std::size_t slash = name.find('/');
  if (slash == std::string::npos) return is_proven_mark(store, file, name);
  const std::string place = place_of(name.substr(slash + 1));
  if (place.empty()) return false;
  const std::optional<ResultIdentity> found = identity_of_stored_file(file);
  return found && found->store == store && found->stage == name.substr(0, slash) &&
         found->place == place;
}

bool is_ghost(const fs::path& file) { return file.filename().native().starts_with(".nfs"); }

}  // namespace orbweave
