#include "io/clouds/e57/e57_pages.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "io/clouds/e57/crc32c.h"
#include "io/error.h"
#include "io/streams/byte_reader.h"
#include "io/text/little_endian.h"

namespace orbweave {
namespace {

constexpr std::size_t kHeaderBytes = 48;
constexpr std::size_t kChecksumBytes = 4;
constexpr std::string_view kSignature = "ASTM-E57";
// The standard writes 1024. Larger pages are read up to a bound that keeps a window small.
constexpr std::uint64_t kSmallestPage = 64;
constexpr std::uint64_t kLargestPage = std::uint64_t{1} << 20;
constexpr std::uint64_t kWindowBytes = std::uint64_t{1} << 16;
constexpr std::size_t kWindows = 16;

using HeaderBytes = std::array<std::byte, kHeaderBytes>;

void check_signature(const HeaderBytes& bytes, const std::string& name) {
  const std::string_view signature(reinterpret_cast<const char*>(bytes.data()), kSignature.size());
  if (signature != kSignature)
    throw_bad_input("this is no E57 file", {.file = name,
                                            .place = "byte 0",
                                            .found = excerpt(signature),
                                            .expected = "the signature \"ASTM-E57\""});
  const auto major = load_little<std::uint32_t>(bytes.data() + 8);
  if (major != 1)
    throw_bad_input("unknown version of E57", {.file = name,
                                               .place = "byte 8",
                                               .found = "version " + std::to_string(major),
                                               .expected = "version 1"});
}

void check_sizes(const E57Header& header, const RandomAccess& file) {
  const std::uint64_t page = header.page_bytes;
  if (page < kSmallestPage || page > kLargestPage || page % 4 != 0)
    throw_bad_input("the E57 header has an impossible page size",
                    {.file = file.name(),
                     .place = "byte 40",
                     .found = std::to_string(page) + " bytes",
                     .expected = "1024 bytes"});
  if (header.physical_bytes > file.size())
    throw_bad_input("the file is shorter than its E57 header says",
                    {.file = file.name(),
                     .place = "byte 16",
                     .found = std::to_string(file.size()) + " bytes",
                     .expected = std::to_string(header.physical_bytes) + " bytes",
                     .advice = "Copy or download the file again."});
  if (header.physical_bytes == 0 || header.physical_bytes % page != 0)
    throw_bad_input("the length in the E57 header is no whole number of pages",
                    {.file = file.name(),
                     .place = "byte 16",
                     .found = std::to_string(header.physical_bytes) + " bytes",
                     .expected = "a multiple of " + std::to_string(page)});
}

}  // namespace

E57Pages::E57Pages(std::unique_ptr<RandomAccess> file) : file_(std::move(file)) {
  HeaderBytes bytes;
  if (file_->size() < kHeaderBytes)
    throw_bad_input("the file is too short for an E57 header",
                    {.file = name(),
                     .found = std::to_string(file_->size()) + " bytes",
                     .expected = std::to_string(kHeaderBytes) + " bytes or more"});
  file_->read(0, bytes);
  check_signature(bytes, name());
  const auto field = [&](std::size_t at) { return load_little<std::uint64_t>(bytes.data() + at); };
  header_ = {.physical_bytes = field(16),
             .xml_offset = field(24),
             .xml_bytes = field(32),
             .page_bytes = field(40)};
  check_sizes(header_, *file_);
  payload_ = header_.page_bytes - kChecksumBytes;
  pages_ = header_.physical_bytes / header_.page_bytes;
  window_at(0);  // what the header says is believed only once its page is checked
}

std::uint64_t E57Pages::to_logical(std::uint64_t physical, const std::string& what) const {
  const std::uint64_t in_page = physical % header_.page_bytes;
  const bool is_inside = physical >= kHeaderBytes && physical < header_.physical_bytes;
  if (!is_inside || in_page >= payload_)
    throw_bad_input("the offset of " + what +
                        (is_inside ? " points into a checksum" : " points outside of the data"),
                    {.file = name(),
                     .found = "byte " + std::to_string(physical),
                     .expected = "a byte from " + std::to_string(kHeaderBytes) + " to " +
                                 std::to_string(header_.physical_bytes - kChecksumBytes - 1)});
  return physical / header_.page_bytes * payload_ + in_page;
}

std::string E57Pages::place(std::uint64_t logical) const {
  return "byte " + std::to_string(to_physical(logical));
}

void E57Pages::read(std::uint64_t logical, std::span<std::byte> out) {
  if (logical > logical_bytes() || out.size() > logical_bytes() - logical)
    throw_bad_input("the E57 file ends too early",
                    {.file = name(),
                     .place = "byte " + std::to_string(to_physical(logical)),
                     .found = "its end at byte " + std::to_string(header_.physical_bytes),
                     .expected = std::to_string(out.size()) + " bytes of data more"});
  while (!out.empty()) {
    const Window& window = window_at(logical);
    const auto skipped = static_cast<std::size_t>(logical - window.begin);
    const std::size_t count = std::min(out.size(), window.bytes.size() - skipped);
    std::memcpy(out.data(), window.bytes.data() + skipped, count);
    out = out.subspan(count);
    logical += count;
  }
}

/// The window that holds a byte of the file; where none does, in place of the one that has not been
/// used for longest.
const E57Pages::Window& E57Pages::window_at(std::uint64_t logical) {
  for (Window& window : windows_)
    if (logical >= window.begin && logical - window.begin < window.bytes.size()) {
      window.last_use = ++uses_;
      return window;
    }
  if (windows_.size() < kWindows) windows_.emplace_back();
  const auto used_before = [](const Window& a, const Window& b) { return a.last_use < b.last_use; };
  Window& oldest = *std::min_element(windows_.begin(), windows_.end(), used_before);
  load(logical / payload_, oldest);
  oldest.last_use = ++uses_;
  return oldest;
}

void E57Pages::load(std::uint64_t page, Window& window) {
  const std::uint64_t per_window = std::max<std::uint64_t>(kWindowBytes / header_.page_bytes, 1);
  page = page / per_window * per_window;  // windows never overlap
  const std::uint64_t count = std::min(per_window, pages_ - page);
  window.bytes.clear();  // nothing unchecked is left behind when a check below throws
  window.begin = page * payload_;
  raw_.resize(static_cast<std::size_t>(count * header_.page_bytes));
  file_->read(page * header_.page_bytes, raw_);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto bytes =
        std::span<const std::byte>(raw_).subspan(i * header_.page_bytes, header_.page_bytes);
    check_page(page + i, bytes);
    window.bytes.insert(window.bytes.end(), bytes.begin(), bytes.end() - kChecksumBytes);
  }
}

void E57Pages::check_page(std::uint64_t page, std::span<const std::byte> bytes) const {
  const std::uint32_t computed = crc32c(bytes.first(bytes.size() - kChecksumBytes));
  // Alone among the integers of the format, the checksum is stored most significant byte first.
  std::uint32_t stored = 0;
  for (const std::byte byte : bytes.last(kChecksumBytes))
    stored = stored << 8 | static_cast<std::uint32_t>(byte);
  if (stored == computed) return;
  const std::uint64_t begin = page * header_.page_bytes;
  throw_bad_input("the file is damaged: the checksum of page " + std::to_string(page) + " (bytes " +
                      std::to_string(begin) + " to " +
                      std::to_string(begin + header_.page_bytes - 1) + ") is wrong",
                  {.file = name(),
                   .place = "byte " + std::to_string(begin),
                   .found = "CRC-32C " + std::to_string(computed),
                   .expected = std::to_string(stored),
                   .advice = "Copy or download the file again."});
}

}  // namespace orbweave
