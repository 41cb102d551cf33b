#include "io/shown_text.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace orbweave {
namespace {

/// A character at the beginning of a text.
struct Character {
  std::size_t bytes = 1;
  std::uint32_t code = 0;
  bool is_valid = false;
};

/// Unicode 15, table 3-7: no overlong forms, no surrogates, nothing beyond U+10FFFF.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return {1, lead, true};
  const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  constexpr std::array<std::uint32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0u) != 0x80u) return {};
    code = code << 6 | (byte(i) & 0x3fu);
  }
  const bool is_surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kLeast[bytes] || code > 0x10ffff || is_surrogate) return {};
  return {bytes, code, true};
}

void append_escaped(std::string_view bytes, std::string& to) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    to += "\\x";
    to += kDigits[byte >> 4];
    to += kDigits[byte & 15u];
  }
}

/// Characters that a terminal obeys instead of showing them.
bool is_control(std::uint32_t code) {
  const bool turns = (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
  const bool breaks = code == 0x2028 || code == 0x2029;
  return code < 0x20 || (code >= 0x7f && code <= 0x9f) || turns || breaks;
}

/// Escapes bytes that are no UTF-8, and characters for which `escapes` holds.
template <class Escapes>
std::string escape(std::string_view text, const Escapes& escapes) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const Character character = first_character(text);
    const std::string_view bytes = text.substr(0, character.bytes);
    if (character.is_valid && !escapes(character.code))
      result += bytes;
    else
      append_escaped(bytes, result);
    text.remove_prefix(character.bytes);
  }
  return result;
}

/// The digit's value; 16: it is none.
unsigned digit_value(char c) {
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
  if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a') + 10u;
  return 16;
}

}  // namespace

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const Character character = first_character(text);
    if (!character.is_valid) return false;
    text.remove_prefix(character.bytes);
  }
  return true;
}

std::string as_utf8(std::string_view text) {
  return escape(text, [](std::uint32_t) { return false; });
}

std::string shown(std::string_view text) { return escape(text, is_control); }

std::string escaped_text(std::string_view text) {
  std::string result;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\\', begin), text.size());
    result += as_utf8(text.substr(begin, end - begin));
    if (end < text.size()) result += "\\\\";
    begin = end + 1;
  }
  return result;
}

std::string unescaped_text(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("\\\\")) {
      result += '\\';
      i += 1;
    } else if (rest.size() >= 4 && rest.starts_with("\\x") && digit_value(rest[2]) < 16 &&
               digit_value(rest[3]) < 16) {
      result += static_cast<char>(digit_value(rest[2]) * 16 + digit_value(rest[3]));
      i += 3;
    } else {
      result += rest.front();
    }
  }
  return result;
}

}  // namespace orbweave
