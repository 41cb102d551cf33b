// Tiles of a survey as LAS files, and jobs of the program on them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace orbweave::test {

constexpr unsigned kUtm12 = 26912;
inline constexpr std::array<double, 3> kSalt{448'000.0, 4'511'000.0, 1300.0};

struct SurveyTile {
  unsigned epsg = kUtm12;  ///< 0: none is named
  int format = 2;
  std::array<double, 3> place = kSalt;
  std::uint16_t brightest = 65'535;
};

/// Ground of 24 x 24 points, 0.5 apart, coloured from black to `brightest`.
void write_tile(const std::filesystem::path& path, const SurveyTile& tile = {});

/// A run on scans of the directory, seen from above.
ProgramResult reconstruct(const ScratchDirectory& in, const std::vector<std::string>& scans,
                          const std::string& mesh, const std::vector<std::string>& more = {},
                          const std::vector<std::string>& environment = {});

/// The report r.json.
nlohmann::json report_of(const ScratchDirectory& in);

}  // namespace orbweave::test
