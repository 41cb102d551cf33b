#include "io/system/running_checksum.h"

#include <xxhash.h>

#include <new>

namespace orbweave {

struct RunningChecksum::State {
  XXH3_state_t* const hash = XXH3_createState();  // aligned as vectors need it

  State() {
    if (hash == nullptr) throw std::bad_alloc();
    XXH3_64bits_reset(hash);
  }
  ~State() { XXH3_freeState(hash); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

RunningChecksum::RunningChecksum() : state_(std::make_unique<State>()) {}
RunningChecksum::RunningChecksum(const RunningChecksum& other) : RunningChecksum() {
  XXH3_copyState(state_->hash, other.state_->hash);
}
RunningChecksum::RunningChecksum(RunningChecksum&&) noexcept = default;
RunningChecksum::~RunningChecksum() = default;
RunningChecksum& RunningChecksum::operator=(RunningChecksum&&) noexcept = default;

void RunningChecksum::add(const void* data, std::size_t bytes) {
  XXH3_64bits_update(state_->hash, data, bytes);
}

std::uint64_t RunningChecksum::value() const { return XXH3_64bits_digest(state_->hash); }

}  // namespace orbweave
