// What is written beside its target until it is whole: ".<target>.<16 digits>.part", where names of
// files have room for it; of a longer target the beginning.
#pragma once

#include <atomic>
#include <filesystem>

namespace orbweave {

/// Where a target lies; "." where it is a name alone.
std::filesystem::path directory_of(const std::filesystem::path& target);

/// A new name beside the target.
std::filesystem::path temporary_beside(const std::filesystem::path& target);

/// Names a temporary while it lives, so that a process that a library has crashed can still remove
/// it in its signal handler. Some dozens can be named at a time; further ones are not.
class TemporaryAtRisk {
 public:
  TemporaryAtRisk() = default;
  ~TemporaryAtRisk() { forget(); }
  TemporaryAtRisk(const TemporaryAtRisk&) = delete;
  TemporaryAtRisk& operator=(const TemporaryAtRisk&) = delete;

  void keep(const std::filesystem::path& temporary);
  /// The temporary is gone or has its final name.
  void forget();

 private:
  std::atomic<char*>* slot_ = nullptr;
};

/// Removes all of them. For a signal's handler that ends the process right after: it calls
/// nothing that a handler may not call.
void remove_temporaries_at_risk();

}  // namespace orbweave
