// Damage to what a work directory holds: changed bytes, and files that belong elsewhere.
#pragma once

#include <array>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace orbweave::test {

enum class StoredDamage {
  kFlip,        ///< a bit of it
  kTruncate,    ///< somewhere
  kEmpty,       ///< no byte is left
  kSibling,     ///< another file of the stage is copied over it
  kExchange,    ///< it and another file of the stage get each other's names
  kOtherStage,  ///< a file of another stage is copied over it
  kOtherJob,    ///< the same file of another work directory
  kOlder,       ///< the same file from before an option changed
  kDelete,      ///< it is gone
  kDirectory    ///< a directory with a user's file in it has its name
};
inline constexpr std::array kStoredDamages = {StoredDamage::kFlip,     StoredDamage::kTruncate,
                                              StoredDamage::kEmpty,    StoredDamage::kSibling,
                                              StoredDamage::kExchange, StoredDamage::kOtherStage,
                                              StoredDamage::kOtherJob, StoredDamage::kOlder,
                                              StoredDamage::kDelete,   StoredDamage::kDirectory};
const char* name_of(StoredDamage damage);

/// Where files are taken from.
struct StoredDirectories {
  std::filesystem::path work;   ///< that is damaged
  std::filesystem::path older;  ///< as it was under other options
  std::filesystem::path other;  ///< of another job
};

/// Files of the stages, relative to the work directory, sorted: results, keys, documents, their
/// checksums, bins.
std::vector<std::filesystem::path> stored_files(const std::filesystem::path& work);

/// Damages `file` (relative); false: there is nothing to take its place.
bool apply(StoredDamage damage, const std::filesystem::path& file,
           const StoredDirectories& directories, std::mt19937_64& random);

/// What the user has in the directory that kDirectory makes.
inline constexpr const char* kUsersFile = "notes.txt";

}  // namespace orbweave::test
