// Whether a directory is a job's work directory, and which of its files are the program's by what
// they hold. What is on record besides, io/system/owned_files.h knows.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "io/store/result_identity.h"

namespace orbweave {

inline constexpr const char* kStoreFile = "orbweave-store.json";
inline constexpr const char* kKeyFile = "key.json";
inline constexpr const char* kEndedFile = "ended.json";

/// A directory that was made for the job; it goes with the job.
struct MadeDirectory {
  std::uint64_t inode = 0;
  std::string path;  ///< absolute
};

struct StoreIdentity {
  enum class State {
    kVacant,  ///< nothing is there but what a start or a removal that was cut short left
    kSound,
    kDamaged  ///< orbweave-store.json is, and the rest shows that it is a job's work
  };
  State state = State::kVacant;
  std::string id;                   ///< random; kVacant: a new one
  std::vector<MadeDirectory> made;  ///< the work directory and folders above it
  std::string damage;               ///< what was found, of kDamaged
  bool is_new = false;              ///< the id was drawn just now: no store is there
};

/// Looks and changes nothing. Throws Error (usage) where the directory holds something else, names
/// it and says how to go on; (resource) where it cannot be read.
StoreIdentity identify_store(const std::filesystem::path& directory);

/// Writes orbweave-store.json, durably. False where `is_new` and another process was faster. Throws
/// Error (resource), which names the directory as `shown` where that is not empty.
bool write_identity(const std::filesystem::path& directory, const StoreIdentity& identity,
                    bool is_new, const std::filesystem::path& shown = {});

/// Whether a file is one of the store's by its content: a result that can be read, a document with
/// its checksum, a lock, each of this store and in its own place. `name` is relative to the work
/// directory, that of a result that is being written without what marks it as that.
bool is_proven(const std::string& store, const std::filesystem::path& file,
               const std::string& name);
/// Where the content of a result, a document, its mark or a key belongs. Empty: it is none of them,
/// or damaged.
std::optional<ResultIdentity> identity_of_stored_file(const std::filesystem::path& file);
/// What file systems over a network keep of a file that is removed and still open.
bool is_ghost(const std::filesystem::path& file);

// Small documents.
std::optional<std::string> read_text(const std::filesystem::path& path);
/// A text of a JSON file; empty: there is no such file or member, or it is no text.
std::string member_of(const std::filesystem::path& file, const char* member);
/// A JSON file of a store with the text `how` and, as "xxh3", its fingerprint; and what was made
/// for the job, where there is any.
std::string ended_document(const StoreIdentity& identity, const std::string& how);

}  // namespace orbweave
