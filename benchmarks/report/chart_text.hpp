#pragma once

#include <string>

namespace finegauge {

/// A coordinate of a drawing, to a tenth of a pixel.
std::string pixels(double value);
/// Words at a place, escaped; `style` is the class of the page's style sheet.
std::string chart_text(double x, double y, const std::string& style, const std::string& words);

}  // namespace finegauge
