// Counts the simple loops that walks along edges make.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace orbweave {

/// One walk after another. A walk that comes to a vertex again closes a loop there, so every loop
/// is simple; what is left of a walk at its end counts as one.
template <class Vertex>
class LoopPath {
 public:
  void begin(Vertex at) {
    path_.assign(1, at);
    place_.clear();
    place_[at] = 0;
  }
  void arrive(Vertex at) {
    const auto [entry, is_new] = place_.try_emplace(at, path_.size());
    if (is_new) {
      path_.push_back(at);
      return;
    }
    ++loops_;
    const std::size_t keep = entry->second + 1;
    for (std::size_t i = keep; i < path_.size(); ++i) place_.erase(path_[i]);
    path_.resize(keep);
  }
  void end() {
    if (path_.size() > 1) ++loops_;
  }
  std::uint64_t loops() const { return loops_; }

 private:
  std::vector<Vertex> path_;
  std::unordered_map<Vertex, std::size_t> place_;  // in path_
  std::uint64_t loops_ = 0;
};

}  // namespace orbweave
