// Bytes from files: kept where they are stored, safe where they are shown.
#include "io/shown_text.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "io/error.h"
#include "io/text/json_dump.h"

namespace orbweave {
namespace {

/// Bytes of all kinds, whole characters and backslashes among them.
std::string random_bytes(std::mt19937_64& random) {
  constexpr const char* kParts[] = {
      "\\", "x", "4f", "\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x92\xa9"};
  std::string text;
  for (std::uint64_t length = random() % 12; length > 0; --length) {
    if (random() % 2 == 0)
      text += kParts[random() % std::size(kParts)];
    else
      text += static_cast<char>(random());
  }
  return text;
}

}  // namespace

TEST_CASE("NamesInUtf8AreShownAsTheyAre") {
  for (const char* name : {"intensity", "Intensit\xc3\xa4t", "\xe5\xbc\xb7\xe5\xba\xa6",
                           "\xf0\x9f\x92\xa9", "C:\\scan", "a b"}) {
    CHECK(is_utf8(name));
    CHECK(shown(name) == name);
    CHECK(as_utf8(name) == name);
  }
}

TEST_CASE("BytesThatAreNoUtf8AreShownInHexadecimal") {
  CHECK(shown("intensit\xe4t") == "intensit\\xe4t");
  CHECK(as_utf8("intensit\xe4t") == "intensit\\xe4t");
  CHECK(shown("\xff\xfe") == "\\xff\\xfe");
  CHECK(shown("cut \xe2\x82") == "cut \\xe2\\x82");
  CHECK(shown("long \xc0\xaf") == "long \\xc0\\xaf");           // overlong
  CHECK(shown("half \xed\xa0\x80") == "half \\xed\\xa0\\x80");  // a surrogate
  CHECK(shown("\xf4\x90\x80\x80") == "\\xf4\\x90\\x80\\x80");   // beyond the last character
  CHECK_FALSE(is_utf8("intensit\xe4t"));
}

TEST_CASE("WhatATerminalObeysIsShownInHexadecimal") {
  CHECK(shown("\x1b[2Jgone\x07") == "\\x1b[2Jgone\\x07");
  CHECK(shown("two\nlines\r") == "two\\x0alines\\x0d");
  CHECK(shown(std::string_view("a\0b", 3)) == "a\\x00b");
  CHECK(shown("\xc2\x9b"
              "31m") ==
        "\\xc2\\x9b"
        "31m");  // the one-byte escape
  CHECK(shown("\xe2\x80\xae"
              "yl") ==
        "\\xe2\\x80\\xae"
        "yl");                       // right to left
  CHECK(as_utf8("\x1b") == "\x1b");  // JSON escapes it
}

TEST_CASE("ShowingTwiceIsShowingOnce") {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 2000; ++trial) {
    const std::string text = shown(random_bytes(random));
    REQUIRE(shown(text) == text);
    REQUIRE(is_utf8(text));
  }
}

TEST_CASE("EscapedBytesReadBack") {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 5000; ++trial) {
    const std::string text = random_bytes(random);
    REQUIRE(is_utf8(escaped_text(text)));
    REQUIRE(unescaped_text(escaped_text(text)) == text);
  }
  CHECK(escaped_text("a\\b\xff") == "a\\\\b\\xff");
}

TEST_CASE("DocumentsKeepBytesAndJsonForOthersIsUtf8") {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 500; ++trial) {
    const nlohmann::json document = {
        {random_bytes(random), {1.5, random_bytes(random)}},
        {"nested", {{"name", random_bytes(random)}, {"nothing", nullptr}}}};
    REQUIRE(document_from(document_text(document)) == document);
    const std::string text = json_dump(nlohmann::ordered_json(document), 2);
    REQUIRE(is_utf8(text));
    REQUIRE(nlohmann::json::accept(text));
  }
  CHECK(json_dump({{"name", "a\xff"}}) == "{\"name\":\"a\\\\xff\"}");
}

TEST_CASE("AnAdviceBehindAnotherOneIsASentenceOfItsOwn") {
  const Error inner(ErrorKind::kBadInput, "no point is left", {.advice = "A crop keeps them."});
  const Error outer(inner.kind(), inner.what(), {.advice = "The work directory m.work stays."});
  CHECK(std::string(outer.what()) ==
        "no point is left. A crop keeps them. The work directory m.work stays.");
}

TEST_CASE("AMessageIsOneLineWhateverANameHolds") {
  const Error error(ErrorKind::kBadInput, "no such attribute",
                    {.file = "sc\xe4n\n.ply", .found = "\x1b[31mred\xff"});
  CHECK(std::string(error.what()) ==
        "sc\\xe4n\\x0a.ply: no such attribute; found \\x1b[31mred\\xff");
}

}  // namespace orbweave
