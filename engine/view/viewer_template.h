// The page of the viewer, without a mesh. Its source is viewer_page.html.
#pragma once

#include <string_view>

namespace orbweave {

extern const std::string_view kViewerTemplate;

}  // namespace orbweave
