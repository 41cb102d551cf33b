#include "io/meshes/glb_document.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/json_nesting.h"
#include "io/shown_text.h"
#include "io/streams/byte_source.h"
#include "io/text/little_endian.h"

namespace orbweave {
namespace {

// Numbers of the specification.
constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"
constexpr std::uint64_t kWordBytes = sizeof(std::uint32_t);

struct ComponentType {
  int number;
  std::size_t bytes;
};
enum Component { kByte = 5120, kUbyte, kShort, kUshort, kUint = 5125, kFloat };
constexpr std::array kComponentTypes = {ComponentType{kByte, 1},  ComponentType{kUbyte, 1},
                                        ComponentType{kShort, 2}, ComponentType{kUshort, 2},
                                        ComponentType{kUint, 4},  ComponentType{kFloat, 4}};

struct ElementType {
  std::string_view name;
  int components;
};
constexpr std::array kElementTypes = {ElementType{"SCALAR", 1}, ElementType{"VEC2", 2},
                                      ElementType{"VEC3", 3}, ElementType{"VEC4", 4}};

constexpr const char* kOtherFile =
    "Write it as a .glb file without compression, or convert it to .ply with the program that made "
    "it";

/// What changes no position and no triangle where it is left out, or is understood.
bool is_known_extension(std::string_view name) {
  constexpr std::array kKnown = {
      std::string_view("KHR_mesh_quantization"), std::string_view("KHR_texture_transform"),
      std::string_view("KHR_texture_basisu"),    std::string_view("EXT_texture_webp"),
      std::string_view("EXT_mesh_features"),     std::string_view("EXT_structural_metadata")};
  return name.starts_with("KHR_materials_") || std::ranges::find(kKnown, name) != kKnown.end();
}

std::string in_brackets(const char* array, std::uint64_t index) {
  return std::string(array) + "[" + std::to_string(index) + "]";
}

std::string text_of(const nlohmann::json& value) {
  constexpr std::size_t kLongest = 60;
  return shown(
      value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace).substr(0, kLongest));
}

/// The name of a file in this folder that a relative URI stands for, with the bytes that its
/// percent signs encode (RFC 3986, section 2.1); nothing of a URI that leads elsewhere.
std::optional<std::string> name_of_uri(std::string_view uri) {
  if (uri.starts_with("./")) uri.remove_prefix(2);
  if (uri.find_first_of("/\\:?#") != uri.npos) return std::nullopt;
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      name += uri[i];
      continue;
    }
    unsigned char byte = 0;
    const std::string_view digits = uri.substr(i + 1, 2);
    const char* const last = digits.data() + digits.size();
    const auto [end, error] = std::from_chars(digits.data(), last, byte, 16);
    if (digits.size() != 2 || error != std::errc{} || end != last) return std::nullopt;
    name += static_cast<char>(byte);
    i += 2;
  }
  constexpr std::string_view kInNoName("/\\\0", 3);
  const bool leads_elsewhere = name.find_first_of(kInNoName) != name.npos;
  if (name.empty() || name.front() == '.' || leads_elsewhere) return std::nullopt;
  return name;
}

template <class T>
double fraction(const std::byte* at, bool is_normalized) {
  const auto value = static_cast<double>(load_little<T>(at));
  if (!is_normalized) return value;
  return std::max(value / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
}

}  // namespace

double GlbNumbers::value(std::uint64_t element, int component) const {
  const std::byte* at = first + element * stride;
  const auto n = static_cast<std::size_t>(component);
  switch (component_type) {
    case kByte:
      return fraction<std::int8_t>(at + n, is_normalized);
    case kUbyte:
      return fraction<std::uint8_t>(at + n, is_normalized);
    case kShort:
      return fraction<std::int16_t>(at + 2 * n, is_normalized);
    case kUshort:
      return fraction<std::uint16_t>(at + 2 * n, is_normalized);
    case kUint:
      return fraction<std::uint32_t>(at + 4 * n, is_normalized);
    default:
      return static_cast<double>(load_little<float>(at + 4 * n));
  }
}

std::uint32_t GlbNumbers::index(std::uint64_t element) const {
  const std::byte* at = first + element * stride;
  if (component_type == kUbyte) return load_little<std::uint8_t>(at);
  if (component_type == kUshort) return load_little<std::uint16_t>(at);
  return load_little<std::uint32_t>(at);
}

GlbDocument::GlbDocument(ByteReader reader) : file_(reader.name()) {
  const bool is_binary =
      reader.ensure(kWordBytes) && load_little<std::uint32_t>(reader.data()) == kMagic;
  if (is_binary) {
    read_header(reader);
    read_document(reader);
    read_data(reader);
    check_end(reader);
  } else {
    read_text(reader);
  }
  check_version();
  check_extensions();
  read_buffers();
}

GlbDocument::~GlbDocument() = default;

void GlbDocument::fail(const std::string& problem, const std::string& place, std::string found,
                       std::string expected, std::string advice) const {
  throw_bad_input(problem, {.file = file_,
                            .place = place,
                            .found = std::move(found),
                            .expected = std::move(expected),
                            .advice = std::move(advice)});
}

std::uint32_t GlbDocument::word(ByteReader& reader, const char* what) const {
  if (!reader.ensure(kWordBytes))
    fail("the GLB file ends early", reader.byte_place(), "the end of the file", what);
  const auto word = load_little<std::uint32_t>(reader.data());
  reader.consume(kWordBytes);
  return word;
}

/// Grows with what is there, not with what the file says.
std::vector<std::byte> GlbDocument::read_bytes(ByteReader& reader, std::uint64_t bytes,
                                               const char* what) const {
  std::vector<std::byte> read;
  while (read.size() < bytes) {
    if (!reader.ensure(1))
      fail("the GLB file ends early", reader.byte_place(),
           std::to_string(read.size()) + " bytes of the " + what, std::to_string(bytes));
    const std::size_t count = std::min<std::uint64_t>(reader.available(), bytes - read.size());
    read.insert(read.end(), reader.data(), reader.data() + count);
    reader.consume(count);
  }
  return read;
}

void GlbDocument::read_header(ByteReader& reader) {
  reader.consume(kWordBytes);
  if (const std::uint32_t version = word(reader, "the version of the format"); version != 2)
    fail("the version of the GLB file is not known", "byte 4", std::to_string(version), "2",
         "Write it as glTF 2.0");
  const std::uint64_t bytes = word(reader, "the length of the file");
  const std::uint64_t header = 3 * kWordBytes;
  const std::optional<std::uint64_t> there = reader.bytes_left();
  if (bytes < header || (there && *there + header < bytes))
    fail("the length in the GLB file is not that of the file", "byte 8", std::to_string(bytes),
         there ? "at most " + std::to_string(*there + header) : "at least 12");
  left_ = bytes - header;
}

void GlbDocument::read_document(ByteReader& reader) {
  const std::uint64_t bytes = word(reader, "the length of the document");
  const std::uint32_t type = word(reader, "the type of the document");
  if (type != kJsonChunk || left_ < 2 * kWordBytes || bytes > left_ - 2 * kWordBytes)
    fail("the GLB file does not begin with its document", "byte 12",
         "a chunk of type " + std::to_string(type) + " and " + std::to_string(bytes) + " bytes",
         "a chunk of type " + std::to_string(kJsonChunk) + " within the file");
  left_ -= 2 * kWordBytes + bytes;
  const std::vector<std::byte> text = read_bytes(reader, bytes, "document");
  parse(text, "byte 20");
}

void GlbDocument::read_text(ByteReader& reader) {
  std::vector<std::byte> text;
  while (reader.ensure(1)) {
    text.insert(text.end(), reader.data(), reader.data() + reader.available());
    reader.consume(reader.available());
  }
  parse(text, "byte 0");
}

void GlbDocument::parse(const std::vector<std::byte>& text, const char* place) {
  constexpr std::size_t kShown = 40;
  const char* first = reinterpret_cast<const char*>(text.data());
  if (nests_too_deeply({first, text.size()}))
    fail("the glTF document is nested too deeply", place, "", expected_json_levels());
  json_ = std::make_unique<Json>(Json::parse(first, first + text.size(), nullptr, false));
  if (!json_->is_object())
    fail("this is no glTF file", place, excerpt({first, std::min(text.size(), kShown)}),
         "\"glTF\", or {\"asset\": ...}");
}

/// Chunks of other types are left out, as the specification asks for.
void GlbDocument::read_data(ByteReader& reader) {
  if (left_ < 2 * kWordBytes) return;
  const std::uint64_t bytes = word(reader, "the length of the data");
  const std::uint32_t type = word(reader, "the type of the data");
  if (bytes > left_ - 2 * kWordBytes)
    fail("a chunk of the GLB file is longer than the file", reader.byte_place(),
         std::to_string(bytes), "at most " + std::to_string(left_ - 2 * kWordBytes));
  left_ -= 2 * kWordBytes;
  if (type != kBinChunk) return;
  chunk_ = read_bytes(reader, bytes, "data");
  left_ -= bytes;
}

/// Bytes behind the end are those of a damaged file, or of one that is larger than its header can
/// say.
void GlbDocument::check_end(ByteReader& reader) const {
  reader.skip(left_);
  if (reader.ensure(1))
    fail("the GLB file goes on after its end", reader.byte_place(), "",
         "the end after " + std::to_string(reader.offset()) + " bytes, as its header says");
}

void GlbDocument::read_buffers() {
  const Json* all = array(*json_, "buffers", "the document");
  for (std::uint64_t i = 0; all != nullptr && i < all->size(); ++i) {
    const Json& buffer = element("buffers", i, "buffers");
    const std::string place = in_brackets("buffers", i);
    const auto uri = buffer.find("uri");
    buffers_.emplace_back();
    if (uri == buffer.end() && i == 0) {
      buffers_.back() = std::move(chunk_);
    } else if (uri != buffer.end() && uri->is_string()) {
      buffers_.back() = buffer_of(uri->get_ref<const std::string&>(), place);
    }
  }
}

std::uint64_t GlbDocument::data_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& buffer : buffers_) bytes += buffer ? buffer->size() : 0;
  return bytes;
}

/// Of a URI with the data in it, or the name of a file beside this one.
std::vector<std::byte> GlbDocument::buffer_of(const std::string& uri,
                                              const std::string& place) const {
  constexpr std::string_view kData = "data:";
  constexpr std::string_view kBase64 = ";base64,";
  if (!uri.starts_with(kData)) return file_beside(uri, place);
  const std::size_t comma = uri.find(',');
  const std::size_t text = uri.find(kBase64);
  if (text == std::string::npos || comma != text + kBase64.size() - 1)
    fail("the data of a buffer are not read", place, excerpt(uri.substr(0, comma)),
         "data in base64");
  return decoded(std::string_view(uri).substr(comma + 1), place);
}

/// Only of the folder of this file: a mesh must not make the program read elsewhere.
std::vector<std::byte> GlbDocument::file_beside(const std::string& uri,
                                                const std::string& place) const {
  const std::filesystem::path here(file_);
  const std::optional<std::string> name = name_of_uri(uri);
  std::error_code failed;
  if (!name || !std::filesystem::is_regular_file(here, failed))
    fail("the data of a buffer are not read", place, excerpt(uri),
         "data in the file, or the name of a file in its folder", kOtherFile);
  const std::filesystem::path beside = here.parent_path() / *name;
  if (std::filesystem::exists(beside, failed) && !std::filesystem::is_regular_file(beside, failed))
    fail("the data of a buffer are not read", place, excerpt(uri), "a regular file");
  ByteReader reader(open_byte_source(beside));
  std::vector<std::byte> bytes;
  while (reader.ensure(1)) {
    bytes.insert(bytes.end(), reader.data(), reader.data() + reader.available());
    reader.consume(reader.available());
  }
  return bytes;
}

std::vector<std::byte> GlbDocument::decoded(std::string_view text, const std::string& place) const {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  while (text.ends_with('=')) text.remove_suffix(1);
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t digit = kDigits.find(text[i]);
    if (digit == std::string_view::npos)
      fail("the data of a buffer are damaged", place,
           "character " + std::to_string(i) + ": " + excerpt(text.substr(i, 1)),
           "a digit of base64");
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if (i % 4 != 0) bytes.push_back(static_cast<std::byte>(bits >> (6 - 2 * (i % 4))));
  }
  return bytes;
}

void GlbDocument::check_version() const {
  const Json* asset = object(*json_, "asset", "the document");
  if (asset == nullptr) fail("the GLB file has no asset", "the document", "", "\"asset\"");
  const auto minimum = asset->find("minVersion");
  const Json& version = minimum != asset->end() ? *minimum : asset->value("version", Json());
  if (!version.is_string() || !version.get_ref<const std::string&>().starts_with("2."))
    fail("the version of the GLB file is not known", "asset", text_of(version), "\"2.0\"",
         "Write it as glTF 2.0");
}

void GlbDocument::check_extensions() const {
  const Json* required = array(*json_, "extensionsRequired", "the document");
  if (required == nullptr) return;
  for (const Json& name : *required) {
    if (name.is_string() && is_known_extension(name.get_ref<const std::string&>())) continue;
    fail("the GLB file needs an extension that is not read", "extensionsRequired", text_of(name),
         "KHR_mesh_quantization, or an extension of materials alone", kOtherFile);
  }
}

bool GlbDocument::is_own() const {
  const auto asset = json_->find("asset");
  return asset != json_->end() && asset->value("generator", Json()) == "orbweave";
}

const GlbDocument::Json* GlbDocument::array(const Json& object, const char* key,
                                            const std::string& place) const {
  const auto at = object.find(key);
  if (at == object.end()) return nullptr;
  if (!at->is_array()) fail("a value has another type", place + "." + key, text_of(*at), "a list");
  return &*at;
}

const GlbDocument::Json* GlbDocument::object(const Json& object, const char* key,
                                             const std::string& place) const {
  const auto at = object.find(key);
  if (at == object.end()) return nullptr;
  if (!at->is_object())
    fail("a value has another type", place + "." + key, text_of(*at), "an object");
  return &*at;
}

std::optional<std::uint64_t> GlbDocument::number(const Json& object, const char* key,
                                                 const std::string& place) const {
  const auto at = object.find(key);
  if (at == object.end()) return std::nullopt;
  constexpr std::uint64_t kMost = std::uint64_t{1} << 48;  // sums and products stay in range
  if (!at->is_number_unsigned() || at->get<std::uint64_t>() > kMost)
    fail("a value has another type", place + "." + key, text_of(*at), "a whole number");
  return at->get<std::uint64_t>();
}

std::uint64_t GlbDocument::required_number(const Json& object, const char* key,
                                           const std::string& place) const {
  const std::optional<std::uint64_t> found = number(object, key, place);
  if (!found) fail("a value is missing", place, "", std::string("\"") + key + "\"");
  return *found;
}

const GlbDocument::Json& GlbDocument::element(const char* array_name, std::uint64_t index,
                                              const std::string& from) const {
  const Json* all = array(*json_, array_name, "the document");
  const std::size_t size = all == nullptr ? 0 : all->size();
  if (index >= size)
    fail("the GLB file names what is not there", from, in_brackets(array_name, index),
         "an index below " + std::to_string(size));
  const Json& found = (*all)[index];
  if (!found.is_object())
    fail("a value has another type", in_brackets(array_name, index), text_of(found), "an object");
  return found;
}

GlbNumbers GlbDocument::numbers(std::uint64_t index, const std::string& from) const {
  const Json& accessor = element("accessors", index, from);
  GlbNumbers numbers;
  numbers.place = in_brackets("accessors", index);
  if (accessor.contains("sparse"))
    fail("sparse numbers are not read", numbers.place, "\"sparse\"", "numbers in a buffer view",
         kOtherFile);
  numbers.count = required_number(accessor, "count", numbers.place);
  numbers.is_normalized = accessor.value("normalized", Json()) == true;
  numbers.component_type =
      static_cast<int>(required_number(accessor, "componentType", numbers.place));
  const Json type = accessor.value("type", Json());
  for (const ElementType& known : kElementTypes)
    if (type == known.name) numbers.components = known.components;
  if (numbers.components == 0)
    fail("the type of numbers is not known", numbers.place, text_of(type),
         "SCALAR, VEC2, VEC3 or VEC4");
  const std::optional<std::uint64_t> view = number(accessor, "bufferView", numbers.place);
  if (!view)
    fail("numbers without a buffer view are not read", numbers.place, "no bufferView",
         "numbers in a buffer view", kOtherFile);
  place_in_view(accessor, *view, numbers);
  return numbers;
}

void GlbDocument::place_in_view(const Json& accessor, std::uint64_t index,
                                GlbNumbers& numbers) const {
  const auto type = std::ranges::find(kComponentTypes, numbers.component_type,
                                      [](const ComponentType& known) { return known.number; });
  if (type == kComponentTypes.end())
    fail("the type of numbers is not known", numbers.place,
         "componentType " + std::to_string(numbers.component_type), "5120 to 5123, 5125 or 5126");
  const Json& view = element("bufferViews", index, numbers.place);
  const std::string place = in_brackets("bufferViews", index);
  const std::uint64_t buffer = required_number(view, "buffer", place);
  element("buffers", buffer, place);
  if (!buffers_[buffer])
    fail("numbers of a buffer that is nowhere", place, in_brackets("buffers", buffer),
         "a buffer with a uri, or the first one", kOtherFile);
  const std::vector<std::byte>& data = *buffers_[buffer];
  const std::uint64_t begin = number(view, "byteOffset", place).value_or(0);
  const std::uint64_t length = required_number(view, "byteLength", place);
  if (begin > data.size() || length > data.size() - begin)
    fail("a buffer view is longer than the data of the file", place,
         std::to_string(length) + " bytes from byte " + std::to_string(begin) + " on",
         "at most " + std::to_string(data.size()) + " bytes");
  const std::uint64_t element_bytes = type->bytes * static_cast<std::uint64_t>(numbers.components);
  const std::uint64_t offset = number(accessor, "byteOffset", numbers.place).value_or(0);
  const std::uint64_t stride = number(view, "byteStride", place).value_or(element_bytes);
  // Division, as a product of large numbers overflows.
  const bool fits =
      numbers.count == 0 ||
      (stride >= element_bytes && offset <= length && element_bytes <= length - offset &&
       numbers.count - 1 <= (length - offset - element_bytes) / stride);
  if (!fits)
    fail("numbers go beyond their buffer view", numbers.place,
         std::to_string(numbers.count) + " elements of " + std::to_string(element_bytes) +
             " bytes, " + std::to_string(stride) + " apart, from byte " + std::to_string(offset),
         "at most " + std::to_string(length) + " bytes");
  numbers.first = data.data() + begin + (numbers.count == 0 ? 0 : offset);
  numbers.stride = stride;
}

}  // namespace orbweave
