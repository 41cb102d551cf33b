// The numbers of vertices in the mesh file: used points, then the patches' vertices, then copies.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "engine/pipeline/hole_stage.h"
#include "engine/pipeline/used_vertices.h"

namespace orbweave {

class OutputNumbers {
 public:
  /// Both must outlive the object; `used` is numbered.
  OutputNumbers(const UsedVertices& used, const FilledHoles& holes, std::uint64_t points)
      : used_(used), holes_(holes), first_new_(used.count()), first_copy_(first_new_) {
    for (const std::uint64_t vertices : holes.new_vertices) {
      first_of_batch_.push_back(first_copy_);
      first_copy_ += vertices;
    }
    if (holes.splits.empty()) return;
    split_.assign((points + 63) / 64, 0);
    for (const std::uint64_t point : holes.copies) {
      split_[point / 64] |= std::uint64_t{1} << (point % 64);
    }
  }

  /// Of a triangle as it is stored; new vertices are counted over all batches.
  Triangle64 of(const Triangle64& t) const {
    Triangle64 result;
    for (int k = 0; k < 3; ++k) result[k] = of_corner(t, k);
    return result;
  }
  std::uint64_t of_corner(const Triangle64& t, int k) const {
    const std::uint64_t vertex = t[k];
    if (vertex >= kNewVertex) return first_new_ + (vertex - kNewVertex);
    if (is_split(vertex)) {
      const SplitCorner* split = find_split(holes_, t, vertex);
      if (split != nullptr) return first_copy_ + split->copy;
    }
    return used_.rank(vertex);
  }
  /// A triangle of a batch with its new vertices counted over all batches.
  Triangle64 over_all_batches(Triangle64 t, std::size_t batch) const {
    for (std::uint64_t& vertex : t) {
      if (vertex >= kNewVertex) vertex += first_of_batch_[batch] - first_new_;
    }
    return t;
  }

  std::uint64_t first_of_batch(std::size_t batch) const { return first_of_batch_[batch]; }
  std::uint64_t first_copy() const { return first_copy_; }
  std::uint64_t vertices() const { return first_copy_ + holes_.copies.size(); }

  bool is_removed(const Triangle64& t) const {
    return std::binary_search(holes_.removed.begin(), holes_.removed.end(), t);
  }
  bool any_removed() const { return !holes_.removed.empty(); }

 private:
  bool is_split(std::uint64_t point) const {
    return !split_.empty() && (split_[point / 64] >> (point % 64) & 1) != 0;
  }

  const UsedVertices& used_;
  const FilledHoles& holes_;
  std::uint64_t first_new_;
  std::uint64_t first_copy_;
  std::vector<std::uint64_t> first_of_batch_;
  std::vector<std::uint64_t> split_;
};

}  // namespace orbweave
