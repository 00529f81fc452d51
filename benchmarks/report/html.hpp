#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace finegauge {

/// Text as HTML and SVG show it: markup characters are written out, bytes that are no UTF-8 and control characters
/// become U+FFFD, so that no name or message of a result can change the page.
std::string html_escaped(std::string_view text);

/// A number for a reader: so many significant digits, the integer part whole with commas, "1.23×10⁻⁹" for the very
/// small and the very large, "–" for what is no number.
std::string number_text(double value, int digits = 3);
/// The same without zeros at the end: for what somebody has chosen, a bound or a tick.
std::string bound_text(double value, int digits = 4);
/// Whole numbers with all digits, others as number_text.
std::string count_text(double value);

struct TableColumn {
  std::string title;
  std::string unit = {};  ///< empty: none
  bool numeric = true;    ///< aligned right
};

/// Cells are HTML already.
struct HtmlTable {
  std::vector<TableColumn> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<bool> failing = {};  ///< rows that are marked; empty: none
};
/// With a frame of its own that scrolls sideways, so that a wide table does not widen the page.
std::string to_html(const HtmlTable& table);

/// A word with a mark that tells without colour.
std::string verdict_html(bool ok, std::string_view word);
/// A part that the reader opens. `summary` and `content` are HTML.
std::string details_html(const std::string& summary, const std::string& content, bool open = false);
std::string paragraph_html(std::string_view text);  ///< text is not HTML

}  // namespace finegauge
