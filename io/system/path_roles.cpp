#include "io/system/path_roles.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <unordered_map>

#include "io/error.h"
#include "io/system/file_descriptor.h"
#include "io/system/system_advice.h"
#include "io/system/temporary_name.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// As many links in a row as the system follows.
constexpr int kMostLinks = 40;

/// A place on disk: "device:inode" where something is there, that of the nearest folder and the
/// names below it where nothing is.
using PlaceKey = std::string;

PlaceKey key_of(const struct stat& facts) {
  return std::to_string(facts.st_dev) + ":" + std::to_string(facts.st_ino);
}

fs::path absolute_path(const fs::path& path) {
  std::error_code gone;  // the current directory
  const fs::path whole = fs::absolute(path, gone);
  return gone ? path : whole;
}

bool is_folder(const fs::path& path) {
  struct stat facts {};
  return ::stat(path.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode);
}

/// A role and where its path leads.
struct Place {
  const PathRole* role = nullptr;
  PlaceKey key;
  /// Folders above it, and above the links on the way to it.
  std::vector<PlaceKey> folders;
  bool exists = false;
  mode_t mode = 0;
  fs::path target;  ///< behind all links

  bool is_special() const { return exists && !S_ISREG(mode) && !S_ISDIR(mode); }
  bool lies_in(const Place& folder) const {
    return std::find(folders.begin(), folders.end(), folder.key) != folders.end();
  }
};

fs::path without_trailing_slash(const fs::path& path) {
  return path.has_filename() || !path.has_relative_path() ? path : path.parent_path();
}

/// Where the link leads that `path` is; empty: `path` is none.
std::optional<fs::path> next_link(const fs::path& path) {
  struct stat facts {};
  if (::lstat(path.c_str(), &facts) != 0 || !S_ISLNK(facts.st_mode)) return std::nullopt;
  std::error_code error;
  const fs::path to = fs::read_symlink(path, error);
  if (error) return std::nullopt;
  return without_trailing_slash(to.is_absolute() ? to : directory_of(path) / to);
}

/// The folder that is there and nearest above `path`, without links, and the names below it.
std::pair<fs::path, std::vector<std::string>> split_at_nearest(fs::path path) {
  for (int links = 0;; ++links) {
    std::error_code error;
    // What is not there has no links, so that ".." takes back the name before it.
    const fs::path whole = fs::weakly_canonical(absolute_path(path), error);
    fs::path nearest = error ? absolute_path(path).lexically_normal() : whole;
    std::vector<std::string> names;
    struct stat facts {};
    while (::lstat(nearest.c_str(), &facts) != 0 && nearest.has_relative_path()) {
      if (nearest.has_filename()) names.push_back(nearest.filename().string());
      nearest = nearest.parent_path();
    }
    std::reverse(names.begin(), names.end());
    // A link to a folder that is not there yet.
    const std::optional<fs::path> next = links < kMostLinks ? next_link(nearest) : std::nullopt;
    if (!next) return {nearest, names};
    path = *next;
    for (const std::string& name : names) path /= name;
  }
}

/// Keys of a path, the outermost folder first and the path itself last; empty: the path has no key.
std::vector<PlaceKey> keys_along(const fs::path& path) {
  const auto [nearest, names] = split_at_nearest(path);
  std::vector<PlaceKey> keys;
  fs::path folder;
  for (const fs::path& name : nearest) {
    folder = folder.empty() ? name : folder / name;
    struct stat facts {};
    if (::lstat(folder.c_str(), &facts) == 0) keys.push_back(key_of(facts));
  }
  for (const std::string& name : names)
    keys.push_back((keys.empty() ? "" : keys.back()) + "/" + name);
  return keys;
}

[[noreturn]] void throw_circle(const fs::path& path) {
  throw_usage("the link leads to itself", {.file = path.string(),
                                           .found = "a circle of links",
                                           .expected = "a file, or a link to one",
                                           .advice = "Remove the link or choose another name"});
}

/// Pipes, terminals and devices are written as they are.
bool is_special_file(const fs::path& path) {
  struct stat facts {};
  return ::stat(path.c_str(), &facts) == 0 && !S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode);
}

/// Calls visit(link) for every link that `path` leads through; returns what is behind the last. A
/// link to a special file is followed no further: what /dev/stdout leads to may have no name, such
/// as a pipe ("pipe:[4711]").
template <class Visit>
fs::path follow(const fs::path& path, const Visit& visit) {
  fs::path target = without_trailing_slash(path);
  for (int links = 0;; ++links) {
    if (is_special_file(target)) return target;
    const std::optional<fs::path> next = next_link(target);
    if (!next) return target;
    if (links == kMostLinks) throw_circle(path);
    visit(target);
    target = *next;
  }
}

Place resolve(const PathRole& role) {
  Place place;
  place.role = &role;
  const auto add_folders = [&](const fs::path& path) {
    std::vector<PlaceKey> keys = keys_along(directory_of(path));
    place.folders.insert(place.folders.end(), keys.begin(), keys.end());
  };
  place.target = follow(role.path, add_folders);
  struct stat facts {};
  place.exists = ::stat(place.target.c_str(), &facts) == 0;
  place.mode = place.exists ? facts.st_mode : 0;
  std::vector<PlaceKey> keys = keys_along(place.target);
  if (keys.empty()) return place;
  place.key = place.exists ? key_of(facts) : keys.back();
  keys.pop_back();
  place.folders.insert(place.folders.end(), keys.begin(), keys.end());
  return place;
}

bool is_stream(const PathRole& role) { return role.path.empty() || role.path == "-"; }

std::vector<Place> resolve_all(std::span<const PathRole> paths) {
  std::vector<Place> places;
  for (const PathRole& role : paths)
    if (!is_stream(role)) places.push_back(resolve(role));
  return places;
}

bool is_written(const Place& place) {
  return place.role->use != PathUse::kReadFile && place.role->use != PathUse::kReadDirectory;
}

/// What lies in it is in danger.
bool is_cleared(const Place& place) {
  return place.role->use == PathUse::kWrittenDirectory ||
         place.role->use == PathUse::kWorkDirectory;
}

[[noreturn]] void throw_same(const Place& a, const Place& b) {
  // An input is told last: it is what would be lost.
  const bool swapped = is_written(b) && !is_written(a);
  const Place& written = swapped ? b : a;
  const Place& other = swapped ? a : b;
  throw_usage(written.role->role + " would replace " + other.role->role,
              {.file = written.role->path.string(),
               .found = other.role->path.string() + ", the same place on disk",
               .expected = "a place for each of them",
               .advice = "Choose another name for one of them"});
}

[[noreturn]] void throw_inside(const Place& inner, const Place& outer) {
  const char* const fate = outer.role->use == PathUse::kWorkDirectory
                               ? ", which is removed in the end"
                               : ", which is replaced as a whole";
  throw_usage(inner.role->role + " lies in " + outer.role->role + (is_cleared(outer) ? fate : ""),
              {.file = inner.role->path.string(),
               .found = "a path in " + outer.role->path.string(),
               .expected = "a place outside of it",
               .advice = "Choose another place for one of them"});
}

bool is_below_a_file(const Place& inner, const Place& outer) {
  return outer.role->use == PathUse::kWrittenFile && inner.lies_in(outer) && !S_ISDIR(outer.mode);
}

void check_pair(const Place& a, const Place& b) {
  if (a.is_special() || b.is_special()) return;
  if (!is_written(a) && !is_written(b)) return;
  if (!a.key.empty() && a.key == b.key) throw_same(a, b);
  for (const auto& [inner, outer] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    const bool meant =
        inner->role->in_work_directory && outer->role->use == PathUse::kWorkDirectory;
    if (meant || !inner->lies_in(*outer)) continue;
    if (is_cleared(*outer) || is_below_a_file(*inner, *outer)) throw_inside(*inner, *outer);
  }
}

void check_pairs(const std::vector<Place>& places) {
  // Scans may be thousands, outputs are few.
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!is_written(places[i])) continue;
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (k != i && (k > i || !is_written(places[k]))) check_pair(places[i], places[k]);
    }
  }
}

// ------------------------------------------------------------------- can it be written

void check_kind(const Place& place) {
  const bool file_wanted = place.role->use == PathUse::kWrittenFile;
  if (!place.exists || S_ISDIR(place.mode) != file_wanted) return;
  throw_usage(place.role->role + " cannot be written there",
              {.file = place.role->path.string(),
               .found = file_wanted ? "a directory of that name" : "no directory",
               .expected = file_wanted ? "a file, or nothing" : "a directory, or nothing",
               .advice = "Move it away or choose another name"});
}

[[noreturn]] void throw_folder(const Place& place, const std::string& found,
                               const std::string& advice) {
  throw_resource(place.role->role + " cannot be written there",
                 {.file = place.role->path.string(),
                  .found = found,
                  .expected = "a directory that exists and may be written",
                  .advice = advice});
}

/// Folders of outputs have to be there; those of a work directory are made.
void check_folder(const Place& place) {
  if (place.is_special() || place.role->in_work_directory || !place.role->is_certain) return;
  fs::path folder = directory_of(place.target);
  if (place.role->use == PathUse::kWorkDirectory)
    folder = place.exists ? place.target : split_at_nearest(place.target).first;
  if (folder.empty())
    throw_folder(place, "that the current folder was removed", "Change to a folder that is there");
  if (!is_folder(folder))
    throw_folder(place, folder.string() + ", which is no directory",
                 "Create " + folder.string() + " or choose another place");
  if (::access(folder.c_str(), W_OK) == 0) return;
  const int error = errno;
  throw_folder(place, folder.string() + ": " + system_reason(error),
               advice_on(error, "choose another place"));
}

}  // namespace

void check_collisions(std::span<const PathRole> paths) { check_pairs(resolve_all(paths)); }

void check_paths(std::span<const PathRole> paths) {
  for (const PathRole& path : paths)
    if (path.path == "-" && path.use == PathUse::kWrittenDirectory)
      throw_usage(path.role + " is not written to standard output",
                  {.expected = "the name of a folder"});
  const std::vector<Place> places = resolve_all(paths);
  check_pairs(places);
  for (const Place& place : places) {
    if (!is_written(place)) continue;
    check_kind(place);
    check_folder(place);
  }
}

fs::path final_target(const fs::path& path) {
  return follow(path, [](const fs::path&) {});
}

}  // namespace orbweave
