// The numbers of vertices in the mesh file: used points, then the patches' vertices, then copies.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "engine/holes/hole_pass.h"
#include "engine/pipeline/surface/filled_holes.h"
#include "engine/pipeline/surface/used_vertices.h"

namespace orbweave {

class OutputNumbers {
 public:
  /// Both must outlive the object.
  OutputNumbers(const UsedVertices& used, const FilledHoles& holes)
      : used_(used), holes_(holes), first_new_(used.count()), first_copy_(first_new_) {
    for (const std::uint64_t vertices : holes.new_vertices) {
      first_of_batch_.push_back(first_copy_);
      first_copy_ += vertices;
    }
    if (holes.splits.empty()) return;
    maybe_split_.assign(std::bit_ceil(holes.copies.size()), 0);
    for (const std::uint64_t point : holes.copies) {
      maybe_split_[word_of(point)] |= bit_of(point);
    }
  }

  /// Of a triangle of points and new vertices, these counted over all batches. `ranks`: those of
  /// used(), at hand for what comes next.
  Triangle64 of(const Triangle64& t, VertexRanks& ranks) const {
    Triangle64 result;
    for (int k = 0; k < 3; ++k) result[k] = value_of(of_corner(t, k, ranks));
    return result;
  }
  OutputVertex of_corner(const Triangle64& t, int k, VertexRanks& ranks) const {
    const std::uint64_t vertex = t[k];
    if (vertex >= kNewVertex) return OutputVertex{first_new_ + (vertex - kNewVertex)};
    const SplitCorner* split = split_of(t, vertex);
    return split != nullptr ? of_copy(*split) : ranks.of(vertex);
  }
  /// A triangle of a batch with its new vertices counted over all batches.
  Triangle64 over_all_batches(Triangle64 t, std::size_t batch) const {
    for (std::uint64_t& vertex : t) {
      if (vertex >= kNewVertex) vertex += first_of_batch_[batch] - first_new_;
    }
    return t;
  }

  const UsedVertices& used() const { return used_; }
  std::uint64_t first_of_batch(std::size_t batch) const { return first_of_batch_[batch]; }
  std::uint64_t first_copy() const { return first_copy_; }
  std::uint64_t vertices() const { return first_copy_ + holes_.copies.size(); }

  bool is_removed(const Triangle64& t) const {
    return std::binary_search(holes_.removed.begin(), holes_.removed.end(), t);
  }
  bool any_removed() const { return !holes_.removed.empty(); }
  bool any_split() const { return !maybe_split_.empty(); }
  /// The split of a triangle's corner; null where there is none.
  const SplitCorner* split_of(const Triangle64& t, std::uint64_t vertex) const {
    const bool maybe = any_split() && (maybe_split_[word_of(vertex)] & bit_of(vertex)) != 0;
    return maybe ? find_split(holes_, t, vertex) : nullptr;
  }
  OutputVertex of_copy(const SplitCorner& split) const {
    return OutputVertex{first_copy_ + value_of(split.copy)};
  }

 private:
  static std::uint64_t mixed(std::uint64_t point) { return point * 0x9e3779b97f4a7c15u; }
  std::size_t word_of(std::uint64_t point) const {
    return (mixed(point) >> 16) & (maybe_split_.size() - 1);
  }
  static std::uint64_t bit_of(std::uint64_t point) {
    return std::uint64_t{1} << (mixed(point) >> 58);
  }

  const UsedVertices& used_;
  const FilledHoles& holes_;
  std::uint64_t first_new_;
  std::uint64_t first_copy_;
  std::vector<std::uint64_t> first_of_batch_;
  std::vector<std::uint64_t> maybe_split_;  // 64 bits per copy, set by the mixed numbers
};

}  // namespace orbweave
