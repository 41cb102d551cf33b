#include "io/clouds/las/las_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "io/error.h"
#include "io/text/counted_noun.h"
#include "io/text/little_endian.h"
#include "io/text/quantity.h"
#include "io/text/text_fields.h"

namespace orbweave::las {
namespace {

constexpr std::array<std::uint16_t, 11> kFormatBytes = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
/// Header bytes by minor version.
constexpr std::array<std::uint16_t, 5> kHeaderBytes = {227, 227, 227, 235, 375};

// Places of the fields, in bytes from the file's start.
constexpr std::size_t kGlobalEncoding = 6;
constexpr std::size_t kVersionMajor = 24;
constexpr std::size_t kVersionMinor = 25;
constexpr std::size_t kSoftware = 58;
constexpr std::size_t kSoftwareBytes = 32;
constexpr std::size_t kHeaderSize = 94;
constexpr std::size_t kPointDataOffset = 96;
constexpr std::size_t kVariableRecords = 100;
constexpr std::size_t kPointFormat = 104;
constexpr std::size_t kRecordLength = 105;
constexpr std::size_t kLegacyPoints = 107;
constexpr std::size_t kScale = 131;
constexpr std::size_t kOffset = 155;
constexpr std::size_t kBounds = 179;  ///< largest and smallest x, then y, then z
constexpr std::size_t kExtendedRecordsOffset = 235;
constexpr std::size_t kExtendedRecords = 243;
constexpr std::size_t kPoints = 247;

constexpr std::uint16_t kWktBit = 1u << 4;
constexpr std::uint8_t kCompressedBit = 0x80;
constexpr std::uint8_t kOldCompressedBit = 0x40;

std::string place(std::size_t byte) { return "byte " + std::to_string(byte); }

class HeaderReader {
 public:
  explicit HeaderReader(const RandomAccess& file) : file_(file) {}

  Header read() {
    read_bytes();
    read_places();
    read_format();
    read_points();
    read_transform();
    read_bounds();
    const std::string software(reinterpret_cast<const char*>(bytes_.data()) + kSoftware,
                               kSoftwareBytes);
    header_.software = trimmed(software.substr(0, software.find('\0')));
    return header_;
  }

 private:
  template <class T>
  T at(std::size_t byte) const {
    return load_little<T>(bytes_.data() + byte);
  }

  [[noreturn]] void fail(const std::string& problem, std::size_t byte, const std::string& found,
                         const std::string& expected, const std::string& advice = {}) const {
    throw_bad_input(problem, {.file = file_.name(),
                              .place = place(byte),
                              .found = found,
                              .expected = expected,
                              .advice = advice});
  }

  /// Checks signature, version and length on the way.
  void read_bytes() {
    const std::size_t there =
        static_cast<std::size_t>(std::min<std::uint64_t>(file_.size(), kHeaderBytes.back()));
    file_.read(0, std::span(bytes_).first(there));
    constexpr std::string_view kSignature = "LASF";
    const std::string_view front(reinterpret_cast<const char*>(bytes_.data()), kSignature.size());
    if (there < kSignature.size() || front != kSignature)
      fail("this is no LAS file", 0, there < kSignature.size() ? "its end" : "something else",
           "\"LASF\"");
    need(kHeaderBytes.front(), there);
    const unsigned major = at<std::uint8_t>(kVersionMajor);
    header_.version_minor = at<std::uint8_t>(kVersionMinor);
    if (major != 1 || header_.version_minor >= kHeaderBytes.size())
      fail("a LAS version that is not known", kVersionMajor,
           std::to_string(major) + "." + std::to_string(header_.version_minor), "1.0 to 1.4");
    need(kHeaderBytes[header_.version_minor], there);
  }

  void need(std::size_t bytes, std::size_t there) const {
    if (there < bytes)
      fail("the file ends within the LAS header", there, "its end",
           std::to_string(bytes) + " bytes", "Copy or download the file again.");
  }

  void read_places() {
    header_.says_wkt = (at<std::uint16_t>(kGlobalEncoding) & kWktBit) != 0;
    header_.header_bytes = at<std::uint16_t>(kHeaderSize);
    const std::uint16_t least = kHeaderBytes[header_.version_minor];
    if (header_.header_bytes < least)
      fail("the LAS header says that it is shorter than its version needs", kHeaderSize,
           std::to_string(header_.header_bytes) + " bytes",
           "at least " + std::to_string(least) + " for version 1." +
               std::to_string(header_.version_minor));
    header_.variable_records = at<std::uint32_t>(kVariableRecords);
    header_.point_data_offset = at<std::uint32_t>(kPointDataOffset);
    if (header_.point_data_offset < header_.header_bytes ||
        header_.point_data_offset > file_.size())
      fail("the points cannot begin where the LAS header says", kPointDataOffset,
           place(header_.point_data_offset),
           "one from the header's end, " + std::to_string(header_.header_bytes) +
               ", to the file's end, " + std::to_string(file_.size()));
    if (header_.version_minor < 4) return;
    header_.extended_records_offset = at<std::uint64_t>(kExtendedRecordsOffset);
    header_.extended_records = at<std::uint32_t>(kExtendedRecords);
  }

  void read_format() {
    const unsigned stored = at<std::uint8_t>(kPointFormat);
    if ((stored & kOldCompressedBit) != 0)
      fail("points in a compression that was given up before LAZ was published", kPointFormat,
           std::to_string(stored), "0 to 10, or 128 to 138 for LAZ");
    header_.is_compressed = (stored & kCompressedBit) != 0;
    header_.point_format = static_cast<std::uint8_t>(stored & 0x3fu);
    if (header_.point_format >= kFormatBytes.size())
      fail("a LAS point format that is not known", kPointFormat,
           std::to_string(header_.point_format), "0 to 10");
    header_.record_bytes = at<std::uint16_t>(kRecordLength);
    const std::uint16_t least = point_format_bytes(header_.point_format);
    if (header_.record_bytes < least)
      fail("the points are shorter than their format", kRecordLength,
           std::to_string(header_.record_bytes) + " bytes",
           "at least " + std::to_string(least) + " for point format " +
               std::to_string(header_.point_format));
  }

  void read_points() {
    header_.points = at<std::uint32_t>(kLegacyPoints);
    std::size_t byte = kLegacyPoints;
    // The legacy count must be 0 or the same; writers that fill in nothing but it are met too.
    if (header_.version_minor >= 4 && at<std::uint64_t>(kPoints) != 0) {
      byte = kPoints;
      header_.points = at<std::uint64_t>(kPoints);
    }
    if (header_.is_compressed) return;  // how many fit is known by who decompresses
    const std::uint64_t room = file_.size() - header_.point_data_offset;
    const std::uint64_t fit = room / header_.record_bytes;
    if (header_.points > fit)
      fail(
          "the file is too short for the points that its LAS header counts", byte,
          "room for " + std::to_string(fit) + " (" + std::to_string(room) + " bytes from byte " +
              std::to_string(header_.point_data_offset) + " on)",
          counted_points(header_.points) + " of " + std::to_string(header_.record_bytes) + " bytes",
          "Copy or download the file again.");
  }

  void read_transform() {
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t skip = static_cast<std::size_t>(axis) * sizeof(double);
      const std::string name(1, "xyz"[axis]);
      header_.scale[axis] = at<double>(kScale + skip);
      header_.offset[axis] = at<double>(kOffset + skip);
      if (header_.points == 0) continue;
      if (!std::isfinite(header_.scale[axis]) || header_.scale[axis] == 0.0)
        fail("the scale of " + name + " gives no coordinates", kScale + skip,
             format_exact(header_.scale[axis]), "a number other than 0");
      if (!std::isfinite(header_.offset[axis]))
        fail("the offset of " + name + " gives no coordinates", kOffset + skip,
             format_exact(header_.offset[axis]), "a number");
    }
  }

  void read_bounds() {
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t at_axis = kBounds + static_cast<std::size_t>(axis) * 2 * sizeof(double);
      header_.bounds.max[axis] = at<double>(at_axis);
      header_.bounds.min[axis] = at<double>(at_axis + sizeof(double));
    }
  }

  const RandomAccess& file_;
  std::array<std::byte, kHeaderBytes.back()> bytes_{};
  Header header_;
};

}  // namespace

std::uint16_t point_format_bytes(std::uint8_t format) { return kFormatBytes.at(format); }

Header read_header(const RandomAccess& file) { return HeaderReader(file).read(); }

}  // namespace orbweave::las
