#include "io/streams/random_access.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "io/error.h"
#include "io/system/file_descriptor.h"

namespace orbweave {
namespace {

class FileAccess final : public RandomAccess {
 public:
  /// Takes over the descriptor.
  FileAccess(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}
  ~FileAccess() override { ::close(descriptor_); }
  FileAccess(const FileAccess&) = delete;
  FileAccess& operator=(const FileAccess&) = delete;

  std::uint64_t size() const override { return size_; }
  const std::string& name() const override { return name_; }
  void set_size(std::uint64_t size) { size_ = size; }

 private:
  void read_inside(std::uint64_t offset, std::span<std::byte> out) const override {
    const std::optional<std::size_t> got = read_at(descriptor_, offset, out);
    if (got == out.size()) return;
    if (!got)
      throw_unread("cannot read the file",
                   {.file = name_, .place = "byte " + std::to_string(offset)}, errno);
    throw_bad_input("cannot read the file: it became shorter while it was read",
                    {.file = name_, .place = "byte " + std::to_string(offset + *got)});
  }

  int descriptor_;
  std::string name_;
  std::uint64_t size_ = 0;
};

class MemoryAccess final : public RandomAccess {
 public:
  MemoryAccess(std::span<const std::byte> bytes, std::string name)
      : bytes_(bytes), name_(std::move(name)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  const std::string& name() const override { return name_; }

 private:
  void read_inside(std::uint64_t offset, std::span<std::byte> out) const override {
    std::memcpy(out.data(), bytes_.data() + offset, out.size());
  }

  std::span<const std::byte> bytes_;
  std::string name_;
};

}  // namespace

void RandomAccess::read(std::uint64_t offset, std::span<std::byte> out) const {
  if (out.empty()) return;
  if (offset > size() || out.size() > size() - offset)
    throw_bad_input("the file is shorter than it says",
                    {.file = name(),
                     .place = "byte " + std::to_string(offset),
                     .found = "its end at byte " + std::to_string(size()),
                     .expected = std::to_string(out.size()) + " bytes more",
                     .advice = "Copy or download the file again."});
  read_inside(offset, out);
}

std::unique_ptr<RandomAccess> open_random_access(const std::filesystem::path& path) {
  const std::string name = path.string();
  if (path == "-")
    throw_usage("this format cannot be read from standard input",
                {.expected = "the name of a file"});
  if (is_read_once(name))  // before it is opened, which waits for a writer
    throw_bad_input("this format cannot be read from a pipe",
                    {.file = name,
                     .expected = "the name of a file on disk",
                     .advice = "Save it first, such as by: cat " + name + " > FILE"});
  const int descriptor = open_or_throw(name);
  // Owns the descriptor from here on, whatever the checks throw.
  auto file = std::make_unique<FileAccess>(descriptor, name);
  const auto size = checked_size(descriptor, name);
  if (!size) throw_bad_input("this format cannot be read from a device", {.file = name});
  if (starts_like_gzip(descriptor))
    throw_bad_input("this format cannot be read while it is compressed by gzip",
                    {.file = name, .advice = "Decompress it first: gunzip " + name});
  file->set_size(*size);
  return file;
}

std::unique_ptr<RandomAccess> memory_random_access(std::span<const std::byte> bytes,
                                                   std::string name) {
  return std::make_unique<MemoryAccess>(bytes, std::move(name));
}

}  // namespace orbweave
