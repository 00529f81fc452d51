#pragma once

#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "benchmarks/report/chart.hpp"
#include "benchmarks/report/report_input.hpp"

namespace finegauge {

/// What the sections of one page share: numbers of figures, and how much of the page pictures have taken.
struct PageState {
  const std::vector<ReportDocument>& documents;
  int figures = 0;
  std::size_t picture_bytes = 0;
};

/// Numbered, with what it shows and the command that made its numbers. `body` and `caption` are HTML.
std::string figure_html(PageState& page, const std::string& body, const std::string& caption,
                        const std::string& command);
/// The same for a chart; nothing where it has nothing to draw.
std::string chart_figure(PageState& page, const Chart& chart, const std::string& caption, const std::string& command);
/// Figures side by side where there is room; nothing for none.
std::string figure_grid(const std::vector<std::string>& figures);

/// The SVG files beside a document that are its own: all that no other document of the same directory has by its name.
/// What the page draws itself from the same numbers, and what has no room, is named below them.
std::string pictures_html(PageState& page, const ReportDocument& document);

/// A heading with the document's anchor, its command, and whether it was a quick version or was interrupted.
std::string document_heading(const ReportDocument& document);
/// Failing checks as a table, the others to be opened. Nothing without checks.
std::string checks_html(const ReportDocument& document);
/// Objects as a table, nested ones by dotted names, for parts whose keys the page does not know; the rows and columns
/// that are too many are left out and said.
std::string records_html(const Json& records, std::size_t most_rows = 60, std::size_t most_columns = 16);
/// Names with their values, side by side.
std::string facts_html(const std::vector<std::pair<std::string, std::string>>& facts);
/// Any value for a table's cell.
std::string value_html(const Json& value);

// The sections; each is empty where no document has anything for it.
std::string summary_section(PageState& page);
std::string accuracy_section(PageState& page);
std::string certificate_section(PageState& page);  ///< of verify, the part of accuracy that is claims
std::string scenes_section(PageState& page);
std::string trade_section(PageState& page);
std::string audit_section(PageState& page);
std::string profile_section(PageState& page);
std::string atlas_section(PageState& page);
std::string budgets_section(PageState& page);
std::string environments_section(PageState& page);

}  // namespace finegauge
