#include "io/stop_token.h"

#include "io/error.h"

namespace orbweave {

void StopToken::check() const {
  checks_.fetch_add(1, std::memory_order_relaxed);
  if (requested()) throw Error(ErrorKind::kInterrupted, kInterruptedText);
}

}  // namespace orbweave
