// Samples of files: what they notice, and what they cost.
#include "io/system/file_sample.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

std::string random_text(std::size_t bytes) {
  std::mt19937_64 random(bytes);
  std::string text(bytes, '\0');
  for (char& c : text) c = static_cast<char>(random());
  return text;
}

std::string flipped(std::string text, std::size_t at) {
  text[at] = static_cast<char>(text[at] ^ 1);
  return text;
}

}  // namespace

TEST_CASE("ASmallFileIsHashedWhole") {
  const test::ScratchDirectory scratch;
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{4097}, std::size_t{262144}}) {
    const std::string text = random_text(bytes);
    test::write_text(scratch / "a", text);
    const auto sample = sample_file(scratch / "a", 3);
    REQUIRE(sample);
    CHECK(sample->bytes_hashed == bytes);
    CHECK(sample->fingerprint.size() == 16);
    for (std::size_t at = 0; at < bytes; at += 1 + bytes / 97) {
      test::write_text(scratch / "b", flipped(text, at));
      REQUIRE(sample_file(scratch / "b", 3)->fingerprint != sample->fingerprint);
    }
  }
}

TEST_CASE("OfALargeFileFirstAndLastBytesAndBlocksBetweenAreHashed") {
  const test::ScratchDirectory scratch;
  const std::string text = random_text(1'000'003);
  test::write_text(scratch / "a", text);
  const auto sample = sample_file(scratch / "a");
  REQUIRE(sample);
  CHECK(sample->bytes_hashed == kWholeSampleBytes);
  std::size_t noticed = 0, changed = 0;
  for (std::size_t at = 0; at < text.size(); at += 9'973) {
    test::write_text(scratch / "b", flipped(text, at));
    noticed += sample_file(scratch / "b")->fingerprint != sample->fingerprint ? 1 : 0;
    ++changed;
  }
  CHECK(noticed * 5 > changed);  // a quarter of the bytes is hashed
  CHECK(noticed < changed);
  for (const std::size_t at : {std::size_t{0}, text.size() - 1}) {
    test::write_text(scratch / "b", flipped(text, at));
    CHECK(sample_file(scratch / "b")->fingerprint != sample->fingerprint);
  }
}

TEST_CASE("WhatIsNoRegularFileHasNoSampleAndIsNotWaitedFor") {
  const test::ScratchDirectory scratch;
  CHECK_FALSE(sample_file(scratch / "absent"));
  CHECK_FALSE(sample_file(scratch.path()));
  REQUIRE(mkfifo((scratch / "pipe").c_str(), 0600) == 0);
  CHECK_FALSE(sample_file(scratch / "pipe"));
  test::write_text(scratch / "empty", "");
  REQUIRE(sample_file(scratch / "empty"));
  CHECK(sample_file(scratch / "empty")->bytes_hashed == 0);
}

TEST_CASE("ManyFilesCostNoMoreBlocksThanFew") {
  CHECK(sample_blocks_of(1) == kSampleBlocks);
  CHECK(sample_blocks_of(64) == kSampleBlocks);
  CHECK(sample_blocks_of(1000) == 4);
  CHECK(sample_blocks_of(100'000) == 3);
}

}  // namespace orbweave
