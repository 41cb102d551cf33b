// Dense Cholesky factors of padded matrices, four rows at once, for the machine that the including
// unit is compiled for. No unit of this file may use anything that is shared with units compiled
// for other machines.
// Golub, Van Loan: Matrix Computations, 4th edition 2013, section 4.2 (Cholesky by columns).

#include "engine/geometry/lanes.h"
#include "engine/holes/rbf/padded_matrix.h"

namespace orbweave {
namespace {

constexpr std::size_t kPanel = 4;  // columns at once

/// `Blocks` times four rows of a panel of four columns.
template <std::size_t Blocks>
class PanelRows {
 public:
  PanelRows(const PaddedMatrix& m, std::size_t row, std::size_t panel, std::size_t columns)
      : rows_(m.values + row),
        at_panel_(m.values + panel),
        panel_(panel),
        stride_(m.stride),
        columns_(columns) {}

  /// Subtracts the products of the columns before the panel.
  void update() {
    Four sums[Blocks][kPanel];
    for (std::size_t b = 0; b < Blocks; ++b)
      for (std::size_t c = 0; c < kPanel; ++c) sums[b][c] = all(0.0);
    for (std::size_t k = 0; k < panel_; ++k) {
      const double* const column = rows_ + k * stride_;
      const double* const factors = at_panel_ + k * stride_;
      for (std::size_t b = 0; b < Blocks; ++b) {
        const Four x = load(column + 4 * b);
        for (std::size_t c = 0; c < kPanel; ++c) sums[b][c] += x * factors[c];
      }
    }
    for (std::size_t b = 0; b < Blocks; ++b)
      for (std::size_t c = 0; c < columns_; ++c) {
        double* const to = rows_ + (panel_ + c) * stride_ + 4 * b;
        store(to, load(to) - sums[b][c]);
      }
  }

  /// Divides by the factor of the panel's own four rows.
  void divide() {
    const double* const corner = at_panel_ + panel_ * stride_;
    for (std::size_t b = 0; b < Blocks; ++b)
      for (std::size_t c = 0; c < columns_; ++c) {
        double* const to = rows_ + (panel_ + c) * stride_ + 4 * b;
        Four x = load(to);
        for (std::size_t k = 0; k < c; ++k)
          x -= load(rows_ + (panel_ + k) * stride_ + 4 * b) * corner[k * stride_ + c];
        store(to, x * corner[c * stride_ + c]);
      }
  }

 private:
  double* rows_;
  const double* at_panel_;
  std::size_t panel_;
  std::size_t stride_;
  std::size_t columns_;
};

/// The panel's own rows, one by one; false where a pivot is not positive.
inline bool factor_corner(double* corner, std::size_t stride, std::size_t columns) {
  for (std::size_t c = 0; c < columns; ++c) {
    double pivot = corner[c * stride + c];
    for (std::size_t k = 0; k < c; ++k) pivot -= corner[k * stride + c] * corner[k * stride + c];
    if (!(pivot > 0.0)) return false;
    const double inverse = 1.0 / __builtin_sqrt(pivot);
    corner[c * stride + c] = inverse;
    for (std::size_t i = c + 1; i < kPanel; ++i) {
      double x = corner[c * stride + i];
      for (std::size_t k = 0; k < c; ++k) x -= corner[k * stride + i] * corner[k * stride + c];
      corner[c * stride + i] = x * inverse;
    }
  }
  return true;
}

bool factor(const PaddedMatrix& m) {
  for (std::size_t panel = 0; panel < m.size; panel += kPanel) {
    const std::size_t columns = panel + kPanel <= m.size ? kPanel : m.size - panel;
    PanelRows<1>(m, panel, panel, columns).update();
    if (!factor_corner(m.values + panel * m.stride + panel, m.stride, columns)) return false;
    std::size_t row = panel + kPanel;
    for (; row + 8 <= m.stride; row += 8) {
      PanelRows<2> rows(m, row, panel, columns);
      rows.update();
      rows.divide();
    }
    for (; row < m.stride; row += 4) {
      PanelRows<1> rows(m, row, panel, columns);
      rows.update();
      rows.divide();
    }
  }
  return true;
}

void solve(const PaddedMatrix& m, double* x) {
  for (std::size_t panel = 0; panel < m.size; panel += kPanel) {
    const std::size_t columns = panel + kPanel <= m.size ? kPanel : m.size - panel;
    const double* const corner = m.values + panel * m.stride + panel;
    for (std::size_t c = 0; c < columns; ++c) {
      double sum = x[panel + c];
      for (std::size_t k = 0; k < c; ++k) sum -= corner[k * m.stride + c] * x[panel + k];
      x[panel + c] = sum * corner[c * m.stride + c];
    }
    for (std::size_t row = kPanel; panel + row < m.stride; row += 4) {
      Four sum = load(x + panel + row);
      for (std::size_t c = 0; c < columns; ++c)
        sum -= load(corner + c * m.stride + row) * x[panel + c];
      store(x + panel + row, sum);
    }
  }
}

void solve_transposed(const PaddedMatrix& m, double* x) {
  for (std::size_t end = m.stride; end > 0; end -= kPanel) {
    const std::size_t panel = end - kPanel;
    const std::size_t columns = end <= m.size ? kPanel : m.size - panel;
    const double* const corner = m.values + panel * m.stride + panel;
    Four sums[kPanel];
    for (std::size_t c = 0; c < kPanel; ++c) sums[c] = all(0.0);
    for (std::size_t row = kPanel; panel + row < m.stride; row += 4) {
      const Four below = load(x + panel + row);
      for (std::size_t c = 0; c < columns; ++c)
        sums[c] += load(corner + c * m.stride + row) * below;
    }
    for (std::size_t c = columns; c > 0;) {
      --c;
      double sum = x[panel + c] - sum_of(sums[c]);
      for (std::size_t k = c + 1; k < columns; ++k) sum -= corner[c * m.stride + k] * x[panel + k];
      x[panel + c] = sum * corner[c * m.stride + c];
    }
  }
}

/// The lanes up to `lane`, which is on the diagonal, become 0.
inline Four below_diagonal(Four v, std::size_t lane) {
  for (std::size_t i = 0; i <= lane; ++i) v[i] = 0.0;
  return v;
}

void subtract(const PaddedMatrix& m, const PaddedTerms& terms, double* row_sums) {
  for (std::size_t row = 0; row < m.stride; row += 4) store(row_sums + row, all(0.0));
  for (std::size_t j = 0; j < m.size; ++j) {
    double* const column = m.values + j * m.stride;
    const std::size_t first = j / 4 * 4;
    Four along_column = all(0.0);
    for (std::size_t row = first; row < m.stride; row += 4) {
      Four sum = all(0.0);
      for (std::size_t t = 0; t < terms.count; ++t) {
        const std::size_t at = t * m.stride;
        sum +=
            load(terms.a + at + row) * terms.b[at + j] + load(terms.c + at + row) * terms.a[at + j];
      }
      const Four value = load(column + row) - sum;
      store(column + row, value);
      const Four below =
          row == first ? below_diagonal(absolute(value), j - first) : absolute(value);
      along_column += below;
      store(row_sums + row, load(row_sums + row) + below);
    }
    row_sums[j] += __builtin_fabs(column[j]) + sum_of(along_column);
  }
}

}  // namespace
}  // namespace orbweave
