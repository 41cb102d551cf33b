#include "io/clouds/e57/e57_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/error.h"

namespace orbweave {
namespace {

using FieldNames = std::array<const char*, 3>;
constexpr FieldNames kCartesian = {"cartesianX", "cartesianY", "cartesianZ"};
constexpr FieldNames kSpherical = {"sphericalRange", "sphericalAzimuth", "sphericalElevation"};
constexpr FieldNames kNormal = {"nor:normalX", "nor:normalY", "nor:normalZ"};

enum class Role { kNumber, kSmall, kReturn, kColor, kTime };

/// A field of the standard, and the attribute it becomes.
struct Meaning {
  const char* field;
  const char* attribute;
  Role role;
};
constexpr std::array<Meaning, 10> kMeanings = {
    {{"intensity", "intensity", Role::kNumber},
     {"colorRed", "red", Role::kColor},
     {"colorGreen", "green", Role::kColor},
     {"colorBlue", "blue", Role::kColor},
     {"rowIndex", "row_index", Role::kNumber},
     {"columnIndex", "column_index", Role::kNumber},
     {"returnIndex", "return_number", Role::kReturn},
     {"returnCount", "number_of_returns", Role::kSmall},
     {"timeStamp", "gps_time", Role::kTime},
     {"las:classification", "classification", Role::kSmall}}};

std::optional<std::array<std::size_t, 3>> find_all(const E57Scan& scan, const FieldNames& names) {
  std::array<std::size_t, 3> found{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto index = scan.find(names[i]);
    if (!index || scan.fields[*index].kind == E57Kind::kString) return std::nullopt;
    found[i] = *index;
  }
  return found;
}

bool all_of_kind(const E57Scan& scan, const std::array<std::size_t, 3>& fields, E57Kind kind) {
  return std::all_of(fields.begin(), fields.end(),
                     [&](std::size_t field) { return scan.fields[field].kind == kind; });
}

/// The narrowest type that holds all integers from low to high.
ScalarType integer_type(std::int64_t low, std::int64_t high) {
  const auto fits = [&](auto example) {
    using Limits = std::numeric_limits<decltype(example)>;
    return low >= static_cast<std::int64_t>(Limits::min()) &&
           high <= static_cast<std::int64_t>(Limits::max());
  };
  if (fits(std::uint8_t{})) return ScalarType::kUint8;
  if (fits(std::int8_t{})) return ScalarType::kInt8;
  if (fits(std::uint16_t{})) return ScalarType::kUint16;
  if (fits(std::int16_t{})) return ScalarType::kInt16;
  if (fits(std::uint32_t{})) return ScalarType::kUint32;
  if (fits(std::int32_t{})) return ScalarType::kInt32;
  return ScalarType::kInt64;
}

/// Whether floats tell each value of a field from its neighbours: of integers those whose values
/// are at most 2^24 of their steps from 0.
bool fits_float(const E57Field& field) {
  if (field.kind == E57Kind::kFloat32 || field.kind == E57Kind::kFloat64)
    return field.kind == E57Kind::kFloat32;
  constexpr double kSteps = 1 << 24;
  const auto size_of_value = [&](std::int64_t integer) {
    return std::abs(static_cast<double>(integer) * field.scale + field.offset);
  };
  return std::max(size_of_value(field.minimum), size_of_value(field.maximum)) <=
         kSteps * std::abs(field.scale);
}

/// Holds the values of a field of all scans without loss.
ScalarType number_type(const std::vector<const E57Field*>& fields) {
  bool is_integer = true, is_float = true;
  std::int64_t low = std::numeric_limits<std::int64_t>::max();
  std::int64_t high = std::numeric_limits<std::int64_t>::min();
  for (const E57Field* field : fields) {
    is_integer = is_integer && field->kind == E57Kind::kInteger;
    is_float = is_float && fits_float(*field);
    low = std::min(low, field->minimum);
    high = std::max(high, field->maximum);
  }
  if (is_integer) return integer_type(low, high);
  return is_float ? ScalarType::kFloat32 : ScalarType::kFloat64;
}

/// The range of a colour: what the scan says, else what the field can hold; else 0 to 1, as usual
/// for floating point.
E57Limits color_range(const E57Scan& scan, std::size_t channel, const E57Field& field) {
  const std::optional<E57Limits>& told = scan.color_limits[channel];
  if (told && told->high > told->low && std::isfinite(told->high - told->low)) return *told;
  if (field.kind == E57Kind::kFloat32 || field.kind == E57Kind::kFloat64) return {0.0, 1.0};
  const auto value = [&](std::int64_t integer) {
    return static_cast<double>(integer) * field.scale + field.offset;
  };
  const E57Limits range = {value(field.minimum), value(field.maximum)};
  return range.high > range.low ? range : E57Limits{0.0, 255.0};
}

class Planner {
 public:
  Planner(const std::vector<E57Scan>& scans, const std::string& file) : all_(scans), file_(file) {
    for (std::size_t i = 0; i < scans.size(); ++i)
      if (scans[i].records != 0) counted_.push_back(i);
    // Scans without points have no say, unless there is nothing else.
    if (counted_.empty())
      for (std::size_t i = 0; i < scans.size(); ++i) counted_.push_back(i);
    layout_.scans.resize(scans.size());
  }

  E57Layout plan() {
    for (const std::size_t i : counted_) place(all_[i], layout_.scans[i]);
    plan_positions();
    plan_normals();
    const ScalarType color = color_type();
    for (const Meaning& meaning : kMeanings) plan_attribute(meaning, color);
    return std::move(layout_);
  }

 private:
  void place(const E57Scan& scan, E57ScanLayout& layout) const {
    const auto cartesian = find_all(scan, kCartesian);
    const auto spherical = find_all(scan, kSpherical);
    const auto position = cartesian ? cartesian : spherical;
    if (!position) {
      if (scan.records == 0) return;
      throw_bad_input("the points of " + scan.label + " have no position",
                      {.file = file_,
                       .expected = "the fields cartesianX, cartesianY and cartesianZ, or "
                                   "sphericalRange, sphericalAzimuth and sphericalElevation"});
    }
    layout.position = *position;
    layout.is_spherical = !cartesian;
    layout.invalid_state =
        scan.find(layout.is_spherical ? "sphericalInvalidState" : "cartesianInvalidState");
    const bool is_gridded = scan.find("rowIndex") && scan.find("columnIndex");
    layout.has_scanner = spherical || is_gridded || scan.is_moved();
  }

  void plan_positions() {
    const bool all_floats = std::all_of(counted_.begin(), counted_.end(), [&](std::size_t i) {
      const E57ScanLayout& layout = layout_.scans[i];
      return !layout.is_spherical && !all_[i].is_moved() && !all_[i].fields.empty() &&
             all_of_kind(all_[i], layout.position, E57Kind::kFloat32);
    });
    layout_.schema.position_type =
        all_floats && !counted_.empty() ? ScalarType::kFloat32 : ScalarType::kFloat64;
  }

  void plan_normals() {
    bool all_floats = true;
    for (const std::size_t i : counted_) {
      const auto normal = find_all(all_[i], kNormal);
      if (!normal) return;
      layout_.scans[i].normal = *normal;
      all_floats = all_floats && all_of_kind(all_[i], *normal, E57Kind::kFloat32);
    }
    layout_.schema.has_normals = !counted_.empty();
    if (!all_floats) layout_.schema.normal_type = ScalarType::kFloat64;
  }

  /// Eight bits where no scan has more, else sixteen.
  ScalarType color_type() const {
    constexpr std::array<const char*, 3> kChannels = {"colorRed", "colorGreen", "colorBlue"};
    for (const std::size_t i : counted_)
      for (std::size_t channel = 0; channel < kChannels.size(); ++channel) {
        const auto index = all_[i].find(kChannels[channel]);
        if (index && color_range(all_[i], channel, all_[i].fields[*index]).high > 255.0)
          return ScalarType::kUint16;
      }
    return ScalarType::kUint8;
  }

  void plan_attribute(const Meaning& meaning, ScalarType color) {
    std::vector<const E57Field*> fields;
    for (const std::size_t i : counted_) {
      const auto index = number_field(all_[i], meaning);
      if (index) fields.push_back(&all_[i].fields[*index]);
    }
    if (fields.empty()) return;
    const ScalarType type = attribute_type(meaning.role, color, fields);
    layout_.schema.attributes.push_back({meaning.attribute, type});
    for (const std::size_t i : counted_)
      layout_.scans[i].attributes.push_back(attribute_of(all_[i], meaning, type));
  }

  static ScalarType attribute_type(Role role, ScalarType color,
                                   const std::vector<const E57Field*>& fields) {
    switch (role) {
      case Role::kColor:
        return color;
      case Role::kReturn:
      case Role::kSmall:
        return ScalarType::kUint8;
      case Role::kTime:
        return ScalarType::kFloat64;
      case Role::kNumber:
        break;
    }
    return number_type(fields);
  }

  static std::optional<std::size_t> number_field(const E57Scan& scan, const Meaning& meaning) {
    const std::optional<std::size_t> index = scan.find(meaning.field);
    return index && scan.fields[*index].kind != E57Kind::kString ? index : std::nullopt;
  }

  static E57Attribute attribute_of(const E57Scan& scan, const Meaning& meaning, ScalarType type) {
    E57Attribute attribute{.field = number_field(scan, meaning), .type = type};
    if (!attribute.field) return attribute;
    if (meaning.role == Role::kReturn) attribute.to = 1.0 - scan.first_return;
    if (meaning.role == Role::kTime) attribute.to = scan.start_seconds;
    if (meaning.role == Role::kColor) scale_color(scan, meaning, attribute);
    return attribute;
  }

  /// Colours that fill their type already are left as they are.
  static void scale_color(const E57Scan& scan, const Meaning& meaning, E57Attribute& attribute) {
    const std::string_view name = meaning.attribute;
    const std::size_t channel = name == "red" ? 0 : name == "green" ? 1 : 2;
    const E57Limits range = color_range(scan, channel, scan.fields[*attribute.field]);
    const double brightest = attribute.type == ScalarType::kUint8 ? 255.0 : 65535.0;
    if (range.high == brightest && range.low >= 0.0) return;
    attribute.from = range.low;
    attribute.scale = brightest / (range.high - range.low);
  }

  const std::vector<E57Scan>& all_;
  const std::string& file_;
  std::vector<std::size_t> counted_;  ///< scans that have a say in the schema
  E57Layout layout_;
};

}  // namespace

E57Layout plan_e57_layout(const std::vector<E57Scan>& scans, const std::string& file) {
  return Planner(scans, file).plan();
}

}  // namespace orbweave
