#include <algorithm>
#include <cmath>

#include "benchmarks/report/html.hpp"
#include "benchmarks/report/section.hpp"

namespace finegauge {
namespace {

/// How a budget was judged: the documents' own word, by any of these keys.
std::string judged(const Json& one) {
  for (const char* key : {"judged", "how", "kind", "judge"})
    if (const std::string text = text_at(one, key); !text.empty()) return text;
  return {};
}

/// A budget's values in the documents so far, in the order of their starts; NaN in one that lacks it.
std::vector<double> history(const std::vector<const ReportDocument*>& gates, const std::string& name) {
  std::vector<double> values;
  for (const ReportDocument* gate : gates) {
    double value = std::numeric_limits<double>::quiet_NaN();
    for (const Json& one : gate->checks())
      if (one.at("name") == name) value = number_at(one, "value");
    values.push_back(value);
  }
  return values;
}

std::string budgets_of(PageState& page, const ReportDocument& document,
                       const std::vector<const ReportDocument*>& so_far) {
  std::vector<BoundedValue> bounded;
  HtmlTable table{{{"budget", "", false}, {"low"}, {"value"}, {"high"}, {"judged", "", false}}, {}};
  const bool with_history = so_far.size() > 1;
  if (with_history) table.columns.push_back({"history", "", false});
  std::vector<const Json*> checks;
  for (const Json& one : document.checks()) checks.push_back(&one);
  std::ranges::stable_partition(checks, [](const Json* one) { return !one->at("ok").get<bool>(); });
  for (const Json* one : checks) {
    const std::string name = one->at("name").get<std::string>();
    const bool ok = one->at("ok").get<bool>();
    const double low = number_at(*one, "low"), value = number_at(*one, "value"), high = number_at(*one, "high");
    if (std::isfinite(low) && std::isfinite(high)) bounded.push_back({name, low, value, high, ok});
    table.rows.push_back({verdict_html(ok, name), bound_text(low), "<b>" + number_text(value, 4) + "</b>",
                          bound_text(high), html_escaped(judged(*one))});
    table.failing.push_back(!ok);
    if (with_history) table.rows.back().push_back(sparkline_svg(name, history(so_far, name)));
  }
  std::string html;
  if (!bounded.empty())
    html += figure_html(page, bounds_html(document.name + ": budgets", bounded),
                        "Each budget between its bounds, breaches first: a dot within, a cross beyond. The number at "
                        "the right is the value.",
                        command_of(document));
  if (!table.rows.empty()) html += to_html(table);
  return html + (document.rows().empty() ? "" : details_html("What was measured", records_html(document.rows(), 200)));
}

}  // namespace

std::string budgets_section(PageState& page) {
  std::vector<const ReportDocument*> gates;  // ascending in their starts, as all documents are
  for (const ReportDocument& document : page.documents)
    if (document.kind == "gate") gates.push_back(&document);
  if (gates.empty()) return {};
  std::string html = document_heading(*gates.back()) + budgets_of(page, *gates.back(), gates);
  html += pictures_html(page, *gates.back());
  if (gates.size() == 1)
    return html + "<p class=\"aside\">One run of the gate: with several the table has each budget’s history.</p>\n";
  html += paragraph_html("The table above is of the latest run; its last column has all " +
                         std::to_string(gates.size()) + " in the order of their starts. The earlier ones:");
  for (auto gate = gates.rbegin() + 1; gate != gates.rend(); ++gate)
    html += document_heading(**gate) + checks_html(**gate);
  return html;
}

}  // namespace finegauge
