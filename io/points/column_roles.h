// What programs call coordinates, normals and colours in the columns of their files.
#pragma once

#include <vector>

#include "io/points/point_rows.h"

namespace orbweave {

/// Gives three columns that are a place, a normal or a colour under names of other programs, in
/// upper or lower case, the names x, y, z, nx, ny, nz and red, green, blue. Left as they are: one
/// or two columns of three, and all where one of these names is there already.
void name_by_roles(std::vector<RowColumn>& columns);

}  // namespace orbweave
