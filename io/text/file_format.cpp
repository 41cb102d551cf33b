#include "io/text/file_format.h"

#include <vector>

#include "io/text/lower_case.h"

namespace orbweave {
namespace {

constexpr std::string_view kGzip = ".gz";

bool is_read_with_gzip(const FormatFacts& facts) { return facts.may_be_gzipped; }
bool is_written_with_gzip(const FormatFacts& facts) { return facts.writes_gzip; }

}  // namespace

std::optional<NamedFormat> format_of_name(const std::filesystem::path& path) {
  std::string name = lower_case(path.filename().string());
  const bool is_gzipped = name.ends_with(kGzip);
  if (is_gzipped) name.resize(name.size() - kGzip.size());
  for (const FormatFacts& facts : kFileFormats) {
    const bool is_it = name.size() > facts.extension.size() && name.ends_with(facts.extension);
    if (is_it) return NamedFormat{facts, is_gzipped};
  }
  return std::nullopt;
}

bool holds_origin(const std::filesystem::path& path) {
  const std::optional<NamedFormat> named = format_of_name(path);
  return named && named->facts.format == FileFormat::kGlb;
}

bool has_no_text(FileFormat format) {
  return format == FileFormat::kGlb || format == FileFormat::kVtp || format == FileFormat::kXdmf;
}

std::string spoken_name(const FormatFacts& format) {
  std::string name(format.extension.substr(1));
  for (char& c : name)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return name;
}

std::string files_of_name(const std::filesystem::path& path, const std::string& kind) {
  std::string extension = lower_case(path.extension().string());
  if (extension == kGzip) extension = lower_case(path.stem().extension().string()) + extension;
  return extension.empty() ? kind + " whose name has no extension" : extension + " " + kind;
}

std::string listed_extensions(bool (*wanted)(const FormatFacts&),
                              bool (*with_gzip)(const FormatFacts&)) {
  std::vector<std::string> names;
  for (const FormatFacts& facts : kFileFormats) {
    if (!wanted(facts)) continue;
    names.emplace_back(facts.extension);
    if (with_gzip(facts)) names.back() += "[.gz]";
  }
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

std::string extensions_of_written_meshes() {
  return listed_extensions([](const FormatFacts& facts) { return facts.writes_mesh; },
                           is_written_with_gzip);
}

std::string extensions_of_written_clouds() {
  return listed_extensions([](const FormatFacts& facts) { return facts.writes_cloud; },
                           is_written_with_gzip);
}

std::string extensions_of_read_meshes() {
  return listed_extensions(
      [](const FormatFacts& facts) { return facts.holds_faces && facts.is_read; },
      is_read_with_gzip);
}

std::string extensions_of_read_clouds() {
  return listed_extensions([](const FormatFacts& facts) { return facts.is_read; },
                           is_read_with_gzip);
}

}  // namespace orbweave
