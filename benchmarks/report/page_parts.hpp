#pragma once

namespace finegauge {

extern const char* const page_style;   ///< CSS: light and dark, narrow and wide, screen and print
extern const char* const page_script;  ///< values under the pointer; nothing on the page needs it

}  // namespace finegauge
