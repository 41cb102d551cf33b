// Advice follows from what the system refused: room helps a full disk and nothing else.
#include "io/system/system_advice.h"

#include <catch2/catch.hpp>
#include <cerrno>
#include <utility>
#include <vector>

namespace orbweave {

TEST_CASE("AdviceFollowsTheSystemsError") {
  using Catch::Matchers::Contains;
  const std::vector<std::pair<int, const char*>> cases = {
      {ENOSPC, "Free some space or write it elsewhere"},
      {EDQUOT, "quota"},
      {EFBIG, "ulimit -f"},
      {EMFILE, "ulimit -n"},
      {ENFILE, "open files"},
      {ENOMEM, "ulimit -v"},
      {EAGAIN, "ulimit -u"},
      {EACCES, "permissions"},
      {EROFS, "for reading only"},
      {EIO, "The device fails"}};
  for (const auto& [error, words] : cases) {
    CAPTURE(error);
    CHECK_THAT(advice_on(error), Contains(words));
    if (error != ENOSPC) CHECK_THAT(advice_on(error), !Contains("Free some space"));
  }
  CHECK(advice_on(ENOENT) == "Write it elsewhere");
  CHECK_THAT(advice_on_work_directory(EMFILE),
             Contains("ulimit -n") && Contains("; the same command resumes what is done"));
  CHECK_THAT(advice_on_work_directory(ENOSPC), Contains("name another work directory"));
  // Another directory resumes nothing.
  for (const int error : {ENOENT, EROFS, EIO})
    CHECK_THAT(
        advice_on_work_directory(error),
        Contains("name another work directory", Catch::CaseSensitive::No) && !Contains("resumes"));
}

TEST_CASE("OnlyAReachedLimitIsALack") {
  for (const int error : {EMFILE, ENFILE, ENOMEM, EAGAIN}) CHECK(is_lack(error));
  for (const int error : {ENOENT, EACCES, EIO, ENOSPC}) CHECK_FALSE(is_lack(error));
}

}  // namespace orbweave
