#include "io/ply/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <string_view>
#include <utility>

#include "io/error.h"
#include "io/text/counted_noun.h"

namespace orbweave {
namespace {

struct TypeName {
  std::string_view name;
  ScalarType type;
};
constexpr std::array<TypeName, 18> kTypeNames = {{{"char", ScalarType::kInt8},
                                                  {"int8", ScalarType::kInt8},
                                                  {"uchar", ScalarType::kUint8},
                                                  {"uint8", ScalarType::kUint8},
                                                  {"short", ScalarType::kInt16},
                                                  {"int16", ScalarType::kInt16},
                                                  {"ushort", ScalarType::kUint16},
                                                  {"uint16", ScalarType::kUint16},
                                                  {"int", ScalarType::kInt32},
                                                  {"int32", ScalarType::kInt32},
                                                  {"uint", ScalarType::kUint32},
                                                  {"uint32", ScalarType::kUint32},
                                                  {"int64", ScalarType::kInt64},
                                                  {"uint64", ScalarType::kUint64},
                                                  {"float", ScalarType::kFloat32},
                                                  {"float32", ScalarType::kFloat32},
                                                  {"double", ScalarType::kFloat64},
                                                  {"float64", ScalarType::kFloat64}}};

/// Blank-separated words of a header line.
std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return words;
    const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    line.remove_prefix(end);
  }
}

class HeaderParser {
 public:
  explicit HeaderParser(ByteReader& reader) : reader_(reader) {}

  PlyHeader parse() {
    skip_byte_order_mark(reader_);
    check_magic();
    std::string_view line;
    while (reader_.next_line(line)) {
      const std::vector<std::string_view> words = words_of(line);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") {
        if (!has_format_) fail("the PLY header has no format line", {}, "\"format ascii 1.0\"");
        return std::move(header_);
      }
      parse_line(line, words);
    }
    fail("the PLY header has no end", "the end of the file", "\"end_header\"");
  }

 private:
  [[noreturn]] void fail(const std::string& problem, std::string found,
                         std::string expected) const {
    throw_bad_input(problem, {.file = reader_.name(),
                              .place = reader_.line_place(),
                              .found = std::move(found),
                              .expected = std::move(expected)});
  }

  void check_magic() {
    // Looked at before it is read as a line: another kind of file may have no line ends at all.
    reader_.ensure(4);
    const std::string_view front(reinterpret_cast<const char*>(reader_.data()),
                                 std::min<std::size_t>(reader_.available(), 4));
    std::string_view line;
    if (front.substr(0, 3) == "ply" && reader_.next_line(line) && words_of(line).size() == 1 &&
        words_of(line)[0] == "ply")
      return;
    throw_bad_input("this is no PLY file", {.file = reader_.name(),
                                            .place = "line 1",
                                            .found = excerpt(line.empty() ? front : line),
                                            .expected = "\"ply\""});
  }

  void parse_line(std::string_view line, const std::vector<std::string_view>& words) {
    if (words[0] == "format") return parse_format(line, words);
    if (words[0] == "element") return parse_element(line, words);
    if (words[0] == "property") return parse_property(line, words);
    fail("unknown line in the PLY header", excerpt(line),
         "format, element, property, comment, obj_info or end_header");
  }

  void parse_format(std::string_view line, const std::vector<std::string_view>& words) {
    constexpr std::array<std::pair<std::string_view, PlyFormat>, 3> kFormats = {
        {{"ascii", PlyFormat::kAscii},
         {"binary_little_endian", PlyFormat::kBinaryLittleEndian},
         {"binary_big_endian", PlyFormat::kBinaryBigEndian}}};
    const auto at = std::find_if(kFormats.begin(), kFormats.end(), [&](const auto& format) {
      return words.size() > 1 && format.first == words[1];
    });
    if (at == kFormats.end() || words.size() != 3 || words[2] != "1.0" || has_format_)
      fail("bad format line in the PLY header", excerpt(line),
           "once \"format\", one of ascii, binary_little_endian and binary_big_endian, \"1.0\"");
    header_.format = at->second;
    has_format_ = true;
  }

  void parse_element(std::string_view line, const std::vector<std::string_view>& words) {
    std::uint64_t count = 0;
    const bool parsed = words.size() == 3 && [&] {
      const char* const last = words[2].data() + words[2].size();
      const auto [end, error] = std::from_chars(words[2].data(), last, count);
      return error == std::errc{} && end == last;
    }();
    if (!parsed)
      fail("bad element line in the PLY header", excerpt(line), "a name and a count of rows");
    if (header_.find(std::string(words[1])) != nullptr)
      fail("an element appears twice in the PLY header", excerpt(words[1]), "different names");
    header_.elements.push_back({std::string(words[1]), count, {}});
  }

  ScalarType parse_type(std::string_view name) const {
    const auto at = std::find_if(kTypeNames.begin(), kTypeNames.end(),
                                 [&](const TypeName& known) { return known.name == name; });
    if (at == kTypeNames.end())
      fail("unknown type in the PLY header", excerpt(name),
           "char, uchar, short, ushort, int, uint, float, double, or int8 to float64");
    return at->type;
  }

  void parse_property(std::string_view line, const std::vector<std::string_view>& words) {
    const bool is_list = words.size() > 1 && words[1] == "list";
    if (words.size() != (is_list ? 5U : 3U))
      fail("bad property line in the PLY header", excerpt(line),
           "a type and a name, or \"list\", two types and a name");
    if (header_.elements.empty())
      fail("a property before any element in the PLY header", excerpt(line), "an element line");
    PlyProperty property;
    property.name = std::string(words.back());
    property.is_list = is_list;
    property.type = parse_type(words[words.size() - 2]);
    if (is_list) property.count_type = parse_type(words[2]);
    if (is_list && (property.count_type == ScalarType::kFloat32 ||
                    property.count_type == ScalarType::kFloat64))
      fail("a list's count has no integer type", excerpt(line), "an integer type");
    std::vector<PlyProperty>& properties = header_.elements.back().properties;
    // Linear, but a header names a handful; the limit keeps a hostile one from being slow.
    constexpr std::size_t kPropertyLimit = 4096;
    if (properties.size() == kPropertyLimit)
      fail("too many properties in the PLY header", {}, "at most 4096 per element");
    if (std::any_of(properties.begin(), properties.end(),
                    [&](const PlyProperty& known) { return known.name == property.name; }))
      fail("a property appears twice in the PLY header", excerpt(property.name),
           "different names in one element");
    properties.push_back(std::move(property));
  }

  ByteReader& reader_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& property) { return property.is_list; });
}

std::size_t PlyElement::scalar_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties)
    if (!property.is_list) bytes += size_of(property.type);
  return bytes;
}

std::size_t PlyElement::least_row_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += size_of(property.is_list ? property.count_type : property.type);
  return bytes;
}

const PlyElement* PlyHeader::find(const std::string& element) const {
  const auto at = std::find_if(elements.begin(), elements.end(), [&](const PlyElement& candidate) {
    return candidate.name == element;
  });
  return at == elements.end() ? nullptr : &*at;
}

PlyHeader read_ply_header(ByteReader& reader) { return HeaderParser(reader).parse(); }

void check_ply_length(const ByteReader& reader, const PlyHeader& header) {
  const std::optional<std::uint64_t> left = reader.bytes_left();
  // Of text, the line that is wrong says more than the file's size.
  if (!left || header.format == PlyFormat::kAscii) return;
  std::uint64_t room = *left;
  for (const PlyElement& element : header.elements) {
    const std::size_t row = element.least_row_bytes();
    if (row == 0) continue;
    if (element.count > room / row)
      throw_bad_input("the file is shorter than its header says",
                      {.file = reader.name(),
                       .place = "element " + element.name,
                       .found = "room for " + counted_noun(room / row, "row", "rows"),
                       .expected = counted_noun(element.count, "row", "rows"),
                       .advice = "The file is truncated or its header's count is wrong."});
    room -= element.count * row;
  }
}

bool are_strips(const PlyElement& faces) { return faces.name == "tristrips"; }

std::optional<std::size_t> find_corner_list(const PlyElement& faces) {
  if (faces.name != "face" && !are_strips(faces)) return std::nullopt;
  for (std::size_t i = 0; i < faces.properties.size(); ++i) {
    const PlyProperty& property = faces.properties[i];
    if (property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index"))
      return i;
  }
  return std::nullopt;
}

}  // namespace orbweave
