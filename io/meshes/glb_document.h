// A glTF 2.0 file, binary or text, taken apart (Khronos, The glTF 2.0 Specification, 2021): its
// document and its numbers, every place in it checked against the bytes that are there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/streams/byte_reader.h"

namespace orbweave {

/// The numbers of an accessor.
struct GlbNumbers {
  const std::byte* first = nullptr;
  std::size_t stride = 0;  ///< bytes from an element to the next
  std::uint64_t count = 0;
  int component_type = 0;  ///< the specification's number: 5126 is float
  int components = 0;      ///< of an element: 3 of VEC3
  bool is_normalized = false;
  std::string place;  ///< "accessors[2]"

  /// Component of an element; normalized integers are fractions from 0, or -1, to 1.
  double value(std::uint64_t element, int component) const;
  /// Element of unsigned integers.
  std::uint32_t index(std::uint64_t element) const;
};

/// Throws Error (bad input) with file, place, what was found and expected, for damage and for what
/// the reader does not know: required extensions, sparse accessors, data in other files.
class GlbDocument {
 public:
  using Json = nlohmann::json;

  explicit GlbDocument(ByteReader reader);
  ~GlbDocument();

  const Json& json() const { return *json_; }
  std::uint64_t data_bytes() const;  ///< of all buffers
  bool is_own() const;               ///< made by this program

  /// Element of an array of the document: "meshes", 3.
  const Json& element(const char* array, std::uint64_t index, const std::string& from) const;
  /// A member that is a whole number; nothing where it is absent.
  std::optional<std::uint64_t> number(const Json& object, const char* key,
                                      const std::string& place) const;
  std::uint64_t required_number(const Json& object, const char* key,
                                const std::string& place) const;
  /// A member that is an array, or an object; null where it is absent.
  const Json* array(const Json& object, const char* key, const std::string& place) const;
  const Json* object(const Json& object, const char* key, const std::string& place) const;
  GlbNumbers numbers(std::uint64_t accessor, const std::string& from) const;

  [[noreturn]] void fail(const std::string& problem, const std::string& place, std::string found,
                         std::string expected, std::string advice = {}) const;

 private:
  void read_header(ByteReader& reader);
  void read_document(ByteReader& reader);
  void read_text(ByteReader& reader);
  void parse(const std::vector<std::byte>& text, const char* place);
  void read_data(ByteReader& reader);
  void check_end(ByteReader& reader) const;
  std::uint32_t word(ByteReader& reader, const char* what) const;
  std::vector<std::byte> read_bytes(ByteReader& reader, std::uint64_t bytes,
                                    const char* what) const;
  void read_buffers();
  std::vector<std::byte> buffer_of(const std::string& uri, const std::string& place) const;
  std::vector<std::byte> file_beside(const std::string& uri, const std::string& place) const;
  std::vector<std::byte> decoded(std::string_view text, const std::string& place) const;
  void check_version() const;
  void check_extensions() const;
  void place_in_view(const Json& accessor, std::uint64_t view, GlbNumbers& numbers) const;

  std::string file_;
  std::uint64_t left_ = 0;  ///< bytes of the file behind what was read, as its header has it
  std::unique_ptr<Json> json_;
  std::vector<std::byte> chunk_;  ///< data in the file, of the first buffer
  std::vector<std::optional<std::vector<std::byte>>> buffers_;  ///< without those that are nowhere
};

}  // namespace orbweave
