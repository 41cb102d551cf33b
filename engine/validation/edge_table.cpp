#include "engine/validation/edge_table.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace orbweave {

EdgeTable::EdgeTable(std::span<const Triangle> triangles, std::size_t vertices,
                     const StopToken* stop)
    : first_use_(vertices + 1, 0) {
  StopLooks looks(stop, kStopBlock);
  // A counting sort by the lower vertex: counts are kept one place ahead, so that the cursor of
  // a vertex ends where the next one's uses begin.
  for (const Triangle& t : triangles) {
    looks.after(1);
    if (is_degenerate(t)) continue;
    for (int k = 0; k < 3; ++k) ++first_use_[std::min(t[k], t[(k + 1) % 3])];
  }
  std::uint64_t sum = 0;
  for (std::uint64_t& first : first_use_) {
    const std::uint64_t count = first;
    first = sum;
    sum += count;
  }
  uses_.resize(sum);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    looks.after(1);
    const Triangle& t = triangles[i];
    if (is_degenerate(t)) continue;
    for (int k = 0; k < 3; ++k) {
      const auto [lower, upper] = std::minmax(t[k], t[(k + 1) % 3]);
      uses_[first_use_[lower]++] = {upper, static_cast<std::uint32_t>(i)};
    }
  }
  for (std::size_t v = vertices; v > 0; --v) first_use_[v] = first_use_[v - 1];
  first_use_[0] = 0;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices, 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      check_stop(stop);
                      for (std::size_t v = range.begin(); v < range.end(); ++v)
                        std::sort(uses_.begin() + static_cast<std::ptrdiff_t>(first_use_[v]),
                                  uses_.begin() + static_cast<std::ptrdiff_t>(first_use_[v + 1]),
                                  [](const Use& a, const Use& b) {
                                    return a.upper != b.upper ? a.upper < b.upper
                                                              : a.triangle < b.triangle;
                                  });
                    });
}

}  // namespace orbweave
