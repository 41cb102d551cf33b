#include "tests/support/stored_damage.h"

#include <algorithm>
#include <fstream>

#include "tests/support/program.h"

namespace orbweave::test {
namespace {

namespace fs = std::filesystem;

void copy_over(const fs::path& from, const fs::path& to) {
  fs::copy_file(from, to, fs::copy_options::overwrite_existing);
}

/// Files of the same kind: ".h5", ".json", ".xxh3", or "bins.<rank>".
bool is_alike(const fs::path& a, const fs::path& b) {
  const auto kind = [](const fs::path& file) {
    return file.stem() == "bins" ? fs::path("bins") : file.extension();
  };
  return kind(a) == kind(b);
}

/// One of the files that are like `file`, of its stage or of others; empty: there is none.
fs::path one_like(const fs::path& file, bool of_its_stage, const fs::path& work,
                  std::mt19937_64& random) {
  std::vector<fs::path> found;
  for (const fs::path& other : stored_files(work)) {
    const bool is_of_stage = other.parent_path() == file.parent_path();
    if (other != file && is_of_stage == of_its_stage && is_alike(other, file))
      found.push_back(other);
  }
  return found.empty() ? fs::path() : found[random() % found.size()];
}

void flip(const fs::path& file, std::uint64_t at) {
  std::string text = file_text(file);
  const std::uint64_t bit = at % (8 * text.size());
  text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << bit % 8));
  write_text(file, text);
}

bool replace(const fs::path& by, const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(by, ignored)) return false;
  copy_over(by, file);
  return true;
}

bool replace_by_one_like(const fs::path& file, bool of_its_stage, const fs::path& work,
                         std::mt19937_64& random) {
  const fs::path from = one_like(file, of_its_stage, work, random);
  return !from.empty() && replace(work / from, work / file);
}

bool exchange(const fs::path& file, const fs::path& work, std::mt19937_64& random) {
  const fs::path with = one_like(file, true, work, random);
  if (with.empty()) return false;
  const fs::path aside = work.string() + ".aside";
  fs::rename(work / file, aside);
  fs::rename(work / with, work / file);
  fs::rename(aside, work / with);
  return true;
}

}  // namespace

const char* name_of(StoredDamage damage) {
  constexpr std::array kNames = {"flip",        "truncate",  "empty", "sibling", "exchange",
                                 "other stage", "other job", "older", "delete",  "directory"};
  return kNames[static_cast<std::size_t>(damage)];
}

std::vector<fs::path> stored_files(const fs::path& work) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& stage : fs::directory_iterator(work)) {
    if (!stage.is_directory()) continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(stage.path()))
      if (entry.is_regular_file()) files.push_back(entry.path().lexically_relative(work));
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool apply(StoredDamage damage, const fs::path& file, const StoredDirectories& directories,
           std::mt19937_64& random) {
  const fs::path& work = directories.work;
  const fs::path path = work / file;
  const std::uintmax_t bytes = fs::file_size(path);
  switch (damage) {
    case StoredDamage::kFlip:
      if (bytes > 0) flip(path, random());
      return bytes > 0;
    case StoredDamage::kTruncate:
      if (bytes > 0) fs::resize_file(path, random() % bytes);
      return bytes > 0;
    case StoredDamage::kEmpty:
      fs::resize_file(path, 0);
      return true;
    case StoredDamage::kSibling:
      return replace_by_one_like(file, true, work, random);
    case StoredDamage::kExchange:
      return exchange(file, work, random);
    case StoredDamage::kOtherStage:
      return replace_by_one_like(file, false, work, random);
    case StoredDamage::kOtherJob:
      return replace(directories.other / file, path);
    case StoredDamage::kOlder:
      return replace(directories.older / file, path);
    case StoredDamage::kDelete:
      return fs::remove(path);
    case StoredDamage::kDirectory:
      fs::remove(path);
      fs::create_directory(path);
      write_text(path / kUsersFile, "of the user");
      return true;
  }
  return false;
}

}  // namespace orbweave::test
