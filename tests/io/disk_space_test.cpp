#include "io/system/disk_space.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <thread>
#include <vector>

#include "tests/support/data.h"

using namespace orbweave;

TEST_CASE("DiskUsageRemembersTheMostThatWasHeldAtOneTime") {
  DiskUsage disk;
  disk.add(100);
  disk.remove(60);
  disk.add(30);
  CHECK(disk.now() == 70);
  CHECK(disk.most() == 100);
  disk.set(500);
  disk.remove(10'000);
  CHECK(disk.now() == 0);
  CHECK(disk.most() == 500);
}

TEST_CASE("DiskUsageIsToldByManyThreads") {
  DiskUsage disk;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 1000; ++i) disk.add(3);
      for (int i = 0; i < 1000; ++i) disk.remove(2);
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(disk.now() == 4000);
  CHECK(disk.most() >= 4000);
  CHECK(disk.most() <= 12'000);
}

TEST_CASE("TheRoomOfADirectoryIsThatOfAllItsFilesInWholeBlocks") {
  const test::ScratchDirectory scratch;
  CHECK(room_of_directory(scratch / "absent") == 0);
  CHECK(room_of_directory(scratch.path()) == 0);
  std::filesystem::create_directories(scratch / "a/b");
  std::ofstream(scratch / "a/b/one") << 'x';
  std::ofstream(scratch / "two") << std::string(4097, 'x');
  std::ofstream(scratch / "empty");
  CHECK(room_of_directory(scratch.path()) == 4096 + 8192);
}

TEST_CASE("FreeSpaceIsThatOfTheNearestDirectoryAbove") {
  const test::ScratchDirectory scratch;
  const FreeSpace here = free_space(scratch.path());
  const FreeSpace below = free_space(scratch / "not/there/yet");
  CHECK(here.bytes > 0);
  CHECK(below.device == here.device);
  CHECK(free_space("relative/and/absent").device == free_space(".").device);
}
