// The edges of a surface without a boundary, by which what lies at them is found.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace orbweave::voronoi {

/// A table of directed edges, each with the number of the tetrahedron that it belongs to. Edges are
/// all added before they are looked up: the machine foresees neither branch where both take turns.
class DirectedEdges {
 public:
  /// Forgets everything, and makes room for a number of edges.
  void clear(std::size_t edges) {
    const std::size_t slots = std::bit_ceil(kSlotsPerEdge * edges);
    if (slots > slots_.size()) slots_.assign(slots, {});
    mask_ = slots - 1;
    if (++round_ != 0) return;
    std::fill(slots_.begin(), slots_.end(), Slot());  // the rounds begin again
    round_ = 1;
  }

  void add(std::uint32_t from, std::uint32_t to, std::uint32_t cell) {
    std::size_t i = hash(from, to) & mask_;
    while (slots_[i].round == round_) i = (i + 1) & mask_;
    slots_[i] = {from, to, round_, cell};
  }

  /// Of an edge that was added.
  std::uint32_t cell(std::uint32_t from, std::uint32_t to) const {
    std::size_t i = hash(from, to) & mask_;
    while (slots_[i].from != from || slots_[i].to != to || slots_[i].round != round_)
      i = (i + 1) & mask_;
    return slots_[i].cell;
  }

 private:
  static constexpr std::size_t kSlotsPerEdge = 8;

  struct Slot {
    std::uint32_t from = 0, to = 0;
    std::uint32_t round = 0, cell = 0;
  };

  static std::size_t hash(std::uint32_t from, std::uint32_t to) {
    return (from * 0x9e3779b1U + to * 0x85ebca77U) >> 8;
  }

  std::vector<Slot> slots_;
  std::size_t mask_ = 0;
  std::uint32_t round_ = 0;
};

}  // namespace orbweave::voronoi
