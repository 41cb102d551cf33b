#include "io/report/machine.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <charconv>
#include <fstream>
#include <optional>
#include <thread>

namespace orbweave {
namespace {

/// What follows "<name>:" in a file of such lines; "" where there is none.
std::string field_of(const char* path, const std::string& name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with(name) || colon == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return "";
}

/// "VmRSS: 1234 kB" and the like, in bytes.
std::optional<std::uint64_t> status_bytes(const std::string& name) {
  const std::string text = field_of("/proc/self/status", name);
  std::uint64_t kibibytes = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), kibibytes);
  if (result.ec != std::errc()) return std::nullopt;
  return kibibytes * 1024;
}

int usable_cores() {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
  return static_cast<int>(std::thread::hardware_concurrency());
}

}  // namespace

MachineFacts machine_facts() {
  MachineFacts facts;
  facts.cores = usable_cores();
  facts.cpu_model = field_of("/proc/cpuinfo", "model name");
  const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGESIZE);
  if (pages > 0 && page_bytes > 0)
    facts.memory_bytes = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
  return facts;
}

/// The kernel's ru_maxrss also counts what the process was before it became this program, so it
/// only serves where there is no /proc.
std::uint64_t peak_memory_bytes() {
  if (const auto bytes = status_bytes("VmHWM")) return *bytes;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::uint64_t current_memory_bytes() { return status_bytes("VmRSS").value_or(0); }

}  // namespace orbweave
