// Dense matrices whose columns are whole vectors. Units compiled for other machines include this
// header: it defines nothing.
#pragma once

#include <cstddef>

namespace orbweave {

/// A symmetric matrix in columns, or its Cholesky factor in the lower triangle, whose diagonal has
/// the inverses. `stride`, the distance between columns, is `size` rounded up to a multiple of
/// four; the rows from `size` on are 0.
struct PaddedMatrix {
  double* values = nullptr;
  std::size_t size = 0;
  std::size_t stride = 0;
};

/// What is subtracted of a kernel matrix where the polynomial is eliminated: with `count` columns
/// of `stride` rows in each of a, b and c, padded as the matrix, sum a_t b_t' + c_t a_t'.
struct PaddedTerms {
  const double* a = nullptr;
  const double* b = nullptr;
  const double* c = nullptr;
  std::size_t count = 0;
};

}  // namespace orbweave
