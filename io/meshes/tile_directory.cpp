#include "io/meshes/tile_directory.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/hex_digits.h"
#include "io/json_nesting.h"
#include "io/system/directory.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"
#include "io/system/running_checksum.h"
#include "io/system/system_advice.h"
#include "io/system/temporary_name.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& target, const std::error_code& reason) {
  throw_resource("cannot write the tiles",
                 {.file = target.string(),
                  .place = {},
                  .found = reason.message(),
                  .expected = {},
                  .advice = advice_on(reason.value(), "name another output")});
}

[[noreturn]] void fail_of_system(const fs::path& target) {
  fail(target, std::error_code(errno, std::system_category()));
}

[[noreturn]] void refuse(const fs::path& directory, const std::string& found) {
  throw_usage("the tiles would replace what is there",
              {.file = directory.string(),
               .place = {},
               .found = found,
               .expected = "nothing, or the tiles of an earlier run as it wrote them",
               .advice = "Move it away or name another output"});
}

/// Both names change their meaning at once where the system can do that.
bool exchange(const fs::path& a, const fs::path& b) {
#ifdef RENAME_EXCHANGE
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
#else
  return false;
#endif
}

std::vector<fs::path> present(const fs::path& directory) {
  std::error_code error;
  std::vector<fs::path> entries = entries_of(directory, error);
  if (error) fail(directory, error);
  return entries;
}

}  // namespace

fs::path tile_directory_of(const fs::path& mesh) {
  fs::path stem = mesh;
  if (stem.extension() == ".gz") stem.replace_extension();
  return stem.replace_extension(kTilesExtension);
}

std::string tile_name(const fs::path& mesh, std::uint32_t number) {
  char text[16];
  std::snprintf(text, sizeof text, "%06u", number);
  return map_tile_name(mesh, text);
}

std::string map_tile_name(const fs::path& mesh, const std::string& cell) {
  return cell + (mesh.extension() == ".gz" ? ".ply.gz" : ".ply");
}

std::uint64_t file_checksum(const fs::path& file) {
  constexpr std::size_t kBufferBytes = std::size_t{1} << 18;
  const FileDescriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!opened.valid()) fail_of_system(file);
  RunningChecksum checksum;
  std::vector<char> buffer(kBufferBytes);
  for (;;) {
    const ssize_t count = ::read(opened.get(), buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_of_system(file);
    if (count == 0) return checksum.value();
    checksum.add(buffer.data(), static_cast<std::size_t>(count));
  }
}

std::optional<TileIndex> read_tile_index(const fs::path& directory) {
  const fs::path index = directory / kTileIndex;
  std::error_code absent;
  if (!fs::is_regular_file(fs::symlink_status(index, absent))) return std::nullopt;
  std::ifstream stream(index);
  const nlohmann::json json = json_of(std::string{std::istreambuf_iterator<char>(stream), {}});
  if (!json.is_object() || json.value("format", nlohmann::json()) != kTileFormat ||
      !json.contains("tiles") || !json["tiles"].is_array())
    return std::nullopt;
  TileIndex found;
  const auto count = [&](const char* key) {
    return json.contains(key) && json[key].is_number_unsigned() ? json[key].get<std::uint64_t>()
                                                                : 0;
  };
  found.vertices = count("vertices");
  found.triangles = count("triangles");
  for (const nlohmann::json& tile : json["tiles"]) {
    const auto has = [&](const char* key) { return tile.is_object() && tile.contains(key); };
    if (!has("file") || !has("bytes") || !has("xxh3")) continue;
    if (!tile["file"].is_string() || !tile["bytes"].is_number_unsigned() ||
        !tile["xxh3"].is_string())
      continue;
    found.files[tile["file"].get<std::string>()] = {tile["bytes"].get<std::uint64_t>(),
                                                    tile["xxh3"].get<std::string>()};
  }
  return found;
}

bool is_as_listed(const fs::path& file, const ListedTile& tile) {
  std::error_code error;
  return fs::is_regular_file(fs::symlink_status(file, error)) &&
         fs::file_size(file, error) == tile.bytes && !error &&
         hex_digits(file_checksum(file)) == tile.checksum;
}

std::vector<std::string> check_tile_directory(const fs::path& directory) {
  std::error_code absent;
  const auto status = fs::status(directory, absent);
  if (!fs::exists(status)) return {};
  if (!fs::is_directory(status)) refuse(directory, "no directory");
  const std::optional<TileIndex> listed = read_tile_index(directory);
  std::vector<std::string> names;
  for (const fs::path& entry : present(directory)) {
    const std::string name = entry.filename().string();
    names.push_back(name);
    if (listed && name == kTileIndex) continue;
    const auto tile =
        listed ? listed->files.find(name) : std::map<std::string, ListedTile>::const_iterator();
    if (!listed || tile == listed->files.end())
      refuse(directory, name + (listed ? ", which its " : ", and no ") + kTileIndex +
                            (listed ? " does not list" : " that lists it"));
    if (!is_as_listed(entry, tile->second))
      refuse(directory, name + ", which is not as its " + kTileIndex + " has it");
  }
  return names;
}

bool remove_tile_directory(const fs::path& directory, OwnedFiles& record) {
  std::error_code absent;
  if (!fs::is_directory(fs::symlink_status(directory, absent)) || !record.owns(directory))
    return false;
  std::vector<fs::path> files;
  try {
    for (const std::string& name : check_tile_directory(directory))
      files.push_back(directory / name);
  } catch (const Error&) {
    return false;  // something else is there, or a tile was changed
  }
  if (!std::ranges::all_of(files, [&](const fs::path& file) { return record.owns(file); }))
    return false;
  // The index last: without it what is left could not be told from other files.
  std::stable_partition(files.begin(), files.end(),
                        [](const fs::path& file) { return file.filename() != kTileIndex; });
  for (const fs::path& file : files) record.remove(file);
  return record.remove(directory) == OwnedFiles::Removal::kRemoved;
}

TileDirectory::TileDirectory(fs::path target)
    : target_(std::move(target)), record_(current_record()) {
  if (!record_) throw std::logic_error("tiles are made on the record of a job");
  for (;;) {
    fs::path temporary = temporary_beside(target_);
    const bool made = record_->make_directory(temporary);
    if (!made && errno == EEXIST) continue;
    if (!made) fail_of_system(target_);
    temporary_ = std::move(temporary);
    return;
  }
}

TileDirectory::~TileDirectory() {
  if (!temporary_.empty()) clear(temporary_);
}

void TileDirectory::clear(const fs::path& directory) noexcept {
  try {
    for (const fs::path& file : present(directory)) record_->remove(file);
    record_->remove(directory);
  } catch (const std::exception&) {
    // The next run removes it.
  }
}

void TileDirectory::commit() {
  flush_directory(temporary_);
  std::error_code absent;
  const bool replaces = fs::exists(target_, absent);
  // On record under the names that they are about to have, so that a later run knows them.
  record_->expect(target_, temporary_);
  for (const fs::path& tile : present(temporary_)) record_->expect(target_ / tile.filename(), tile);
  if (replaces)
    replace(check_tile_directory(target_));
  else if (!record_->rename(temporary_, target_, true))
    fail_of_system(target_);
  else
    temporary_.clear();
  flush_directory(directory_of(target_));
  if (!temporary_.empty()) clear(std::exchange(temporary_, fs::path()));  // the old ones
}

/// The old tiles, which were just found to be as they were written, go on record under the names
/// that they are about to have.
void TileDirectory::replace(const std::vector<std::string>& old) {
  for (const fs::path& place : {temporary_, target_}) {
    record_->expect(place, target_);
    for (const std::string& name : old) record_->expect(place / name, target_ / name);
  }
  if (exchange(temporary_, target_)) return;
  clear(target_);
  if (!record_->rename(temporary_, target_, true)) fail_of_system(target_);
  temporary_.clear();
}

}  // namespace orbweave
