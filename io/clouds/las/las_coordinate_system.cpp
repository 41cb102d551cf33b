#include "io/clouds/las/las_coordinate_system.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "io/points/coordinate_system.h"
#include "io/points/length_units.h"
#include "io/text/little_endian.h"

namespace orbweave::las {
namespace {

constexpr std::uint16_t kAsciiKeys = 34737;
constexpr std::uint16_t kModelType = 1024;
constexpr std::uint16_t kCitation = 1026;
constexpr std::uint16_t kGeographic = 2048;
constexpr std::uint16_t kGeographicCitation = 2049;
constexpr std::uint16_t kProjected = 3072;
constexpr std::uint16_t kProjectedCitation = 3073;
constexpr std::uint16_t kProjectedUnit = 3076;
constexpr std::uint16_t kVertical = 4096;
constexpr std::uint16_t kVerticalUnit = 4099;
constexpr std::uint16_t kModelProjected = 1;
/// Codes below are obsolete or reserved, above it user-defined and private.
constexpr std::uint16_t kFirstEpsgCode = 1024;
constexpr std::uint16_t kLastEpsgCode = 32766;

bool is_blank(char c) { return static_cast<unsigned char>(c) <= ' '; }

/// Up to the first NUL, without the blanks around.
std::string_view trimmed(std::string_view text) {
  text = text.substr(0, text.find('\0'));
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  return text;
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Some files hold a placeholder instead of WKT.
std::string wkt_text(std::span<const std::byte> payload) {
  std::string text(trimmed(text_of(payload)));
  return is_wkt(text) ? text : std::string();
}

/// The GeoTIFF keys of a file.
class GeoKeys {
 public:
  GeoKeys(std::span<const std::byte> directory, std::span<const std::byte> ascii)
      : directory_(directory), ascii_(text_of(ascii)) {}

  /// The value of a key that holds a short itself.
  std::optional<std::uint16_t> code(std::uint16_t id) const {
    const std::byte* key = find(id);
    if (key == nullptr || load_little<std::uint16_t>(key + 2) != 0) return {};
    return load_little<std::uint16_t>(key + 6);
  }

  /// The text of a key that points into the ascii record; its end is marked by '|'.
  std::string text(std::uint16_t id) const {
    const std::byte* key = find(id);
    if (key == nullptr || load_little<std::uint16_t>(key + 2) != kAsciiKeys) return {};
    const std::size_t first = load_little<std::uint16_t>(key + 6);
    if (first >= ascii_.size()) return {};
    std::string_view part = ascii_.substr(first, load_little<std::uint16_t>(key + 4));
    while (!part.empty() && (is_blank(part.back()) || part.back() == '|')) part.remove_suffix(1);
    std::string words(trimmed(part));
    std::replace_if(words.begin(), words.end(), is_blank, ' ');
    return words;
  }

 private:
  static constexpr std::size_t kEntryBytes = 8;

  /// Four shorts: id, where the value is, its count, and the value or its place.
  const std::byte* find(std::uint16_t id) const {
    for (std::size_t at = kEntryBytes; at + kEntryBytes <= directory_.size(); at += kEntryBytes)
      if (load_little<std::uint16_t>(directory_.data() + at) == id) return directory_.data() + at;
    return nullptr;
  }

  std::span<const std::byte> directory_;
  std::string_view ascii_;
};

std::string epsg_name(std::optional<std::uint16_t> code) {
  if (!code || *code < kFirstEpsgCode || *code > kLastEpsgCode) return {};
  return "EPSG:" + std::to_string(*code);
}

bool is_projected(const GeoKeys& keys) {
  return keys.code(kProjected).has_value() || keys.code(kModelType) == kModelProjected;
}

/// The code of a system of heights; 0: none is named. Earlier files name its datum, whose codes lie
/// 600 below. Codes from 5001 on stand for an ellipsoid, whose heights PROJ knows no code for. The
/// heights of NAVD88 have a code for each unit.
std::uint16_t height_code(const GeoKeys& keys) {
  constexpr std::uint16_t kFirstDatum = 5101, kLastDatum = 5106, kSystemsAboveDatums = 600;
  constexpr std::uint16_t kNavd88 = 5703, kNavd88SurveyFeet = 6360, kNavd88Feet = 8228;
  constexpr std::uint16_t kFoot = 9002, kSurveyFoot = 9003;
  std::uint16_t code = keys.code(kVertical).value_or(0);
  if (code >= kFirstDatum && code <= kLastDatum) code += kSystemsAboveDatums;
  if (code < kFirstDatum || code > kLastEpsgCode) return 0;
  const std::uint16_t unit = keys.code(kVerticalUnit).value_or(0);
  if (code == kNavd88 && unit == kSurveyFoot) return kNavd88SurveyFeet;
  return code == kNavd88 && unit == kFoot ? kNavd88Feet : code;
}

/// The code of the coordinates' own system: what a projection is based on does not count.
std::string epsg_of(const GeoKeys& keys) {
  std::string code = epsg_name(keys.code(is_projected(keys) ? kProjected : kGeographic));
  const std::uint16_t height = height_code(keys);
  return code.empty() || height == 0 ? code : code + "+" + std::to_string(height);
}

std::string citation_of(const GeoKeys& keys) {
  std::string words = keys.text(is_projected(keys) ? kProjectedCitation : kGeographicCitation);
  return words.empty() ? keys.text(kCitation) : words;
}

/// Universal Transverse Mercator on WGS 84, NAD83 and ETRS89 is in metres.
bool is_utm(std::uint16_t epsg) {
  return (epsg >= 32601 && epsg <= 32660) || (epsg >= 32701 && epsg <= 32760) ||
         (epsg >= 26901 && epsg <= 26923) || (epsg >= 25828 && epsg <= 25838);
}

std::optional<double> unit_in(const GeoKeys& keys, std::uint16_t id) {
  const std::optional<std::uint16_t> code = keys.code(id);
  return code ? meters_per_epsg_unit(*code) : std::nullopt;
}

/// As the system of this code has it.
std::optional<Vec3> unit_of_code(const std::string& epsg) {
  const auto known = epsg.empty() ? std::nullopt : known_coordinate_system(epsg);
  return known ? known->meters_per_unit : std::nullopt;
}

/// What the keys say themselves comes first: it needs no database.
std::optional<Vec3> meters_per_unit(const GeoKeys& keys) {
  if (!is_projected(keys)) return std::nullopt;
  std::optional<double> level = unit_in(keys, kProjectedUnit);
  std::optional<double> height = unit_in(keys, kVerticalUnit);
  const bool says_unit = keys.code(kProjectedUnit).has_value();
  if (!says_unit && is_utm(keys.code(kProjected).value_or(0))) level = 1.0;
  const bool asks_for_height = !height && height_code(keys) != 0;
  if ((!says_unit && !level) || asks_for_height) {
    const std::optional<Vec3> of_code = unit_of_code(epsg_of(keys));
    if (!says_unit && !level && of_code) level = of_code->x;
    if (asks_for_height && of_code) height = of_code->z;
  }
  if (!level) return std::nullopt;
  return Vec3{*level, *level, height.value_or(*level)};
}

/// What the records of a file say of its coordinates.
struct SystemRecords {
  SystemRecords(const RandomAccess& file, const VariableRecords& records)
      : wkt(wkt_text(read_payload(file, records.wkt))),
        directory(read_payload(file, records.geo_keys)),
        ascii(read_payload(file, records.geo_ascii)) {}

  GeoKeys keys() const { return {directory, ascii}; }

  std::string wkt;
  std::vector<std::byte> directory, ascii;
};

}  // namespace

std::string coordinate_system(const RandomAccess& file, const VariableRecords& records,
                              bool says_wkt) {
  const SystemRecords system(file, records);
  if (says_wkt && !system.wkt.empty()) return system.wkt;
  std::string epsg = epsg_of(system.keys());
  if (!epsg.empty()) return epsg;
  return system.wkt.empty() ? citation_of(system.keys()) : system.wkt;
}

std::optional<Vec3> meters_per_unit(const RandomAccess& file, const VariableRecords& records,
                                    bool says_wkt) {
  const SystemRecords system(file, records);
  if (says_wkt && !system.wkt.empty()) return orbweave::meters_per_unit(system.wkt);
  const std::optional<Vec3> unit = meters_per_unit(system.keys());
  return unit ? unit : orbweave::meters_per_unit(system.wkt);
}

}  // namespace orbweave::las
