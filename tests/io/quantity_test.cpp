#include "io/text/quantity.h"

#include <catch2/catch.hpp>
#include <cstdint>

namespace orbweave {
namespace {

TEST_CASE("QuantitiesOfMemoryAreUnderstood") {
  CHECK(parse_bytes("2GiB") == std::uint64_t{2} << 30);
  CHECK(parse_bytes(" 512 MiB ") == std::uint64_t{512} << 20);
  CHECK(parse_bytes("1.5GB") == 1500000000);
  CHECK(parse_bytes("1000000") == 1000000);
  CHECK(parse_bytes("3g") == std::uint64_t{3} << 30);
  CHECK(parse_bytes("7 B") == 7);
  CHECK(parse_bytes("1.5kb") == 1500);
  CHECK(parse_bytes("9223372036854775807") == 9223372036854775807U);
  for (const char* text : {"", "GiB", "-1", "1 GiBs", "1 2", "nan", "inf", "1e30", "99999999TiB",
                           "9223372036854775808", "0x10", "1,5GB"}) {
    CAPTURE(text);
    CHECK_FALSE(parse_bytes(text).has_value());
  }
}

TEST_CASE("QuantitiesAreWrittenForPeople") {
  CHECK(format_bytes(0) == "0 B");
  CHECK(format_bytes(1536) == "1.5 KiB");
  CHECK(format_bytes((std::uint64_t{1} << 30) - 1) == "1.0 GiB");
  CHECK(exact_bytes(std::uint64_t{4} << 30) == "4GiB");
  CHECK(exact_bytes(1025) == "1025");
  CHECK(format_count(0) == "0");
  CHECK(format_count(437645) == "437,645");
  CHECK(format_count(1000000000) == "1,000,000,000");
  CHECK(format_rate(0.4) == "0");
  CHECK(format_rate(730.0) == "730");
  CHECK(format_rate(1250000.0) == "1.25M");
  CHECK(format_rate(999600.0) == "1.00M");
  CHECK(format_duration(0.44) == "0.4 s");
  CHECK(format_duration(200.0) == "3 min 20 s");
  CHECK(format_duration(7500.0) == "2 h 5 min");
}

TEST_CASE("ACoordinateOfZeroHasNoSign") {
  CHECK(format_coordinate(-0.0) == "0");
  CHECK(format_coordinate(-2.5) == "-2.5");
  CHECK(format_position({4.0, -0.0, 0.0}) == "(4, 0, 0)");
}

}  // namespace
}  // namespace orbweave
