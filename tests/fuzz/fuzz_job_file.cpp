// Job files from random bytes: read, or refused with a usage error. What is read is written and
// read back as the same job. The first byte chooses between a whole file and one assignment.
#include "io/job/job_file.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "io/error.h"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void read_back(const orbweave::Job& job) {
  const std::string text = orbweave::job_toml(job);
  try {
    require(orbweave::job_toml(orbweave::parse_job(text, "job.toml")) == text);
  } catch (const orbweave::Error&) {
    std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    orbweave::Job job;
    if (text.starts_with('=')) {
      orbweave::set_job_key(job, text.substr(1));
    } else {
      job = orbweave::parse_job(text, "job.toml", "some/folder");
      read_back(job);
    }
  } catch (const orbweave::Error& error) {
    require(error.kind() == orbweave::ErrorKind::kUsage);
  }
  return 0;
}
