// Documents whose lists and objects lie within each other so deeply that copies of them need a
// stack that no thread has.
#include "io/json_nesting.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "io/text/json_dump.h"

namespace orbweave::test {
namespace {

std::string lists(std::size_t levels) {
  return std::string(levels, '[') + std::string(levels, ']');
}

std::string objects(std::size_t levels) {
  std::string text = "0";
  for (std::size_t i = 0; i < levels; ++i) text = "{\"a\":" + text + "}";
  return text;
}

}  // namespace

TEST_CASE("ADocumentHasSoManyLevelsAtMost") {
  for (const auto nested : {lists, objects}) {
    CHECK(json_of(nested(kMostJsonLevels)).is_structured());
    CHECK(json_of(nested(kMostJsonLevels + 1)).is_discarded());
  }
  CHECK(json_of(lists(1'000'000)).is_discarded());
  CHECK_THROWS_AS(document_from(objects(kMostJsonLevels + 1)), nlohmann::json::exception);
}

TEST_CASE("ListsBesideEachOtherAndBracketsInTextAreNoLevels") {
  std::string row = "[";
  for (std::size_t i = 0; i < kMostJsonLevels; ++i) row += "[{}],";
  CHECK(json_of(row + "0]").size() == kMostJsonLevels + 1);
  const std::string brackets(1000, '[');
  CHECK(json_of("\"\\\"" + brackets + "\\\\\"") == "\"" + brackets + "\\");
  CHECK(json_of("]" + lists(1)).is_discarded());
  CHECK(json_of("\"" + brackets).is_discarded());
}

}  // namespace orbweave::test
