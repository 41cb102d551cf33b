// What runs while another task fails is done whole, or what it made could be stored in parts.
#include "io/whole_loop.h"

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>

#include "io/bounds.h"
#include "io/error.h"
#include "io/store/chunk_store.h"
#include "partition/canonical_order.h"
#include "partition/root_cube.h"
#include "tests/io/stored_arrays.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

/// Runs `work` in a task whose loop is cancelled, as by the failure of another task.
template <class Work>
void while_cancelled(const Work& work) {
  tbb::task_group_context loop;
  bool has_run = false;
  tbb::parallel_for(
      0, 1,
      [&](int) {
        loop.cancel_group_execution();
        work();
        has_run = true;
      },
      loop);
  REQUIRE(has_run);
}

}  // namespace

TEST_CASE("ALoopIsDoneWholeWhileTheLoopAroundItIsCancelled") {
  std::atomic<std::size_t> calls{0};
  while_cancelled([&] { for_each_whole(10'000, [&](std::size_t) { ++calls; }); });
  CHECK(calls == 10'000);
  for_each_whole(0, [&](std::size_t) { ++calls; });
  CHECK(calls == 10'000);
}

TEST_CASE("AWholeLoopThrowsWhatACallThrows") {
  CHECK_THROWS_AS(for_each_whole(100,
                                 [](std::size_t i) {
                                   if (i == 57) throw std::runtime_error("57");
                                 }),
                  std::runtime_error);
}

TEST_CASE("LoopsThatMayHaveEndedEarlyAreTold") {
  CHECK_NOTHROW(check_loops_are_whole());
  while_cancelled([] { CHECK_THROWS_AS(check_loops_are_whole(), Error); });
  for_each_whole(2, [](std::size_t) { check_loops_are_whole(); });
}

TEST_CASE("NothingIsSortedByKeysAtRandomWhileAnotherTaskFails") {
  const std::vector<Vec3> positions(100'000, Vec3{1.0, 2.0, 3.0});
  const RootCube root = root_cube(bounds_of(positions));
  while_cancelled([&] { CHECK_THROWS_AS(canonical_rows({positions, {}, {}, 0}, root), Error); });
}

TEST_CASE("ResultsThatAreStoredAndReadWhileAnotherTaskFailsAreWhole") {
  const test::ScratchDirectory scratch;
  const test::Arrays arrays = test::make_arrays(200'000, 4);
  ChunkStore store(scratch / "work");
  while_cancelled([&] {
    store.commit("points", 0, arrays.views());
    CHECK(test::same(*store.open("points", 0), arrays));
  });
  CHECK(test::same(*store.open("points", 0), arrays));
}

}  // namespace orbweave
