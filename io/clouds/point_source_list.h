// Several files as one point source.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/points/point_source.h"

namespace orbweave {

/// Opens one file of several; an empty one stands for open_point_source with no options.
using PointSourceOpener =
    std::function<std::unique_ptr<PointSource>(const std::filesystem::path& path)>;

/// Several files as one stream, in the order given. Its schema carries every attribute of every
/// file, each of a type that fits all files that have it; points of a file that lacks one get 0,
/// and `notes` gets a line. A mixture of files with and without normals, or in different coordinate
/// systems, is an error (bad input).
std::unique_ptr<PointSource> open_point_sources(const std::vector<std::filesystem::path>& paths,
                                                const PointSourceOpener& opener = {},
                                                std::vector<std::string>* notes = nullptr);

}  // namespace orbweave
