#include "io/system/temporary_name.h"

#include <unistd.h>

#include <array>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "io/system/random_word.h"

namespace orbweave {
namespace {

constexpr std::string_view kSuffix = ".part";

/// Names of the temporaries that are there. A handler may not wait for a lock, so slots are taken
/// and left by single exchanges: the process that gets a name out of a slot owns the name.
std::array<std::atomic<char*>, 64> at_risk{};
static_assert(std::atomic<char*>::is_always_lock_free);

}  // namespace

std::filesystem::path directory_of(const std::filesystem::path& target) {
  return target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
}

std::filesystem::path temporary_beside(const std::filesystem::path& target) {
  const std::string end = "." + random_word() + std::string(kSuffix);
  // A target whose name is as long as names may be has a temporary all the same.
  const std::string name = target.filename().string().substr(0, NAME_MAX - 1 - end.size());
  return directory_of(target) / ("." + name + end);
}

void TemporaryAtRisk::keep(const std::filesystem::path& temporary) {
  forget();
  char* const name = ::strdup(temporary.c_str());
  if (name == nullptr) return;
  for (std::atomic<char*>& slot : at_risk) {
    char* free_slot = nullptr;
    if (!slot.compare_exchange_strong(free_slot, name)) continue;
    slot_ = &slot;
    return;
  }
  std::free(name);
}

void TemporaryAtRisk::forget() {
  if (slot_ == nullptr) return;
  std::free(slot_->exchange(nullptr));
  slot_ = nullptr;
}

void remove_temporaries_at_risk() {
  for (std::atomic<char*>& slot : at_risk) {
    const char* const name = slot.exchange(nullptr);
    if (name != nullptr) ::unlink(name);
  }
}

}  // namespace orbweave
