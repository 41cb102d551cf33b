#include "io/meshes/glb_document.h"

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/error.h"
#include "io/shown_text.h"
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
  read_header(reader);
  read_document(reader);
  read_data(reader);
  check_version();
  check_extensions();
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
  if (!reader.ensure(kWordBytes) || load_little<std::uint32_t>(reader.data()) != kMagic)
    fail("this is no GLB file", "byte 0", "other bytes", "\"glTF\"",
         "A .gltf file has its numbers beside it: write it as one .glb file");
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
  const char* first = reinterpret_cast<const char*>(text.data());
  json_ = std::make_unique<Json>(Json::parse(first, first + text.size(), nullptr, false));
  if (!json_->is_object())
    fail("the document of the GLB file is no JSON object", "byte 20",
         excerpt({first, std::min<std::size_t>(text.size(), 40)}), "{\"asset\": ...}");
}

/// Chunks of other types are left out, as the specification asks for.
void GlbDocument::read_data(ByteReader& reader) {
  if (left_ < 2 * kWordBytes) return;
  const std::uint64_t bytes = word(reader, "the length of the data");
  const std::uint32_t type = word(reader, "the type of the data");
  if (bytes > left_ - 2 * kWordBytes)
    fail("a chunk of the GLB file is longer than the file", reader.byte_place(),
         std::to_string(bytes), "at most " + std::to_string(left_ - 2 * kWordBytes));
  if (type == kBinChunk) data_ = read_bytes(reader, bytes, "data");
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
  if (buffer != 0 || element("buffers", buffer, place).contains("uri"))
    fail("numbers outside of the GLB file are not read", place, in_brackets("buffers", buffer),
         "the first buffer, without a uri", kOtherFile);
  const std::uint64_t begin = number(view, "byteOffset", place).value_or(0);
  const std::uint64_t length = required_number(view, "byteLength", place);
  if (begin > data_.size() || length > data_.size() - begin)
    fail("a buffer view is longer than the data of the file", place,
         std::to_string(length) + " bytes from byte " + std::to_string(begin) + " on",
         "at most " + std::to_string(data_.size()) + " bytes");
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
  numbers.first = data_.data() + begin + (numbers.count == 0 ? 0 : offset);
  numbers.stride = stride;
}

}  // namespace orbweave
