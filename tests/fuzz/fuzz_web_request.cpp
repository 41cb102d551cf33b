// Any bytes as a request to the server of a viewer's folder.
#include <cstdlib>

#include "engine/view/web_request.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

constexpr std::uint64_t kBytes = 1000;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string head(reinterpret_cast<const char*>(data), size);
  const orbweave::WebAnswer answer =
      orbweave::answer_request(head, [](const std::string& name) -> std::optional<std::uint64_t> {
        // What is asked for is opened in the folder: the name must not lead out of it.
        const bool leads_out = name.empty() || name.front() == '.' ||
                               name.find('/') != std::string::npos ||
                               name.find('\0') != std::string::npos;
        if (leads_out) std::abort();
        return kBytes;
      });
  if (!answer.head.starts_with("HTTP/1.1 ") || !answer.head.ends_with("\r\n\r\n")) std::abort();
  if (!answer.file.empty() && (answer.first > kBytes || answer.bytes > kBytes - answer.first))
    std::abort();
  return 0;
}
