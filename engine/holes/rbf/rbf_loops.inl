// Loops over centres, four at once, for the machine that the including unit is compiled for. No
// unit of this file may use anything that is shared with units compiled for other machines.

#include "engine/geometry/lanes.h"
#include "engine/holes/rbf/cholesky.inl"
#include "engine/holes/rbf/rbf_loops.h"

namespace orbweave {
namespace {

using FourBits = unsigned long long __attribute__((vector_size(32)));

// Added to a distance it changes nothing but 0, which then has a finite logarithm and inverse to
// be multiplied by 0.
constexpr double kTiny = 0x1p-1022;

/// As rbf_log, of each lane.
inline Four logarithm(Four x) {
  const unsigned long long root_half = 0x3fe6a09e667f3bcd, one = 0x3ff0000000000000,
                           two52 = 0x4330000000000000, fraction = 0x000fffffffffffff;
  const FourBits bits = reinterpret_cast<FourBits>(x) + (one - root_half);
  const FourBits exponent = bits >> 52;
  const Four k = reinterpret_cast<Four>(exponent | two52) - (0x1p52 + 1023.0);
  const Four m = reinterpret_cast<Four>((bits & fraction) + root_half);
  const Four s = (m - 1.0) / (m + 1.0);
  const Four t = s * s;
  Four series = 1.0 / 19.0 + t * (1.0 / 21.0);
  series = 1.0 / 15.0 + t * (1.0 / 17.0 + t * series);
  series = 1.0 / 11.0 + t * (1.0 / 13.0 + t * series);
  series = 1.0 / 7.0 + t * (1.0 / 9.0 + t * series);
  series = 1.0 / 3.0 + t * (1.0 / 5.0 + t * series);
  return k * 0x1.62e42fefa39efp-1 + 2.0 * (s + s * (t * series));
}

struct PlaneBiharmonic {
  static Four phi(Four q) { return 0.5 * q * logarithm(q + kTiny); }
  static void phi_and_slope(Four q, Four& phi, Four& slope) {
    const Four half_log = 0.5 * logarithm(q + kTiny);
    phi = q * half_log;
    slope = half_log + 0.5;
  }
};

struct PlaneTriharmonic {
  static Four phi(Four q) { return -0.5 * q * q * logarithm(q + kTiny); }
  static void phi_and_slope(Four q, Four& phi, Four& slope) {
    const Four log = logarithm(q + kTiny);
    phi = -0.5 * q * q * log;
    slope = -q * (log + 0.5);
  }
};

struct SpaceBiharmonic {
  static Four phi(Four q) { return -square_root(q); }
  static void phi_and_slope(Four q, Four& phi, Four& slope) {
    const Four r = square_root(q);
    phi = -r;
    slope = -0.5 / (r + kTiny);
  }
};

struct SpaceTriharmonic {
  static Four phi(Four q) { return q * square_root(q); }
  static void phi_and_slope(Four q, Four& phi, Four& slope) {
    const Four r = square_root(q);
    phi = q * r;
    slope = 1.5 * r;
  }
};

/// The first lanes from memory, the others 0.
inline Four load_some(const double* from, std::size_t count) {
  Four v = all(0.0);
  for (std::size_t i = 0; i < count; ++i) v[i] = from[i];
  return v;
}
inline void store_some(double* to, Four v, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] = v[i];
}

template <class Form>
void kernel_of(double* squared, std::size_t count) {
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) store(squared + i, Form::phi(load(squared + i)));
  if (i < count) store_some(squared + i, Form::phi(load_some(squared + i, count - i)), count - i);
}

/// A place, and its squared distances from centres.
struct Place {
  explicit Place(const double place[3]) : x(all(place[0])), y(all(place[1])), z(all(place[2])) {}
  Four squared(Four cx, Four cy, Four cz) const {
    const Four dx = x - cx, dy = y - cy, dz = z - cz;
    return dx * dx + dy * dy + dz * dz;
  }
  Four x, y, z;
};

template <class Form>
void kernel_of_place(const double place[3], const RbfColumns& c, double* phi) {
  const Place at(place);
  std::size_t i = 0;
  for (; i + 4 <= c.count; i += 4)
    store(phi + i, Form::phi(at.squared(load(c.x + i), load(c.y + i), load(c.z + i))));
  const std::size_t rest = c.count - i;
  if (rest == 0) return;
  const Four squared =
      at.squared(load_some(c.x + i, rest), load_some(c.y + i, rest), load_some(c.z + i, rest));
  store_some(phi + i, Form::phi(squared), rest);
}

/// Sums in four lanes; what is left over of a multiple of four is added to the first.
struct LaneSums {
  Four value = all(0.0), slope = all(0.0), x = all(0.0), y = all(0.0), z = all(0.0);
};

inline void add_to_first(Four& sum, Four more, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) sum[0] += more[i];
}

template <class Form>
RbfSums sums_of_place(const double place[3], const RbfColumns& c) {
  const Place at(place);
  LaneSums sums;
  Four phi, slope;
  std::size_t i = 0;
  for (; i + 4 <= c.count; i += 4) {
    const Four x = load(c.x + i), y = load(c.y + i), z = load(c.z + i);
    const Four weights = load(c.weights + i);
    Form::phi_and_slope(at.squared(x, y, z), phi, slope);
    sums.value += phi * weights;
    const Four weighted = slope * weights;
    sums.slope += weighted;
    sums.x += weighted * x;
    sums.y += weighted * y;
    sums.z += weighted * z;
  }
  if (const std::size_t rest = c.count - i; rest > 0) {
    const Four x = load_some(c.x + i, rest), y = load_some(c.y + i, rest),
               z = load_some(c.z + i, rest);
    const Four weights = load_some(c.weights + i, rest);
    Form::phi_and_slope(at.squared(x, y, z), phi, slope);
    add_to_first(sums.value, phi * weights, rest);
    const Four weighted = slope * weights;
    add_to_first(sums.slope, weighted, rest);
    add_to_first(sums.x, weighted * x, rest);
    add_to_first(sums.y, weighted * y, rest);
    add_to_first(sums.z, weighted * z, rest);
  }
  return {sum_of(sums.value), sum_of(sums.slope), {sum_of(sums.x), sum_of(sums.y), sum_of(sums.z)}};
}

/// Calls visit with the form as a type.
template <class Visit>
auto with_form(RbfForm form, const Visit& visit) {
  switch (form) {
    case RbfForm::kPlaneBiharmonic:
      return visit(PlaneBiharmonic{});
    case RbfForm::kPlaneTriharmonic:
      return visit(PlaneTriharmonic{});
    case RbfForm::kSpaceBiharmonic:
      return visit(SpaceBiharmonic{});
    case RbfForm::kSpaceTriharmonic:
      break;
  }
  return visit(SpaceTriharmonic{});
}

void kernel(RbfForm form, double* squared, std::size_t count) {
  with_form(form, [&](auto of) { kernel_of<decltype(of)>(squared, count); });
}

void kernel_at(RbfForm form, const double place[3], const RbfColumns& centers, double* phi) {
  with_form(form, [&](auto of) { kernel_of_place<decltype(of)>(place, centers, phi); });
}

RbfSums sums_at(RbfForm form, const double place[3], const RbfColumns& centers) {
  return with_form(form, [&](auto of) { return sums_of_place<decltype(of)>(place, centers); });
}

constexpr RbfLoops kLoops = {kernel, kernel_at, sums_at, subtract, factor, solve, solve_transposed};

}  // namespace
}  // namespace orbweave
