#include "io/job/output_origin.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <charconv>
#include <cmath>

#include "io/error.h"
#include "io/job/setting.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr double kMovePerSpacing = 1e-3;      // what does not matter
constexpr double kMostMovePerSpacing = 1e-1;  // more than that damages the surface
constexpr double kMovePerExtent = 1e-6;       // where the spacing is not known
constexpr double kMostMovePerExtent = 1e-4;   // likewise

/// Half the distance of the numbers of so many binary digits around a number.
double half_step(double number, int digits) {
  if (number == 0.0 || !std::isfinite(number)) return number;
  int exponent = 0;
  std::frexp(number, &exponent);  // number < 2^exponent
  return std::ldexp(1.0, exponent - digits - 1);
}

/// The largest coordinate of the file on an axis, without its sign.
double largest_on_axis(const Box& bounds, Vec3 origin, int axis) {
  return std::max(std::abs(bounds.min[axis] - origin[axis]),
                  std::abs(bounds.max[axis] - origin[axis]));
}

/// The steps of floats end at the smallest of them.
double axis_move(const Box& bounds, Vec3 origin, int axis) {
  const double largest = largest_on_axis(bounds, origin, axis);
  if (largest == 0.0) return 0.0;
  return std::max(half_step(largest, FLT_MANT_DIG), 0.5 * FLT_TRUE_MIN);
}

bool exceeds_floats(const Box& bounds, Vec3 origin) {
  for (int axis = 0; axis < 3; ++axis) {
    const double largest = largest_on_axis(bounds, origin, axis);
    if (std::isfinite(largest) && largest > FLT_MAX) return true;
  }
  return false;
}

/// Doubles lose nothing on the axes where the origin is 0.
double largest_double_move(const Box& bounds, Vec3 origin) {
  Vec3 move;
  for (int axis = 0; axis < 3; ++axis)
    if (origin[axis] != 0.0)
      move[axis] = half_step(largest_on_axis(bounds, origin, axis), DBL_MANT_DIG);
  return norm(move);
}

/// A multiple of 10^exponent, written with as few digits.
double rounded(double value, int exponent) {
  double power = 1.0;
  for (int i = 0; i < std::abs(exponent); ++i) power *= 10.0;
  return exponent >= 0 ? std::round(value / power) * power : std::round(value * power) / power;
}

/// The decimal exponent of a length: 3 of 1500.
int decimal_exponent(double length) {
  int exponent = 0;
  double power = 1.0;
  for (; power * 10.0 <= length; power *= 10.0) ++exponent;
  for (; power > length && exponent > -300; power /= 10.0) --exponent;
  return exponent;
}

double largest_harmless_move(const Box& bounds, double spacing) {
  return spacing > 0.0 ? kMovePerSpacing * spacing : kMovePerExtent * bounds.largest_extent();
}

/// Close to the middle, with so few digits that the coordinates get longer by a tenth at most;
/// whole where that does no harm.
Vec3 round_origin(const Box& bounds, double harmless) {
  const int exponent = decimal_exponent(bounds.largest_extent()) - 1;
  const Vec3 middle = bounds.min + bounds.extent() * 0.5;
  Vec3 origin;
  for (int axis = 0; axis < 3; ++axis) {
    // Three axes together move a vertex by up to the root of 3 as far.
    constexpr double kShareOfAxis = 0.5;
    if (axis_move(bounds, {}, axis) <= kShareOfAxis * harmless) continue;
    origin[axis] = rounded(middle[axis], std::max(exponent, 0));
    if (exponent < 0 && axis_move(bounds, origin, axis) > kShareOfAxis * harmless)
      origin[axis] = rounded(middle[axis], exponent);
  }
  return origin;
}

std::string move_text(const OutputOrigin& chosen) {
  std::string text = "up to " + format_number(chosen.largest_move);
  if (chosen.spacing > 0.0)
    text += ", which is " + format_number(chosen.largest_move / chosen.spacing) +
            " of the point spacing";
  return text;
}

std::string numbers_of(const OutputOrigin& chosen) { return chosen.floats ? "floats" : "doubles"; }

std::string way_out(const Job& job, const OutputOrigin& chosen) {
  const std::string auto_rule = setting(job, "output.origin", "auto");
  if (!chosen.floats) return auto_rule + " keeps the coordinates as they are";
  if (job.output.origin_rule == OriginRule::kAuto) return "A .ply or .obj file keeps doubles";
  return auto_rule +
         " counts them from a place among the points; a .ply or .obj file keeps doubles";
}

[[noreturn]] void refuse(const Job& job, const OutputOrigin& chosen, const std::string& expected) {
  throw_usage("the " + numbers_of(chosen) + " of the mesh file would move its vertices",
              {.file = job.output.mesh,
               .place = setting_name(job, "output.origin"),
               .found = move_text(chosen),
               .expected = expected,
               .advice = way_out(job, chosen)});
}

/// The shortest text without an exponent that reads back as the number.
std::string plain_text(double number) {
  std::array<char, 400> text{};  // of the largest number, too
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
  return {text.data(), end};
}

}  // namespace

double largest_float_move(const Box& bounds, Vec3 origin) {
  if (bounds.empty()) return 0.0;
  return norm(Vec3{axis_move(bounds, origin, 0), axis_move(bounds, origin, 1),
                   axis_move(bounds, origin, 2)});
}

OutputOrigin output_origin(const OutputOptions& output, bool floats, const Box& bounds,
                           double spacing) {
  OutputOrigin chosen{.origin = {},
                      .floats = floats,
                      .largest_move = 0.0,
                      .spacing = spacing,
                      .extent = bounds.largest_extent()};
  if (output.origin_rule == OriginRule::kGiven) chosen.origin = output.origin;
  if (bounds.empty()) return chosen;
  const double harmless = largest_harmless_move(bounds, spacing);
  if (floats && output.origin_rule == OriginRule::kAuto &&
      largest_float_move(bounds, {}) > harmless)
    chosen.origin = round_origin(bounds, harmless);
  chosen.largest_move = floats ? largest_float_move(bounds, chosen.origin)
                               : largest_double_move(bounds, chosen.origin);
  chosen.exceeds_floats = floats && exceeds_floats(bounds, chosen.origin);
  return chosen;
}

std::string check_output_origin(const Job& job, const OutputOrigin& chosen) {
  if (chosen.exceeds_floats)
    throw_usage("the floats of the mesh file hold no coordinates of this size",
                {.file = job.output.mesh,
                 .found = "an extent of " + format_number(chosen.extent),
                 .expected = "coordinates up to " + format_number(FLT_MAX),
                 .advice = "A .ply or .obj file keeps doubles"});
  if (chosen.spacing > 0.0) {
    if (chosen.largest_move <= kMovePerSpacing * chosen.spacing) return {};
    const bool is_none = job.output.origin_rule == OriginRule::kNone;
    if (is_none || chosen.largest_move > kMostMovePerSpacing * chosen.spacing)
      refuse(job, chosen,
             std::string("at most ") + (is_none ? "a thousandth" : "a tenth") + " of the spacing " +
                 format_number(chosen.spacing));
    return "the " + numbers_of(chosen) + " of " + job.output.mesh + " move its vertices by " +
           move_text(chosen) + ". " + way_out(job, chosen);
  }
  const double most = kMostMovePerExtent * chosen.extent;
  const bool is_measured = std::isfinite(chosen.largest_move);  // a coordinate may be infinite
  if (chosen.largest_move > most && (job.output.origin_rule == OriginRule::kGiven ||
                                     (job.output.origin_rule == OriginRule::kAuto && is_measured)))
    refuse(job, chosen, "at most a ten-thousandth of the extent " + format_number(chosen.extent));
  return {};
}

std::string origin_text(Vec3 origin) {
  return plain_text(origin.x) + ", " + plain_text(origin.y) + ", " + plain_text(origin.z);
}

}  // namespace orbweave
