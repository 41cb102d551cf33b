#include "io/clouds/e57/e57_document.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <pugixml.hpp>
#include <stdexcept>
#include <utility>

#include "io/error.h"
#include "io/streams/byte_reader.h"
#include "io/text/text_number.h"

namespace orbweave {
namespace {

constexpr std::string_view kNormalsPrefix = "nor:";
// What the addresses of extensions have in them, whatever prefix a file gives them.
constexpr std::string_view kNormalsAddress = "surface_normals";
constexpr std::string_view kLasAddress = "-las-v1";
constexpr std::string_view kLasPrefix = "las:";
constexpr int kDeepestPrototype = 8;
/// What the XML section and its elements may take in memory: a sixth of the least budget that a job
/// runs with. A file of two thousand scans with images and coordinate systems takes less.
constexpr std::uint64_t kMostXmlBytes = std::uint64_t{32} << 20;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

/// The elements of a document, with messages that say where they are.
class XmlReader {
 public:
  XmlReader(const E57Pages& pages, std::uint64_t begin) : pages_(pages), begin_(begin) {}

  [[noreturn]] void refuse(pugi::xml_node node, const std::string& problem,
                           std::string_view found = {}, const std::string& expected = {}) const {
    const std::uint64_t offset =
        static_cast<std::uint64_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
    throw_bad_input(problem, {.file = pages_.name(),
                              .place = pages_.place(begin_ + offset),
                              .found = found.empty() ? "" : excerpt(found),
                              .expected = expected});
  }

  double real(pugi::xml_node node, std::string_view text, double otherwise) const {
    text = trimmed(text);
    if (text.empty()) return otherwise;
    double value = 0.0;
    if (parse_number(text.data(), text.data() + text.size(), value) != text.data() + text.size())
      refuse(node, "the value of <" + name(node) + "> is no number", text, "a number");
    return value;
  }

  template <class Integer>
  Integer integer(pugi::xml_node node, const char* attribute, Integer otherwise) const {
    const std::string_view text = trimmed(node.attribute(attribute).value());
    if (text.empty()) return otherwise;
    Integer value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      refuse(node,
             "the attribute " + std::string(attribute) + " of <" + name(node) +
                 "> is no integer that fits",
             text, "an integer");
    return value;
  }

  /// The value of a number element of any type; an empty element is zero.
  double value(pugi::xml_node node) const {
    const double plain = real(node, node.text().get(), 0.0);
    if (std::string_view(node.attribute("type").value()) != "ScaledInteger") return plain;
    return plain * real(node, node.attribute("scale").value(), 1.0) +
           real(node, node.attribute("offset").value(), 0.0);
  }

  static std::string name(pugi::xml_node node) {
    const std::string quoted = excerpt(node.name());
    return quoted.substr(1, quoted.size() - 2);
  }

 private:
  const E57Pages& pages_;
  std::uint64_t begin_;  ///< logical offset of the section
};

void read_integer_limits(const XmlReader& xml, pugi::xml_node node, E57Field& field) {
  using Limits = std::numeric_limits<std::int64_t>;
  field.minimum = xml.integer<std::int64_t>(node, "minimum", Limits::min());
  field.maximum = xml.integer<std::int64_t>(node, "maximum", Limits::max());
  if (field.minimum > field.maximum)
    xml.refuse(node, "the minimum of the field is above its maximum", node.name());
  field.bits = static_cast<unsigned>(std::bit_width(static_cast<std::uint64_t>(field.maximum) -
                                                    static_cast<std::uint64_t>(field.minimum)));
}

E57Field read_field(const XmlReader& xml, pugi::xml_node node, const std::string& name) {
  const std::string_view type = node.attribute("type").value();
  E57Field field;
  field.name = name;
  if (type == "Float") {
    const bool is_single = std::string_view(node.attribute("precision").value()) == "single";
    field.kind = is_single ? E57Kind::kFloat32 : E57Kind::kFloat64;
    field.bits = is_single ? 32 : 64;
  } else if (type == "Integer" || type == "ScaledInteger") {
    field.kind = type == "Integer" ? E57Kind::kInteger : E57Kind::kScaledInteger;
    read_integer_limits(xml, node, field);
  } else if (type == "String") {
    field.kind = E57Kind::kString;
  } else {
    xml.refuse(node, "a field of a point has an impossible type", type,
               "Float, Integer, ScaledInteger or String");
  }
  if (field.kind == E57Kind::kScaledInteger) {
    field.scale = xml.real(node, node.attribute("scale").value(), 1.0);
    field.offset = xml.real(node, node.attribute("offset").value(), 0.0);
    if (!std::isfinite(field.scale) || field.scale == 0.0 || !std::isfinite(field.offset))
      xml.refuse(node, "a field has an impossible scale or offset", node.name(),
                 "a scale that is not 0");
  }
  return field;
}

/// What a file calls its extensions, with the colon.
struct Prefixes {
  std::string normals;
  std::string las;
};

/// The name of a field with the usual prefix of its extension.
std::string usual_name(const std::string& name, const Prefixes& prefixes) {
  for (const auto& [given, usual] : {std::pair(std::string_view(prefixes.normals), kNormalsPrefix),
                                     std::pair(std::string_view(prefixes.las), kLasPrefix)})
    if (name.starts_with(given)) return std::string(usual) + name.substr(given.size());
  return name;
}

/// Leaves in document order: that is the order of the byte streams.
void add_fields(const XmlReader& xml, pugi::xml_node parent, const Prefixes& prefixes, int depth,
                std::vector<E57Field>& fields) {
  if (depth > kDeepestPrototype) xml.refuse(parent, "the prototype of a point is nested too deep");
  for (const pugi::xml_node node : parent.children()) {
    if (node.type() != pugi::node_element) continue;
    const std::string_view type = node.attribute("type").value();
    if (type == "Structure" || type == "Vector") {
      add_fields(xml, node, prefixes, depth + 1, fields);
      continue;
    }
    std::string name = node.name();
    // What lies deeper belongs to an extension, whatever its name.
    if (depth > 0) name.insert(0, "/");
    fields.push_back(read_field(xml, node, usual_name(name, prefixes)));
  }
}

void check_codecs(const XmlReader& xml, pugi::xml_node codecs) {
  for (const pugi::xml_node codec : codecs.children())
    for (const pugi::xml_node part : codec.children())
      if (std::string_view(part.name()) != "inputs" &&
          std::string_view(part.name()) != "bitPackCodec")
        xml.refuse(part, "the points are compressed by an unknown codec", part.name(),
                   "bitPackCodec");
}

RigidMotion read_pose(const XmlReader& xml, pugi::xml_node pose) {
  const auto part = [&](const char* group, const char* axis, double otherwise) {
    const pugi::xml_node node = pose.child(group).child(axis);
    return node ? xml.value(node) : otherwise;
  };
  // A pose may leave out either part.
  const bool turns = static_cast<bool>(pose.child("rotation"));
  const std::array<double, 4> quaternion = {part("rotation", "x", 0.0), part("rotation", "y", 0.0),
                                            part("rotation", "z", 0.0),
                                            part("rotation", "w", turns ? 0.0 : 1.0)};
  const Vec3 translation = {part("translation", "x", 0.0), part("translation", "y", 0.0),
                            part("translation", "z", 0.0)};
  try {
    return motion_of_quaternion(quaternion, translation);
  } catch (const std::invalid_argument& reason) {
    xml.refuse(pose, "the pose of a scan is no rigid motion: " + std::string(reason.what()));
  }
}

std::optional<E57Limits> read_limits(const XmlReader& xml, pugi::xml_node limits,
                                     const std::string& name) {
  const pugi::xml_node low = limits.child((name + "Minimum").c_str());
  const pugi::xml_node high = limits.child((name + "Maximum").c_str());
  if (!low || !high) return std::nullopt;
  return E57Limits{xml.value(low), xml.value(high)};
}

/// Nothing where a bound is missing or no number: they are hints alone.
std::optional<Box> read_bounds(pugi::xml_node bounds) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    for (const auto& [end, value] :
         {std::pair("Minimum", &box.min), std::pair("Maximum", &box.max)}) {
      const std::string name = std::string(1, "xyz"[axis]) + end;
      const pugi::xml_node node = bounds.child(name.c_str());
      const std::string_view text = trimmed(node.text().get());
      const char* const last = text.data() + text.size();
      double number = 0.0;  // an empty element is zero
      if (!node || (!text.empty() && parse_number(text.data(), last, number) != last))
        return std::nullopt;
      (*value)[axis] = number;
    }
  }
  if (box.empty() || !is_finite(box.min) || !is_finite(box.max)) return std::nullopt;
  return box;
}

/// "Vendor Model", or what there is of it.
std::string read_sensor(pugi::xml_node node) {
  std::string sensor(trimmed(node.child("sensorVendor").text().get()));
  const std::string_view model = trimmed(node.child("sensorModel").text().get());
  if (!sensor.empty() && !model.empty()) sensor += ' ';
  return sensor.append(model);
}

void read_points(const XmlReader& xml, pugi::xml_node points, const Prefixes& prefixes,
                 E57Scan& scan) {
  if (std::string_view(points.attribute("type").value()) != "CompressedVector")
    xml.refuse(points, "the points of a scan have an impossible type",
               points.attribute("type").value(), "CompressedVector");
  for (const char* attribute : {"fileOffset", "recordCount"})
    if (points.attribute(attribute).empty())
      xml.refuse(points, "the points of a scan lack the attribute " + std::string(attribute));
  scan.section_offset = xml.integer<std::uint64_t>(points, "fileOffset", 0);
  scan.records = xml.integer<std::uint64_t>(points, "recordCount", 0);
  check_codecs(xml, points.child("codecs"));
  add_fields(xml, points.child("prototype"), prefixes, 0, scan.fields);
}

E57Scan read_scan(const XmlReader& xml, pugi::xml_node node, pugi::xml_node points,
                  const Prefixes& prefixes, std::size_t number) {
  E57Scan scan;
  scan.label = "scan " + std::to_string(number);
  const std::string_view name = node.child("name").text().get();
  if (!name.empty()) scan.label += " " + excerpt(name);
  scan.given_name = name;
  scan.sensor = read_sensor(node);
  read_points(xml, points, prefixes, scan);
  scan.bounds = read_bounds(node.child("cartesianBounds"));
  if (const pugi::xml_node pose = node.child("pose")) scan.pose = read_pose(xml, pose);
  const pugi::xml_node colors = node.child("colorLimits");
  scan.color_limits = {read_limits(xml, colors, "colorRed"), read_limits(xml, colors, "colorGreen"),
                       read_limits(xml, colors, "colorBlue")};
  if (const pugi::xml_node time = node.child("acquisitionStart").child("dateTimeValue"))
    scan.start_seconds = xml.value(time);
  return scan;
}

/// The prefix, with its colon, of the extension that has `part` in its address.
std::optional<std::string> find_prefix(pugi::xml_node root, std::string_view part) {
  constexpr std::string_view kDeclaration = "xmlns:";
  for (const pugi::xml_attribute attribute : root.attributes()) {
    const std::string_view name = attribute.name();
    if (name.starts_with(kDeclaration) &&
        std::string_view(attribute.value()).find(part) != std::string_view::npos)
      return std::string(name.substr(kDeclaration.size())) + ":";
  }
  return std::nullopt;
}

[[noreturn]] void refuse_large_xml(const E57Pages& pages, const std::string& found) {
  throw_bad_input(
      "the XML section of the E57 file is too large",
      {.file = pages.name(),
       .place = "byte 24",
       .found = found,
       .expected = "at most " + std::to_string(kMostXmlBytes >> 20) + " MiB of text and elements",
       .advice = "Write the scans to several files"});
}

/// What the parser will hold: the text, where names and values stay, and a node for every element
/// and every value, and one for every attribute. Never less than that for a text that is XML.
std::uint64_t bytes_of_tree(std::string_view text) {
  constexpr std::uint64_t kNodeBytes = 8 * sizeof(void*);
  constexpr std::uint64_t kAttributeBytes = 5 * sizeof(void*);
  std::uint64_t nodes = 0, attributes = 0;
  bool in_value = false;  // something but blanks since the last tag's end
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '<') {
      const bool closes = i + 1 < text.size() && text[i + 1] == '/';
      nodes += (closes ? 0 : 1) + (in_value ? 1 : 0);
    }
    if (c == '=') ++attributes;
    if (c == '<' || c == '>')
      in_value = false;
    else if (c != ' ' && c != '\t' && c != '\r' && c != '\n')
      in_value = true;
  }
  return text.size() + nodes * kNodeBytes + attributes * kAttributeBytes;
}

std::vector<char> read_section(E57Pages& pages, std::uint64_t begin) {
  const std::uint64_t bytes = pages.header().xml_bytes;
  if (bytes == 0 || bytes > pages.logical_bytes() - begin)
    throw_bad_input(
        "the XML section of the E57 file does not fit into the file",
        {.file = pages.name(),
         .place = "byte 32",
         .found = std::to_string(bytes) + " bytes",
         .expected = "1 to " + std::to_string(pages.logical_bytes() - begin) + " bytes"});
  if (bytes > kMostXmlBytes) refuse_large_xml(pages, std::to_string(bytes) + " bytes of text");
  std::vector<char> text(static_cast<std::size_t>(bytes));
  pages.read(begin, std::as_writable_bytes(std::span(text)));
  const std::uint64_t needed = bytes_of_tree({text.data(), text.size()});
  if (needed > kMostXmlBytes)
    refuse_large_xml(pages, std::to_string(bytes) + " bytes of text whose elements take " +
                                std::to_string(needed >> 20) + " MiB");
  return text;
}

}  // namespace

std::optional<std::size_t> E57Scan::find(std::string_view name) const {
  const auto at = std::find_if(fields.begin(), fields.end(),
                               [&](const E57Field& field) { return field.name == name; });
  if (at == fields.end()) return std::nullopt;
  return static_cast<std::size_t>(at - fields.begin());
}

E57Document read_e57_document(E57Pages& pages) {
  const std::uint64_t begin = pages.to_logical(pages.header().xml_offset, "the XML section");
  std::vector<char> text = read_section(pages, begin);
  pugi::xml_document tree;
  const pugi::xml_parse_result result =
      tree.load_buffer_inplace(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result)
    throw_bad_input(
        "the XML section of the E57 file is damaged: " + std::string(result.description()),
        {.file = pages.name(),
         .place = pages.place(begin + static_cast<std::uint64_t>(result.offset))});
  const XmlReader xml(pages, begin);
  const pugi::xml_node root = tree.child("e57Root");
  if (!root)
    xml.refuse(tree.document_element(), "the XML section has no element <e57Root>",
               tree.document_element().name());

  E57Document document;
  const auto text_of = [&](const char* child) {
    return std::string(trimmed(root.child(child).text().get()));
  };
  document.version = text_of("versionMajor") + "." + text_of("versionMinor");
  if (document.version.ends_with('.')) document.version += '0';  // an empty element is zero
  document.software = text_of("e57LibraryVersion");
  document.coordinate_system = trimmed(root.child("coordinateMetadata").text().get());
  const auto las_prefix = find_prefix(root, kLasAddress);
  const Prefixes prefixes = {
      find_prefix(root, kNormalsAddress).value_or(std::string(kNormalsPrefix)),
      las_prefix.value_or(std::string(kLasPrefix))};
  // The standard counts returns from 0. Converters from LAS, which leave its extension behind, copy
  // its numbers, and those count from 1.
  const int first_return = las_prefix ? 1 : 0;
  std::size_t number = 0;
  for (const pugi::xml_node node : root.child("data3D").children()) {
    if (node.type() != pugi::node_element) continue;
    ++number;
    const pugi::xml_node points = node.child("points");
    if (!points) continue;
    document.scans.push_back(read_scan(xml, node, points, prefixes, number));
    document.scans.back().first_return = first_return;
  }
  for (const pugi::xml_node node : root.child("images2D").children())
    if (node.type() == pugi::node_element) ++document.pictures;
  return document;
}

}  // namespace orbweave
