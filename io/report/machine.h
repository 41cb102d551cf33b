// The machine that a run was measured on.
#pragma once

#include <cstdint>
#include <string>

namespace orbweave {

struct MachineFacts {
  int cores = 0;                   ///< that this process may use
  std::string cpu_model;           ///< "" where the system does not say
  std::uint64_t memory_bytes = 0;  ///< physical memory
};
MachineFacts machine_facts();

/// Peak resident memory of this process, bytes.
std::uint64_t peak_memory_bytes();
std::uint64_t current_memory_bytes();

}  // namespace orbweave
