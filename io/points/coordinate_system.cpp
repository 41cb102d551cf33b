#include "io/points/coordinate_system.h"

#include <proj.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>
#include <numbers>
#include <string_view>
#include <utility>

#include "io/text/lower_case.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// Longer texts are no coordinate systems.
constexpr std::size_t kLongestText = std::size_t{1} << 20;

struct DestroyContext {
  void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
};
struct DestroyObject {
  void operator()(PJ* object) const { proj_destroy(object); }
};
using Object = std::unique_ptr<PJ, DestroyObject>;
struct DestroyList {
  void operator()(PJ_OBJ_LIST* list) const { proj_list_destroy(list); }
};

/// What counts in a name: "WGS84/UTM zone 33N" is "WGS 84 / UTM zone 33N".
std::string letters_and_digits(std::string text) {
  std::erase_if(text, [](char c) {
    const bool is_ascii = static_cast<unsigned char>(c) < 128;
    return is_ascii && std::isalnum(static_cast<unsigned char>(c)) == 0;
  });
  return lower_case(text);
}

/// PROJ, silent and without the network. For one thread at a time.
class Proj {
 public:
  Proj() : context_(proj_context_create()) {
    proj_log_func(context_.get(), nullptr, [](void*, int, const char*) {});
    proj_context_set_enable_network(context_.get(), 0);
  }
  PJ_CONTEXT* context() const { return context_.get(); }

  bool has_database() const { return proj_context_get_database_path(context()) != nullptr; }

  /// What PROJ makes of a user's text; null: nothing, or a system whose name is merely like it.
  Object object(const std::string& text) const {
    Object found(proj_create(context(), text.c_str()));
    return found && is_meant(text, found.get()) ? std::move(found) : nullptr;
  }

  /// The coordinate reference system of a scan's text; null: none.
  Object system(const std::string& text) const {
    const bool may_be_one = is_wkt(text) || text.starts_with("EPSG:");
    if (!may_be_one || text.size() > kLongestText) return nullptr;
    Object known;
    if (is_reference(text) || is_listed(text)) known.reset(proj_create(context(), text.c_str()));
    if (known && proj_is_crs(known.get()) != 0) return known;
    // Heights of a code that PROJ does not know are heights of no known system.
    const std::size_t heights = is_wkt(text) ? std::string::npos : text.find('+');
    return heights == std::string::npos ? nullptr : system(text.substr(0, heights));
  }

  /// What x and y are in: of a system with heights its first part, of a bound one its source.
  Object level(const PJ* system) const { return part(system, 0); }
  /// What z is in; null: the system does not say.
  Object height(const PJ* system) const {
    return has_type(system, PJ_TYPE_COMPOUND_CRS) ? part(system, 1) : nullptr;
  }

  static bool has_type(const PJ* object, PJ_TYPE type) { return proj_get_type(object) == type; }

  /// The factor of an axis' unit: to metres, or to radians.
  std::optional<double> unit_factor(const PJ* system, int axis) const {
    const Object axes(proj_crs_get_coordinate_system(context(), system));
    double factor = 0.0;
    const bool is_told = axes && axis < proj_cs_get_axis_count(context(), axes.get()) &&
                         proj_cs_get_axis_info(context(), axes.get(), axis, nullptr, nullptr,
                                               nullptr, &factor, nullptr, nullptr, nullptr) != 0;
    if (!is_told || !std::isfinite(factor) || !(factor > 0.0)) return std::nullopt;
    return factor;
  }

  /// Whatever the order of their axes: files have x towards the east and y towards the north.
  bool are_equivalent(const PJ* a, const PJ* b) const {
    const Object east_first(proj_normalize_for_visualization(context(), a));
    const Object other(proj_normalize_for_visualization(context(), b));
    return proj_is_equivalent_to_with_ctx(context(), east_first ? east_first.get() : a,
                                          other ? other.get() : b,
                                          PJ_COMP_EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS) != 0;
  }

 private:
  /// Whether a text is no name: WKT, a code, a URN, a PROJ string.
  bool is_reference(const std::string& text) const {
    return text.find_first_of(":=") != std::string::npos ||
           proj_context_guess_wkt_dialect(context(), text.c_str()) != PJ_GUESSED_NOT_WKT;
  }

  /// Of a text that is no name, PROJ takes the only name that is like it: of "UCS" UCS-2000 of the
  /// Ukraine, of "Metric" the metric grid of Jamaica.
  bool is_meant(const std::string& text, const PJ* found) const {
    const char* const name = proj_get_name(found);
    return is_reference(text) || is_listed(text) ||
           (name != nullptr && letters_and_digits(text) == letters_and_digits(name));
  }

  /// Whether it is a name or another name of a system, or of two, "level + heights".
  bool is_listed(const std::string& text) const {
    constexpr std::string_view kPlus = " + ";
    const std::size_t plus = text.find(kPlus);
    const PJ_TYPE type = PJ_TYPE_CRS;
    const std::unique_ptr<PJ_OBJ_LIST, DestroyList> found(proj_create_from_name(
        context(), nullptr, text.substr(0, plus).c_str(), &type, 1, 0, 1, nullptr));
    if (!found || proj_list_get_count(found.get()) == 0) return false;
    return plus == std::string::npos || is_listed(text.substr(plus + kPlus.size()));
  }

  Object part(const PJ* system, int index) const {
    if (has_type(system, PJ_TYPE_BOUND_CRS)) return Object(proj_get_source_crs(context(), system));
    if (!has_type(system, PJ_TYPE_COMPOUND_CRS)) return Object(proj_clone(context(), system));
    Object found(proj_crs_get_sub_crs(context(), system, index));
    if (found && has_type(found.get(), PJ_TYPE_BOUND_CRS))
      return Object(proj_get_source_crs(context(), found.get()));
    return found;
  }

  std::unique_ptr<PJ_CONTEXT, DestroyContext> context_;
};

bool is_geographic_type(const PJ* system) {
  return Proj::has_type(system, PJ_TYPE_GEOGRAPHIC_2D_CRS) ||
         Proj::has_type(system, PJ_TYPE_GEOGRAPHIC_3D_CRS);
}

std::string code_of(const PJ* system) {
  const char* const authority = proj_get_id_auth_name(system, 0);
  const char* const code = proj_get_id_code(system, 0);
  return authority != nullptr && code != nullptr ? std::string(authority) + ":" + code : "";
}

/// Of a system of heights the codes of both its parts, where both are of EPSG.
std::string code_of(const Proj& proj, const PJ* system) {
  std::string code = code_of(system);
  if (!code.empty() || !Proj::has_type(system, PJ_TYPE_COMPOUND_CRS)) return code;
  const Object level = proj.level(system);
  const Object height = proj.height(system);
  if (!level || !height) return {};
  const std::string of_level = code_of(level.get());
  const std::string of_height = code_of(height.get());
  constexpr std::string_view kEpsg = "EPSG:";
  if (!of_level.starts_with(kEpsg) || !of_height.starts_with(kEpsg)) return {};
  return of_level + "+" + of_height.substr(kEpsg.size());
}

/// Version 1 is what most programs read; version 2 holds what version 1 cannot.
std::string wkt_of(const Proj& proj, const PJ* system) {
  for (const PJ_WKT_TYPE version : {PJ_WKT1_GDAL, PJ_WKT2_2019}) {
    const char* const options[] = {"MULTILINE=NO", nullptr};
    const char* const wkt = proj_as_wkt(proj.context(), system, version, options);
    if (wkt != nullptr) return wkt;
  }
  return {};
}

std::optional<Vec3> meters_per_unit(const Proj& proj, const PJ* system) {
  const Object level = proj.level(system);
  if (!level || is_geographic_type(level.get())) return std::nullopt;
  const std::optional<double> x = proj.unit_factor(level.get(), 0);
  const std::optional<double> y = proj.unit_factor(level.get(), 1);
  if (!x || !y) return std::nullopt;
  const Object height = proj.height(system);
  const std::optional<double> z =
      height ? proj.unit_factor(height.get(), 0) : proj.unit_factor(level.get(), 2);
  return Vec3{*x, *y, z.value_or(*x)};
}

/// Where a place lies, in degrees.
struct LongitudeLatitude {
  double longitude = 0.0;
  double latitude = 0.0;
};

/// By the projection alone: datums differ by less than what matters here.
std::optional<LongitudeLatitude> place_on_earth(const Proj& proj, const PJ* level, Vec3 point) {
  if (is_geographic_type(level)) return LongitudeLatitude{point.x, point.y};
  const Object base(proj_crs_get_geodetic_crs(proj.context(), level));
  if (!base) return std::nullopt;
  const Object as_given(
      proj_create_crs_to_crs_from_pj(proj.context(), level, base.get(), nullptr, nullptr));
  if (!as_given) return std::nullopt;
  const Object east_first(proj_normalize_for_visualization(proj.context(), as_given.get()));
  if (!east_first) return std::nullopt;
  const PJ_COORD place =
      proj_trans(east_first.get(), PJ_FWD, proj_coord(point.x, point.y, 0.0, 0.0));
  return LongitudeLatitude{place.xy.x, place.xy.y};
}

/// Where a system is used, in degrees; areas may cross the meridian of 180 degrees.
struct AreaOfUse {
  double west = 0.0, south = 0.0, east = 0.0, north = 0.0;

  double width() const { return east >= west ? east - west : east - west + 360.0; }
  /// Surveys end a little beyond the area that their system was made for.
  bool holds(LongitudeLatitude place) const {
    constexpr double kMarginDegrees = 0.5;
    constexpr double kMarginShare = 0.1;
    const double beyond_x = kMarginDegrees + kMarginShare * width();
    const double beyond_y = kMarginDegrees + kMarginShare * (north - south);
    const double from_west = std::remainder(place.longitude - (west + width() / 2.0), 360.0);
    return std::abs(from_west) <= width() / 2.0 + beyond_x && place.latitude >= south - beyond_y &&
           place.latitude <= north + beyond_y;
  }
};

std::optional<AreaOfUse> own_area(const Proj& proj, const PJ* system) {
  constexpr double kUnknown = -1000.0;
  AreaOfUse area;
  const char* name = nullptr;
  const bool is_told = proj_get_area_of_use(proj.context(), system, &area.west, &area.south,
                                            &area.east, &area.north, &name) != 0;
  return is_told && area.west > kUnknown ? std::optional(area) : std::nullopt;
}

/// WKT of version 1 has no place for the area, but a code to look it up by.
std::optional<AreaOfUse> area_of_use(const Proj& proj, const PJ* system) {
  if (const std::optional<AreaOfUse> area = own_area(proj, system)) return area;
  const Object by_code = proj.system(code_of(system));
  return by_code ? own_area(proj, by_code.get()) : std::nullopt;
}

std::string degrees_text(LongitudeLatitude place) {
  const auto rounded = [](double degrees) {
    return format_number(std::round(std::abs(degrees) * 100.0) / 100.0);
  };
  return rounded(place.longitude) + (place.longitude < 0.0 ? " W, " : " E, ") +
         rounded(place.latitude) + (place.latitude < 0.0 ? " S" : " N");
}

bool is_on_earth(LongitudeLatitude place) {
  return std::isfinite(place.longitude) && std::isfinite(place.latitude) &&
         std::abs(place.longitude) <= 360.0 && std::abs(place.latitude) <= 90.0;
}

}  // namespace

bool has_coordinate_database() { return Proj().has_database(); }

bool is_wkt(const std::string& text) {
  const std::size_t keyword =
      text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_");
  if (keyword == 0 || keyword == std::string::npos) return false;
  const std::size_t bracket = text.find_first_not_of(" \t\r\n", keyword);
  return bracket != std::string::npos && (text[bracket] == '[' || text[bracket] == '(');
}

std::optional<CoordinateSystem> known_coordinate_system(const std::string& text) {
  const Proj proj;
  const Object system = proj.system(text);
  if (!system) return std::nullopt;
  const Object level = proj.level(system.get());
  CoordinateSystem known;
  const char* const name = proj_get_name(system.get());
  known.name = name != nullptr ? name : "";
  known.code = code_of(proj, system.get());
  known.wkt = is_wkt(text) ? text : wkt_of(proj, system.get());
  known.is_geographic = level && is_geographic_type(level.get());
  known.meters_per_unit = meters_per_unit(proj, system.get());
  return known;
}

std::string system_of_text(const std::string& text) {
  constexpr std::string_view kEpsg = "EPSG:";
  if (text.empty() || is_wkt(text)) return text;
  if (lower_case(text.substr(0, kEpsg.size())) == lower_case(std::string(kEpsg)))
    return std::string(kEpsg) + text.substr(kEpsg.size());
  const Proj proj;
  // PROJ takes its own strings for transformations where they do not say otherwise.
  const std::string asked = text.starts_with('+') ? text + " +type=crs" : text;
  const Object system = proj.object(asked);
  if (!system || proj_is_crs(system.get()) == 0) return {};
  const std::string code = code_of(proj, system.get());
  return code.starts_with(kEpsg) ? code : wkt_of(proj, system.get());
}

SystemsDiffer systems_differ(const std::string& a, const std::string& b) {
  if (a == b) return SystemsDiffer::kNo;
  const Proj proj;
  const Object first = proj.system(a);
  const Object second = proj.system(b);
  if (!first || !second) return SystemsDiffer::kUnknown;
  const Object first_level = proj.level(first.get());
  const Object second_level = proj.level(second.get());
  if (!first_level || !second_level) return SystemsDiffer::kUnknown;
  if (!proj.are_equivalent(first_level.get(), second_level.get())) return SystemsDiffer::kYes;
  const Object first_height = proj.height(first.get());
  const Object second_height = proj.height(second.get());
  const bool heights_differ = first_height && second_height &&
                              !proj.are_equivalent(first_height.get(), second_height.get());
  return heights_differ ? SystemsDiffer::kYes : SystemsDiffer::kNo;
}

std::string objection_to_coordinates(const std::string& text, const Box& bounds) {
  if (bounds.empty()) return {};
  const Proj proj;
  const Object system = proj.system(text);
  const Object level = system ? proj.level(system.get()) : nullptr;
  if (!level) return {};
  const Vec3 center = bounds.min + bounds.extent() * 0.5;
  const std::optional<LongitudeLatitude> place = place_on_earth(proj, level.get(), center);
  if (!place) return {};
  if (!is_on_earth(*place)) return "they would lie nowhere on the earth";
  const std::optional<AreaOfUse> area = area_of_use(proj, level.get());
  if (!area || area->holds(*place)) return {};
  return "they would lie around " + degrees_text(*place) + ", and it is used between " +
         degrees_text({area->west, area->south}) + " and " +
         degrees_text({area->east, area->north});
}

namespace {

/// Degrees and metres above the ellipsoid of WGS 84 to Earth-centred, Earth-fixed metres.
Vec3 earth_place(LongitudeLatitude place, double height) {
  constexpr double kRadius = 6378137.0;
  constexpr double kFlattening = 1.0 / 298.257223563;
  constexpr double kSquaredEccentricity = kFlattening * (2.0 - kFlattening);
  constexpr double kRadians = std::numbers::pi / 180.0;
  const double latitude = place.latitude * kRadians;
  const double longitude = place.longitude * kRadians;
  const double sine = std::sin(latitude);
  const double normal = kRadius / std::sqrt(1.0 - kSquaredEccentricity * sine * sine);
  const double from_axis = (normal + height) * std::cos(latitude);
  return {from_axis * std::cos(longitude), from_axis * std::sin(longitude),
          (normal * (1.0 - kSquaredEccentricity) + height) * sine};
}

/// From a projected system to places on the Earth.
class ToEarth {
 public:
  ToEarth(const Proj& proj, const PJ* system, double meters_per_height)
      : meters_per_height_(meters_per_height) {
    const Object level = proj.level(system);
    const Object degrees(proj_create(proj.context(), "EPSG:4326"));
    if (!level || !degrees) return;
    const Object as_given(proj_create_crs_to_crs_from_pj(proj.context(), level.get(), degrees.get(),
                                                         nullptr, nullptr));
    if (as_given)
      transform_.reset(proj_normalize_for_visualization(proj.context(), as_given.get()));
  }
  bool is_known() const { return transform_ != nullptr; }
  Vec3 operator()(Vec3 p) const {
    const PJ_COORD at = proj_trans(transform_.get(), PJ_FWD, proj_coord(p.x, p.y, 0.0, 0.0));
    return earth_place({at.xy.x, at.xy.y}, p.z * meters_per_height_);
  }

 private:
  Object transform_;
  double meters_per_height_;
};

}  // namespace

std::string words_of_system(const std::string& text) {
  constexpr std::size_t kShownBytes = 60;
  const std::optional<CoordinateSystem> known = known_coordinate_system(text);
  if (!known) return text.substr(0, kShownBytes);
  const bool has_code = !known->code.empty() && known->code != known->name;
  return known->name + (has_code ? ", " + known->code : "");
}

std::optional<std::array<double, 16>> earth_from_local(const std::string& text, Vec3 origin) {
  const Proj proj;
  const std::optional<CoordinateSystem> known = known_coordinate_system(text);
  if (!known || known->is_geographic || !known->meters_per_unit) return std::nullopt;
  const Object system = proj.system(text);
  if (!system) return std::nullopt;
  const ToEarth place(proj, system.get(), known->meters_per_unit->z);
  if (!place.is_known()) return std::nullopt;
  std::array<double, 16> matrix{};
  const auto put_column = [&](std::size_t column, Vec3 v) {
    for (int row = 0; row < 3; ++row) matrix[4 * column + static_cast<std::size_t>(row)] = v[row];
  };
  for (int axis = 0; axis < 3; ++axis) {
    constexpr double kStepMeters = 100.0;
    const double step = kStepMeters / (*known->meters_per_unit)[axis];
    Vec3 ahead = origin;
    Vec3 behind = origin;
    ahead[axis] += step;
    behind[axis] -= step;
    put_column(static_cast<std::size_t>(axis), (0.5 / step) * (place(ahead) - place(behind)));
  }
  put_column(3, place(origin));
  matrix[15] = 1.0;
  const bool is_finite = std::all_of(matrix.begin(), matrix.end(),
                                     [](double number) { return std::isfinite(number); });
  return is_finite ? std::optional(matrix) : std::nullopt;
}

}  // namespace orbweave
