// What a stored result belongs to: the work directory, the stage as it was begun, and the place in
// it. Every file that the chunk store reads back carries it, so that a file that lies in another
// one's place is noticed. docs/dev/chunk-store.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace orbweave {

/// 32 hexadecimal digits that no other call returns, in no other process. They never reach an
/// output.
std::string new_id();
/// Whether a text is of the form that new_id() returns.
bool is_new_id(std::string_view text);

/// XXH3-128 as 32 hexadecimal digits.
std::string content_checksum(std::string_view text);

struct ResultIdentity {
  std::string store;    ///< id of the work directory
  std::string stage;    ///< name of the stage
  std::string edition;  ///< id drawn when the stage was begun under its key; empty: it has no key
  std::string place;    ///< "chunk 37", "document partition"

  /// One line each.
  std::string text() const;
  friend bool operator==(const ResultIdentity&, const ResultIdentity&) = default;
};

/// What ResultIdentity::place is.
std::string place_of_chunk(std::uint32_t chunk);
std::string place_of_document(const std::string& name);

/// Of a text that text() made; empty: it is none.
std::optional<ResultIdentity> identity_from(std::string_view text);

/// What lies where `expected` should: "the result of chunk 37 of stage raw_normals".
std::string name_of_stranger(const ResultIdentity& found, const ResultIdentity& expected);

/// Checksum of a text that belongs to `identity`.
std::string bound_checksum(const ResultIdentity& identity, std::string_view text);

/// What lies beside a document: its checksum, and where it belongs.
std::string document_mark(const ResultIdentity& identity, std::string_view document);
/// Where a document belongs, by its mark. Empty: one of them is damaged.
std::optional<ResultIdentity> identity_of_document(std::string_view document,
                                                   std::string_view mark);

/// What a stage depends on, and the id of the results that were made of that.
struct StageKey {
  std::string key;
  std::string edition;
};
/// The key as a JSON document that belongs to a store and a stage.
std::string stage_key_document(const std::string& store, const std::string& stage,
                               const StageKey& key);
/// Where such a document belongs; its place is "key". Empty: it is damaged, or none.
std::optional<ResultIdentity> identity_of_key_document(const std::string& document);
/// The key of a stage. Empty: the document is damaged, or belongs elsewhere.
std::optional<StageKey> stage_key_from(const std::string& store, const std::string& stage,
                                       const std::string& document);

}  // namespace orbweave
