#include "engine/levels/tileset_copy.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <system_error>

#include "engine/levels/tileset.h"
#include "engine/levels/tileset_index.h"
#include "io/error.h"
#include "io/meshes/tile_directory.h"
#include "io/system/atomic_file.h"
#include "io/system/file_descriptor.h"
#include "io/system/path_roles.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// A name of the index may come from anywhere.
bool is_of_tileset(const std::string& name) {
  if (name == kTilesetName) return true;
  return name.ends_with(".glb") && name.find('/') == std::string::npos;
}

[[noreturn]] void fail_to_read(const fs::path& file) {
  throw_bad_input("cannot be read",
                  {.file = file.string(), .found = std::generic_category().message(errno)});
}

void copy_file(const fs::path& from, const fs::path& to, const StopToken& stop) {
  constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
  const FileDescriptor source(::open(from.c_str(), O_RDONLY | O_CLOEXEC));
  if (!source.valid()) fail_to_read(from);
  AtomicFile target(to);
  std::vector<std::byte> buffer(kBufferBytes);
  for (;;) {
    stop.check();
    const ssize_t count = ::read(source.get(), buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_to_read(from);
    if (count == 0) break;
    target.write(std::span(buffer).first(static_cast<std::size_t>(count)));
  }
  target.commit();
}

}  // namespace

TilesetCopy copy_tileset(const fs::path& from, const fs::path& to,
                         const std::vector<NamedText>& beside, const StopToken& stop) {
  const std::optional<TileIndex> index = read_tile_index(from);
  if (!index || !index->files.contains(kTilesetName))
    throw_bad_input("no tileset of orbweave",
                    {.file = from.string(),
                     .found = std::string("no ") + kTileIndex + " that lists " + kTilesetName,
                     .expected = "a folder that 'orbweave tileset' wrote",
                     .advice = "Make one: orbweave tileset MESH -o DIR"});
  check_tile_directory(to);
  TileDirectory target(final_target(to));
  std::vector<std::string> names;
  for (const auto& [name, listed] : index->files) {
    if (!is_of_tileset(name)) continue;
    copy_file(from / name, target.temporary() / name, stop);
    if (!is_as_listed(target.temporary() / name, listed))
      throw_bad_input("the tileset is damaged",
                      {.file = (from / name).string(),
                       .found = std::string("other bytes than its ") + kTileIndex + " has",
                       .advice = "Make it again: orbweave tileset MESH -o DIR"});
    names.push_back(name);
  }
  for (const NamedText& file : beside) {
    write_text_file(target.temporary() / file.name, file.text);
    names.push_back(file.name);
  }
  const TilesetCopy copy{
      index->vertices, index->triangles,
      write_tileset_index(target.temporary(), index->vertices, index->triangles, names)};
  target.commit();
  return copy;
}

}  // namespace orbweave
