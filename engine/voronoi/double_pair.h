// Numbers of some 106 bits as unevaluated sums of two doubles.
// Dekker, A Floating-Point Technique for Extending the Available Precision, 1971.
#pragma once

namespace orbweave::voronoi {

/// The value is high + low; low is at most half a unit in the last place of high.
struct DoublePair {
  double high = 0.0;
  double low = 0.0;
};

/// a + b with its rounding error, where |a| is at least |b| or a is 0. Exact.
inline DoublePair ordered_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

/// a + b with its rounding error. Exact.
inline DoublePair exact_sum(double a, double b) {
  const double sum = a + b;
  const double of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// A double as two of 26 bits, the products of which are exact.
inline DoublePair halves_of(double a) {
  constexpr double kSplit = 134217729.0;  // 2^27 + 1
  const double scaled = kSplit * a;
  const double high = scaled - (scaled - a);
  return {high, a - high};
}

/// a b with its rounding error. Exact where nothing overflows and nothing underflows.
inline DoublePair exact_product(double a, double b) {
  const double product = a * b;
  const DoublePair x = halves_of(a), y = halves_of(b);
  return {product, ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low};
}

/// Rounding error: at most 4 2^-106 (|a| + |b|).
inline DoublePair operator+(DoublePair a, DoublePair b) {
  const DoublePair sum = exact_sum(a.high, b.high);
  return ordered_sum(sum.high, sum.low + (a.low + b.low));
}

inline DoublePair operator-(DoublePair a, DoublePair b) { return a + DoublePair{-b.high, -b.low}; }

/// Rounding error: at most 8 2^-106 |a b|.
inline DoublePair operator*(DoublePair a, DoublePair b) {
  const DoublePair product = exact_product(a.high, b.high);
  return ordered_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

}  // namespace orbweave::voronoi
