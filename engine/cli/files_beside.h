// What lies beside a mesh or a cloud: its coordinate system and the shift of its coordinates, which
// most formats have no place for.
#pragma once

#include <span>
#include <string>

#include "io/vec3.h"

namespace orbweave {

/// Writes both where there is anything to write. Warns of a system that PROJ does not know, and of
/// a .prj of that name that was there before and says nothing about this file. `in`: the file that
/// was read, as the warnings name it.
void write_files_beside(const std::string& file, const std::string& in, const std::string& system,
                        Vec3 origin);

/// Warns of each PLY file whose header says that its coordinates are counted from an origin, with
/// no shift beside it that says the same to a reader: it was renamed or moved alone.
void warn_of_lost_origins(std::span<const std::string> files);

}  // namespace orbweave
