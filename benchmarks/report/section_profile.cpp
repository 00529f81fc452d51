#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "benchmarks/report/html.hpp"
#include "benchmarks/report/section.hpp"

namespace finegauge {
namespace {

std::string stages(PageState& page, const ReportDocument& document) {
  std::vector<std::string> names;
  BarPanel median{"p50 [ms]", {}}, tail{"p99 [ms]", {}}, share{"share of the frame [%]", {}};
  for (const Json& row : document.rows()) {
    const std::string stage = text_at(row, "stage");
    if (stage.empty()) continue;
    names.push_back(stage);
    median.values.push_back(number_at(row, "p50_ms"));
    tail.values.push_back(number_at(row, "p99_ms"));
    share.values.push_back(100.0 * number_at(row, "share"));
  }
  if (names.empty()) return {};
  return figure_html(page, bar_panels_html(document.name + ": stages of a frame", names, {share, median, tail}),
                     "Where a frame’s time goes, stage by stage: its share of the frame, and its median and 99th "
                     "percentile over the frames.",
                     command_of(document));
}

/// A record's texts (pattern, template), which tell whose curve it is on.
std::string group_of(const Json& record) {
  std::string group;
  for (const auto& [key, value] : record.items())
    if (value.is_string() && !key.ends_with("_reason")) group += (group.empty() ? "" : ", ") + value.get<std::string>();
  return group;
}

/// The key of the records that a ledger is drawn over; empty where there is none.
std::string ledger_axis(const Json& records) {
  for (const char* key : {"refined_share", "share_refined", "refined_fraction", "refined"})
    if (std::ranges::any_of(records, [&](const Json& r) { return std::isfinite(number_at(r, key)); })) return key;
  return {};
}

/// Curves of the keys that are wanted, by `label` of record and key, over the ledger's axis.
Chart ledger_chart(const std::string& title, const Json& records, const std::string& y_label, bool log_y, double factor,
                   const std::function<std::string(const Json&, const std::string&)>& label) {
  Chart chart{.title = title, .x_label = {}, .y_label = y_label, .log_y = log_y, .nearest_point = true};
  const std::string x = ledger_axis(records);
  if (x.empty()) return chart;
  const bool fraction = std::ranges::none_of(records, [&](const Json& r) { return number_at(r, x) > 1.0; });
  chart.x_label = fraction ? "refined share of the cells [%]" : "refined cells";
  for (const Json& record : records)
    for (const auto& [key, value] : record.items()) {
      const std::string name = value.is_number() && key != x ? label(record, key) : std::string();
      if (name.empty()) continue;
      auto series = std::ranges::find(chart.series, name, &ChartSeries::label);
      if (series == chart.series.end())
        series = chart.series.insert(chart.series.end(), {.label = name, .x = {}, .y = {}, .points = true});
      series->x.push_back(number_at(record, x) * (fraction ? 100.0 : 1.0));
      series->y.push_back(factor * value.get<double>());
    }
  return chart;
}

/// The ledger of hanging nodes: single values, and lists of records as tables and curves.
std::string ledger(PageState& page, const ReportDocument& document, const Json& tjunctions) {
  std::vector<std::pair<std::string, std::string>> facts;
  std::string lists;
  const std::string by = command_of(document);
  const auto add_list = [&](const std::string& name, const Json& records) {
    std::vector<std::string> figures;
    const auto add = [&](const Chart& chart, const std::string& caption) {
      if (std::string figure = chart_figure(page, chart, caption, by); !figure.empty())
        figures.push_back(std::move(figure));
    };
    add(ledger_chart(name + ": hanging nodes", records, "hanging nodes [%]", false, 100.0,
                     [](const Json& record, const std::string& key) {
                       const bool wanted = key.find("hanging") != std::string::npos && key.ends_with("share");
                       return wanted ? group_of(record).empty() ? key : group_of(record) : std::string();
                     }),
        "Share of the nodes that hang, as more of the mesh is refined.");
    std::vector<std::string> groups;
    for (const Json& record : records)
      if (std::ranges::find(groups, group_of(record)) == groups.end()) groups.push_back(group_of(record));
    for (const std::string& group : groups)
      add(ledger_chart(name + ": time, " + group, records, "time [ms]", true, 1.0,
                       [&](const Json& record, const std::string& key) {
                         const bool wanted = key.ends_with("_ms") && group_of(record) == group;
                         return wanted ? key.substr(0, key.size() - 3) : std::string();
                       }),
          "<b>" + html_escaped(group.empty() ? name : group) +
              ".</b> What handling the hanging nodes costs, each way.");
    lists += "<h4>" + html_escaped(name) + "</h4>\n" + figure_grid(figures) + records_html(records, 100);
  };
  if (tjunctions.is_array()) add_list("T-junction ledger", tjunctions);
  if (tjunctions.is_object())
    for (const auto& [key, value] : tjunctions.items()) {
      if (key.ends_with("_reason")) continue;
      if (value.is_array() && !value.empty() && value[0].is_object())
        add_list(key, value);
      else if (value.is_object())
        lists += "<h4>" + html_escaped(key) + "</h4>\n" + records_html(Json::array({value}));
      else
        facts.emplace_back(key, value_html(value));
    }
  const std::string content = facts_html(facts) + lists;
  return content.empty() ? content : "<h4>The ledger of hanging nodes</h4>\n" + content;
}

}  // namespace

std::string profile_section(PageState& page) {
  std::string html;
  for (const ReportDocument& document : page.documents) {
    const Json* tjunctions = find_value(document.summary(), "tjunctions");
    if (document.kind == "profile") {
      html += document_heading(document) + stages(page, document) + records_html(document.rows(), 100);
      html += tjunctions ? ledger(page, document, *tjunctions)
                         : "<p class=\"aside\">The document has no ledger of hanging nodes.</p>\n";
      html += pictures_html(page, document) + checks_html(document);
    } else if (document.kind == "reproduce" && document.name == "tjunctions")
      // Its table and checks stand under accuracy.
      html += "<h3>" + html_escaped(document.name) +
              " <small>the paper’s remarks on hanging nodes as measured curves</small></h3>\n" +
              ledger(page, document, tjunctions ? *tjunctions : document.rows());
  }
  return html;
}

}  // namespace finegauge
