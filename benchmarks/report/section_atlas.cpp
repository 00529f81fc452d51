#include <algorithm>
#include <cmath>

#include "benchmarks/report/html.hpp"
#include "benchmarks/report/section.hpp"

namespace finegauge {
namespace {

std::string range_text(const Json* range) {
  if (!range) return "–";
  const double low = number_at(*range, "low"), high = number_at(*range, "high");
  return std::isfinite(low) && std::isfinite(high) ? number_text(low) + " to " + number_text(high) : "none";
}

/// The failures nearest to the usual value.
std::string first_failing(const Json& summary, const std::string& axis) {
  std::string text;
  if (const Json* failing = find_value(summary, "first_failing"); failing && failing->is_array())
    for (const Json& one : *failing)
      if (text_at(one, "axis") == axis)
        text +=
            (text.empty() ? "" : "; ") + ("at " + number_text(number_at(one, "value"))) + ": " + text_at(one, "why");
  return text.empty() ? "–" : text;
}

std::string axes_table(const ReportDocument& document) {
  const Json& summary = document.summary();
  HtmlTable table{{{"axis", "", false},
                   {"unit", "", false},
                   {"usual"},
                   {"sound"},
                   {"answered"},
                   {"tried"},
                   {"what is tried", "", false},
                   {"first failure", "", false}},
                  {}};
  const Json* axes = find_value(summary, "axes");
  if (!axes || !axes->is_object()) return {};
  for (const auto& [name, axis] : axes->items()) {
    const auto tried =
        std::ranges::count_if(document.rows(), [&](const Json& row) { return text_at(row, "axis") == name; });
    const Json *safe = find_value(summary, "safe"), *answered = find_value(summary, "answered");
    table.rows.push_back({html_escaped(name), html_escaped(text_at(axis, "unit")),
                          number_text(number_at(axis, "normal")), range_text(safe ? find_value(*safe, name) : nullptr),
                          range_text(answered ? find_value(*answered, name) : nullptr),
                          count_text(static_cast<double>(tried)), html_escaped(text_at(axis, "about")),
                          html_escaped(first_failing(summary, name))});
  }
  return table.rows.empty() ? "" : to_html(table);
}

}  // namespace

std::string atlas_section(PageState& page) {
  std::string html;
  for (const ReportDocument& document : page.documents) {
    if (document.kind != "atlas") continue;
    html += document_heading(document) + pictures_html(page, document);
    if (!find_value(document.summary(), "safe"))
      html += "<p class=\"aside\">Not all values of the axes were tried, so the document has no limits.</p>\n";
    const std::string table = axes_table(document);
    html += (table.empty() ? records_html(document.rows(), 200) : table) + checks_html(document);
  }
  return html;
}

}  // namespace finegauge
