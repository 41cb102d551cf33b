// The formats of clouds and meshes: one table of extensions, of what is read and of what is
// written.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace orbweave {

enum class FileFormat {
  kPly,
  kObj,
  kStl,
  kXyz,
  kXyzn,
  kXyzrgb,
  kAsc,
  kTxt,
  kCsv,
  kPts,
  kPtx,
  kPcd,
  kLas,
  kLaz,
  kE57,
  kGlb,
  kGltf,
  kVtp,
  kXdmf
};

/// What a format can hold and what the program does with files of the format. Every format that is
/// read is read as a cloud.
struct FormatFacts {
  FileFormat format;
  std::string_view extension;
  bool may_be_gzipped;  ///< read with a further ".gz"
  bool holds_faces;     ///< read as a mesh, where it is read
  bool writes_mesh;
  bool writes_cloud;
  bool writes_gzip;
  bool is_read = true;
};

inline constexpr std::array kFileFormats = {
    FormatFacts{FileFormat::kPly, ".ply", true, true, true, true, true},
    FormatFacts{FileFormat::kXyz, ".xyz", true, false, false, true, true},
    FormatFacts{FileFormat::kXyzn, ".xyzn", true, false, false, false, false},
    FormatFacts{FileFormat::kXyzrgb, ".xyzrgb", true, false, false, false, false},
    FormatFacts{FileFormat::kAsc, ".asc", true, false, false, false, false},
    FormatFacts{FileFormat::kTxt, ".txt", true, false, false, false, false},
    FormatFacts{FileFormat::kCsv, ".csv", true, false, false, true, true},
    FormatFacts{FileFormat::kPts, ".pts", true, false, false, false, false},
    FormatFacts{FileFormat::kPtx, ".ptx", true, false, false, false, false},
    FormatFacts{FileFormat::kPcd, ".pcd", true, false, false, false, false},
    FormatFacts{FileFormat::kObj, ".obj", true, true, true, false, false},
    FormatFacts{FileFormat::kStl, ".stl", true, true, true, false, false},
    FormatFacts{FileFormat::kGlb, ".glb", true, true, true, false, false},
    FormatFacts{FileFormat::kGltf, ".gltf", true, true, false, false, false},
    FormatFacts{FileFormat::kVtp, ".vtp", false, true, true, false, false, false},
    FormatFacts{FileFormat::kXdmf, ".xdmf", false, true, true, false, false, false},
    FormatFacts{FileFormat::kLas, ".las", false, false, false, false, false},
    FormatFacts{FileFormat::kLaz, ".laz", false, false, false, false, false},
    FormatFacts{FileFormat::kE57, ".e57", false, false, false, false, false}};

/// A name taken apart.
struct NamedFormat {
  FormatFacts facts;
  bool is_gzipped = false;
};

/// The format that a name stands for, by its extension in any case, with or without ".gz". Nothing
/// for another extension and for a name that is an extension alone.
std::optional<NamedFormat> format_of_name(const std::filesystem::path& path);

/// Whether files of that name hold the place of their origin themselves: GLB, in a node.
bool holds_origin(const std::filesystem::path& path);

/// Whether files of a format of meshes hold numbers as bytes alone.
bool has_no_text(FileFormat format);

/// For messages: "GLB".
std::string spoken_name(const FormatFacts& format);

/// For messages: ".foo meshes" of "a.foo" and "meshes"; "meshes whose name has no extension".
std::string files_of_name(const std::filesystem::path& path, const std::string& kind);

/// ".ply[.gz], .obj or .stl": the extensions of the formats that `wanted` is true for, for
/// messages.
/// "[.gz]" stands behind those that `with_gzip` is true for.
std::string listed_extensions(bool (*wanted)(const FormatFacts&),
                              bool (*with_gzip)(const FormatFacts&));

/// What each use of a file takes, for messages.
std::string extensions_of_written_meshes();
std::string extensions_of_written_clouds();
std::string extensions_of_read_meshes();
std::string extensions_of_read_clouds();

}  // namespace orbweave
