#include "engine/synthetic/row.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace orbweave::synthetic {
namespace {

constexpr double kRampSteps = 4.0;  // points over which a stagger builds up

}  // namespace

double along(const Row& row, std::uint64_t k) {
  const auto position = static_cast<double>(k);
  const auto count = static_cast<double>(row.count);
  if (row.closed) return (position + row.begin) / count;
  if (row.count == 1) return 0.5 * (row.begin + row.end);
  if (k + 1 == row.count) return row.end;
  const double from_end = std::min(position, count - 1.0 - position);
  const double moved = position + row.stagger * std::min(1.0, from_end / kRampSteps);
  return row.begin + (row.end - row.begin) * (moved / (count - 1.0));
}

void append_counted(std::vector<Row>& rows, std::vector<Row> sheet,
                    const std::vector<double>& weights, std::uint64_t points) {
  double total = 0.0;
  for (const double weight : weights) total += weight;
  std::uint64_t spent = 0;
  double sum = 0.0;
  for (std::size_t j = 0; j < sheet.size(); ++j) {
    sum += weights[j];
    std::uint64_t upto = points;
    if (j + 1 < sheet.size())
      upto = std::min(points, static_cast<std::uint64_t>(
                                  std::floor(static_cast<double>(points) * (sum / total) + 0.5)));
    sheet[j].count = upto - std::min(upto, spent);
    spent = std::max(spent, upto);
    if (sheet[j].count > 0) rows.push_back(sheet[j]);
  }
}

}  // namespace orbweave::synthetic
