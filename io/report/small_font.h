// A font of 5 x 9 dots for the few words in a picture: lower case, digits and marks.
#pragma once

#include <string_view>

namespace orbweave {

inline constexpr int kGlyphWidth = 5;   ///< dots; one more lies between two glyphs
inline constexpr int kGlyphHeight = 9;  ///< dots, two of them below the line

/// Whether a dot of the glyph is ink; x from the left, y from the top, within the glyph. Upper case
/// is drawn as lower case, what the font does not have as a space.
bool has_ink(char character, int x, int y);

}  // namespace orbweave
