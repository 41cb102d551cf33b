// A lack of descriptors is told with what helps, and is no word on what the chunk store holds.
// Sanitizers open descriptors of their own to look at objects, so the cases are not for them.
#include <sys/resource.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <string>

#include "io/error.h"
#include "io/store/chunk_store.h"
#include "io/system/owned_files.h"
#include "tests/io/stored_arrays.h"
#include "tests/support/data.h"

namespace orbweave {

using test::Arrays;
using test::make_arrays;
using test::same;

TEST_CASE("TooManyOpenFilesIsNoWordOnWhatIsStored") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(3000, 9);
  {
    ChunkStore store(scratch / "work");
    store.begin_stage("points", "key");
    store.commit("points", 0, arrays.views(), true);
  }
  ChunkStore store(scratch / "work");
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_NOFILE, &before) == 0);
  const int next = dup(0);  // the lowest descriptor that is free
  REQUIRE(next >= 0);
  close(next);
  // None is free for the key; one is for the result, and none for HDF5.
  const auto status_with = [&](int free, const std::function<void()>& use) {
    const rlimit few{static_cast<rlim_t>(next + free), before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_NOFILE, &few) == 0);
    ErrorKind status = ErrorKind::kNone;
    bool is_damage = false;
    try {
      use();
    } catch (const CorruptResult&) {
      is_damage = true;
    } catch (const Error& error) {
      status = error.kind();
    }
    REQUIRE(setrlimit(RLIMIT_NOFILE, &before) == 0);
    CHECK_FALSE(is_damage);
    return status;
  };
  CHECK(status_with(0, [&] { store.has_key("points", "key"); }) == ErrorKind::kResource);
  CHECK(status_with(0, [&] { store.commit("points", 1, arrays.views(), true); }) ==
        ErrorKind::kResource);
  CHECK(status_with(1, [&] { store.open("points", 0); }) == ErrorKind::kResource);
  CHECK(store.begin_stage("points", "key"));
  CHECK(same(*store.open("points", 0), arrays));
}

TEST_CASE("AFileThatCannotBeMadeIsToldWithWhatHelpsAgainstIt") {
  const test::ScratchDirectory scratch;
  OwnedFiles record(scratch.path(), "0123456789abcdef", 0);
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_NOFILE, &before) == 0);
  const rlimit none{0, before.rlim_max};
  std::string message;
  REQUIRE(setrlimit(RLIMIT_NOFILE, &none) == 0);
  try {
    record.create(scratch / "a");
  } catch (const Error& error) {
    message = error.what();
  }
  REQUIRE(setrlimit(RLIMIT_NOFILE, &before) == 0);
  CHECK_THAT(message, Catch::Contains("Too many open files. Raise the limit of open files"));
  CHECK_FALSE(std::filesystem::exists(scratch / "a"));
}

}  // namespace orbweave
