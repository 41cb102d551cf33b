#include "io/store/result_identity.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "io/hex_digits.h"
#include "io/json_nesting.h"
#include "io/shown_text.h"
#include "io/store/json_member.h"
#include "io/system/random_word.h"

namespace orbweave {
namespace {

constexpr std::size_t kIdDigits = 32;
constexpr const char* kKeyPlace = "key";
constexpr std::array<std::string_view, 3> kLines = {"store ", "stage ", "edition "};

ResultIdentity identity_of_key(const std::string& store, const std::string& stage,
                               const std::string& edition) {
  return {store, stage, edition, kKeyPlace};
}

struct KeyDocument {
  std::string key;
  std::string belongs_to;
  std::string checksum;
};

/// Members that are missing are empty.
KeyDocument parts_of(const std::string& document) {
  const nlohmann::json json = json_of(document);
  return {unescaped_text(string_member(json, "key")), string_member(json, "belongs_to"),
          string_member(json, "xxh3")};
}

}  // namespace

std::string new_id() { return random_word() + random_word(); }

bool is_new_id(std::string_view text) {
  return text.size() == kIdDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string content_checksum(std::string_view text) {
  const XXH128_hash_t hash = XXH3_128bits(text.data(), text.size());
  return hex_digits(hash.high64) + hex_digits(hash.low64);
}

std::string ResultIdentity::text() const {
  return "store " + store + "\nstage " + stage + "\nedition " + edition + "\n" + place + "\n";
}

std::string place_of_chunk(std::uint32_t chunk) { return "chunk " + std::to_string(chunk); }
std::string place_of_document(const std::string& name) { return "document " + name; }

std::optional<ResultIdentity> identity_from(std::string_view text) {
  std::array<std::string, 4> values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return std::nullopt;
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (i < kLines.size()) {
      if (!line.starts_with(kLines[i])) return std::nullopt;
      line.remove_prefix(kLines[i].size());
    }
    values[i] = line;
  }
  if (!text.empty()) return std::nullopt;
  return ResultIdentity{values[0], values[1], values[2], values[3]};
}

std::string name_of_stranger(const ResultIdentity& found, const ResultIdentity& expected) {
  std::string what = "the result of " + shown(found.place) + " of stage " + shown(found.stage);
  if (found.store != expected.store) return what + " of another work directory";
  if (found.stage != expected.stage || found.place != expected.place) return what;
  return what + " from before the stage was begun anew";
}

std::string bound_checksum(const ResultIdentity& identity, std::string_view text) {
  return content_checksum(identity.text().append(text));
}

std::string document_mark(const ResultIdentity& identity, std::string_view document) {
  return bound_checksum(identity, document) + "\n" + identity.text();
}

std::optional<ResultIdentity> identity_of_document(std::string_view document,
                                                   std::string_view mark) {
  const std::size_t end = mark.find('\n');
  if (end == std::string_view::npos) return std::nullopt;
  std::optional<ResultIdentity> identity = identity_from(mark.substr(end + 1));
  if (!identity || bound_checksum(*identity, document) != mark.substr(0, end)) return std::nullopt;
  return identity;
}

std::string stage_key_document(const std::string& store, const std::string& stage,
                               const StageKey& key) {
  const ResultIdentity identity = identity_of_key(store, stage, key.edition);
  const nlohmann::json json = {{"key", escaped_text(key.key)},
                               {"belongs_to", identity.text()},
                               {"xxh3", bound_checksum(identity, key.key)}};
  return json.dump(2) + "\n";
}

std::optional<ResultIdentity> identity_of_key_document(const std::string& document) {
  const KeyDocument parts = parts_of(document);
  const std::optional<ResultIdentity> identity = identity_from(parts.belongs_to);
  const bool is_sound = identity && is_new_id(identity->edition) && identity->place == kKeyPlace &&
                        parts.checksum == bound_checksum(*identity, parts.key);
  return is_sound ? identity : std::nullopt;
}

std::optional<StageKey> stage_key_from(const std::string& store, const std::string& stage,
                                       const std::string& document) {
  const std::optional<ResultIdentity> identity = identity_of_key_document(document);
  if (!identity || *identity != identity_of_key(store, stage, identity->edition))
    return std::nullopt;
  return StageKey{parts_of(document).key, identity->edition};
}

}  // namespace orbweave
