// XXH3-64 of bytes that come piece by piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace orbweave {

/// XXH3-64 (xxHash 0.8, seed 0). A copy goes on from the same bytes. Throws std::bad_alloc.
class RunningChecksum {
 public:
  RunningChecksum();
  RunningChecksum(const RunningChecksum& other);
  RunningChecksum(RunningChecksum&&) noexcept;
  ~RunningChecksum();
  RunningChecksum& operator=(const RunningChecksum&) = delete;
  RunningChecksum& operator=(RunningChecksum&&) noexcept;

  void add(const void* data, std::size_t bytes);
  std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
