#include <algorithm>
#include <cmath>
#include <map>

#include "benchmarks/report/html.hpp"
#include "benchmarks/report/section.hpp"

namespace finegauge {
namespace {

std::vector<double> percent(std::vector<double> shares) {
  for (double& share : shares) share *= 100.0;
  return shares;
}

std::vector<double> column(const std::vector<const Json*>& rows, const std::string& key) {
  std::vector<double> values;
  for (const Json* row : rows) values.push_back(number_at(*row, key));
  return values;
}

/// Rows by scheme, in the order of first appearance.
std::vector<std::pair<std::string, std::vector<const Json*>>> schemes_of(const Json& rows) {
  std::vector<std::pair<std::string, std::vector<const Json*>>> schemes;
  for (const Json& row : rows) {
    const std::string name = text_at(row, "scheme");
    auto found = std::ranges::find(schemes, name, &std::pair<std::string, std::vector<const Json*>>::first);
    if (found == schemes.end()) found = schemes.insert(schemes.end(), {name, {}});
    found->second.push_back(&row);
  }
  return schemes;
}

std::string slope_text(const ReportDocument& document, const std::string& scheme, const std::string& quantity) {
  const double slope = number_at(document.summary(), "slopes." + scheme + "." + quantity);
  return std::isfinite(slope) ? ", slope −" + number_text(std::abs(slope)) : "";
}

/// A quantity over degrees of freedom, a curve per scheme.
Chart over_dofs(const ReportDocument& document, const std::string& key, const std::string& label, bool share,
                bool log_y) {
  Chart chart{.title = document.name + ": " + label,
              .x_label = "degrees of freedom",
              .y_label = label,
              .log_x = true,
              .log_y = log_y,
              .nearest_point = true};
  for (const auto& [scheme, rows] : schemes_of(document.rows())) {
    std::vector<double> values = column(rows, key);
    chart.series.push_back({.label = (scheme.empty() ? document.name : scheme) + slope_text(document, scheme, key),
                            .x = column(rows, "dofs"),
                            .y = share ? percent(std::move(values)) : std::move(values),
                            .points = true});
  }
  return chart;
}

bool has_steps_over_dofs(const ReportDocument& document) {
  return !document.rows().empty() && !find_value(document.rows().front(), "time") &&
         std::isfinite(number_at(document.rows().front(), "dofs")) &&
         std::isfinite(number_at(document.rows().front(), "eta"));
}

std::string convergence(PageState& page, const ReportDocument& document) {
  if (!has_steps_over_dofs(document)) return {};
  const std::string by = command_of(document);
  std::vector<std::string> figures;
  const auto add = [&](const Chart& chart, const std::string& caption) {
    if (std::string figure = chart_figure(page, chart, caption, by); !figure.empty())
      figures.push_back(std::move(figure));
  };
  Chart eta = over_dofs(document, "eta", "estimated error η [%]", true, true);
  if (const auto& rows = schemes_of(document.rows()); rows.size() == 1) {
    const std::vector<double> low = percent(column(rows[0].second, "error_low")),
                              high = percent(column(rows[0].second, "error_high"));
    if (std::ranges::any_of(low, [](double value) { return std::isfinite(value); }))
      eta.bands.push_back({"certified range of the true error", column(rows[0].second, "dofs"), low, high, 2});
  }
  add(eta,
      eta.bands.empty()
          ? "Estimated relative error in the energy norm over degrees of freedom, both logarithmic: steeper is better."
          : "Estimated relative error in the energy norm, and the range in which the certificate puts the true one.");
  add(over_dofs(document, "true_error", "true error [%]", true, true),
      "True relative error, from the strain energy of the exact solution: where the estimate above promises more than "
      "this, it is wrong.");
  Chart effectivity = over_dofs(document, "effectivity", "estimated over true error", false, false);
  if (drawable(effectivity)) effectivity.rules.push_back({1.0, "the error as it is"});
  add(effectivity, "Effectivity: 1 is a perfect estimate, below 1 the error is larger than told.");
  add(over_dofs(document, "total_ms", "time of the step [ms]", false, true),
      "Wall time of each step, all its stages: topology, assembly, solve, estimate and marks.");
  return figure_grid(figures);
}

/// Paper, here, why: as `finegauge reproduce` prints it.
std::string comparison(const ReportDocument& document) {
  const Json* rows = find_value(document.summary(), "comparison");
  if (!rows || !rows->is_array() || rows->empty())
    return "<p class=\"aside\">The document holds no table of paper against here.</p>\n";
  HtmlTable table{{{"quantity", "", false}, {"paper", "", false}, {"here", "", false}, {"why they differ", "", false}},
                  {}};
  const bool places = std::ranges::any_of(*rows, [](const Json& row) { return !text_at(row, "place").empty(); });
  if (places) table.columns.push_back({"where in the paper", "", false});
  for (const Json& row : *rows) {
    const auto cell = [&](const char* key) { return html_escaped(text_at(row, key)); };
    table.rows.push_back(
        {cell("quantity"), "<b>" + cell("paper") + "</b>", "<b>" + cell("here") + "</b>", cell("why")});
    if (places) table.rows.back().push_back(cell("place"));
  }
  const std::string note = text_at(document.summary(), "comparison_note");
  return (note.empty() ? "" : paragraph_html(note)) + to_html(table);
}

/// How far the true error is known of a run, or why it is not.
std::string certified(const ReportDocument& document) {
  if (document.rows().empty()) return {};
  const Json& last = document.rows().back();
  const double low = number_at(last, "error_low"), high = number_at(last, "error_high");
  if (std::isfinite(low) && std::isfinite(high))
    return "<p>Certified: at the end the true error is between <b>" + number_text(100 * low) + " %</b> and <b>" +
           number_text(100 * high) + " %</b> of the solution’s energy norm; the estimate is " +
           number_text(100 * number_at(last, "eta")) + " %.</p>\n";
  const std::string why = text_at(last, "error_low_reason");
  return why.empty() ? "" : "<p>Not certified: " + html_escaped(why) + ".</p>\n";
}

HtmlTable claims_table() {
  return {{{"claim", "", false}, {"value"}, {"low"}, {"high"}, {"reason of the bounds", "", false}}, {}};
}

void add_claim(const Json& row, HtmlTable& table) {
  const bool ok = row.value("ok", Json(false)) == true;
  table.rows.push_back({verdict_html(ok, text_at(row, "study") + ": " + text_at(row, "claim")),
                        number_text(number_at(row, "value"), 4), bound_text(number_at(row, "low")),
                        bound_text(number_at(row, "high")), html_escaped(text_at(row, "reason"))});
  table.failing.push_back(!ok);
}

std::string evidence_table(const Json& table) {
  HtmlTable html;
  const Json* columns = find_value(table, "columns");
  const Json* rows = find_value(table, "rows");
  if (!columns || !rows || !columns->is_array() || !rows->is_array()) return {};
  for (std::size_t c = 0; c < columns->size(); ++c) {
    const bool numeric = std::ranges::any_of(
        *rows, [&](const Json& row) { return row.is_array() && c < row.size() && row[c].is_number(); });
    html.columns.push_back({(*columns)[c].is_string() ? (*columns)[c].get<std::string>() : "", "", numeric});
  }
  for (const Json& row : *rows) {
    if (!row.is_array()) continue;
    std::vector<std::string>& cells = html.rows.emplace_back();
    for (const Json& value : row) cells.push_back(value_html(value));
  }
  return "<h4>" + html_escaped(text_at(table, "title")) + "</h4>\n" + to_html(html);
}

/// Groups of claims with their counts, those that fail first.
std::string claims_by_factor(const ReportDocument& document) {
  std::vector<std::string> factors;
  std::map<std::string, std::vector<const Json*>> claims;
  for (const Json& row : document.rows()) {
    const std::string factor = text_at(row, "factor");
    if (!claims.contains(factor)) factors.push_back(factor);
    claims[factor].push_back(&row);
  }
  const auto fails = [](const Json* row) { return row->value("ok", Json(false)) != true; };
  const auto failing_of = [&](const std::string& factor) { return std::ranges::count_if(claims.at(factor), fails); };
  std::ranges::stable_sort(factors, [&](const auto& a, const auto& b) { return failing_of(a) > failing_of(b); });
  HtmlTable counts{{{"credibility factor (ASME V&V 40)", "", false}, {"claims"}, {"hold"}, {"fail"}}, {}},
      failing = claims_table();
  std::string opened;
  for (const std::string& factor : factors) {
    const auto all = static_cast<double>(claims.at(factor).size()), bad = static_cast<double>(failing_of(factor));
    counts.rows.push_back({html_escaped(factor), count_text(all), count_text(all - bad),
                           bad > 0 ? "<b>" + count_text(bad) + "</b>" : "0"});
    counts.failing.push_back(bad > 0);
    HtmlTable table = claims_table();
    for (const Json* row : claims.at(factor)) add_claim(*row, fails(row) ? failing : table);
    if (!table.rows.empty())
      opened += details_html("The " + count_text(all - bad) + " claims on " + html_escaped(factor) + " that hold",
                             to_html(table));
  }
  return (failing.rows.empty() ? "" : to_html(failing)) + to_html(counts) + opened;
}

}  // namespace

std::string accuracy_section(PageState& page) {
  std::string html;
  for (const ReportDocument& document : page.documents) {
    if (document.kind == "reproduce") {
      html += document_heading(document) + comparison(document) + convergence(page, document);
      // The cases of moving studies are shown with their curves among the scenes.
      const bool moving = !document.rows().empty() && find_value(document.rows().front(), "curve");
      html += (moving ? "" : pictures_html(page, document)) + checks_html(document);
    } else if (document.kind == "run" && has_steps_over_dofs(document)) {
      html += document_heading(document) + certified(document) + convergence(page, document);
      html += pictures_html(page, document) + checks_html(document);
    }
  }
  return html;
}

std::string certificate_section(PageState& page) {
  std::string html;
  for (const ReportDocument& document : page.documents) {
    if (document.kind != "verify") continue;
    html += document_heading(document) + claims_by_factor(document);
    const Json* studies = find_value(document.summary(), "studies");
    if (!studies || !studies->is_object()) continue;
    for (const auto& [name, study] : studies->items()) {
      if (const std::string failure = text_at(study, "failure"); !failure.empty())
        html += "<p class=\"fail\">✗ " + html_escaped(name + ": " + failure) + "</p>\n";
      const Json* tables = find_value(study, "tables");
      if (!tables || !tables->is_array()) continue;
      std::string inner;
      for (const Json& table : *tables) inner += evidence_table(table);
      // The estimator's ladder is what a certified range of the true error rests on.
      if (!inner.empty())
        html += details_html(html_escaped(name) + " <small>" + html_escaped(text_at(study, "factor")) + "</small>",
                             inner, name == "estimator");
    }
  }
  return html;
}

}  // namespace finegauge
