// The viewer, without a mesh. Its sources are viewer_page.html and viewer*.js.
#pragma once

#include <string_view>

namespace orbweave {

extern const std::string_view kViewerTemplate;     ///< the page, without data and scripts
extern const std::string_view kViewerScript;       ///< of both pages
extern const std::string_view kViewerMeshScript;   ///< after it: shows the mesh in the page
extern const std::string_view kViewerTilesScript;  ///< or: shows the tiles beside the page

}  // namespace orbweave
