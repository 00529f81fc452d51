#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/report/html.hpp"
#include "benchmarks/report/section.hpp"

namespace finegauge {
namespace {

/// Numbers of one key, which is a number or an object with a number per quantity of interest: the quantities' names, or
/// one empty name.
std::vector<std::string> parts_of(const Json& rows, const std::string& key) {
  std::vector<std::string> names;
  for (const Json& row : rows) {
    const Json* value = find_value(row, key);
    if (!value) continue;
    if (value->is_number() && names.empty()) names.emplace_back();
    if (value->is_object())
      for (const auto& [name, part] : value->items())
        if (part.is_number() && std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return names;
}

double part_at(const Json& row, const std::string& key, const std::string& part) {
  const Json* value = find_value(row, key);
  if (!value) return std::numeric_limits<double>::quiet_NaN();
  if (value->is_number()) return part.empty() ? value->get<double>() : std::numeric_limits<double>::quiet_NaN();
  const auto found = value->is_object() ? value->find(part) : value->end();
  return value->is_object() && found != value->end() && found->is_number() ? found->get<double>()
                                                                           : std::numeric_limits<double>::quiet_NaN();
}

/// Largest of a key's numbers by size.
double largest_part(const Json& row, const std::string& key, const std::vector<std::string>& parts) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const std::string& part : parts)
    if (const double value = std::abs(part_at(row, key, part)); !(value <= largest) && std::isfinite(value))
      largest = value;
  return largest;
}

/// What was chosen, in words: the row's `setting`.
std::string setting_text(const Json& row) {
  const Json* setting = find_value(row, "setting");
  if (!setting) return text_at(row, "name");
  if (setting->is_string()) return setting->get<std::string>();
  std::string text;
  if (setting->is_object())
    for (const auto& [key, value] : setting->items())
      text += (text.empty() ? "" : ", ") + key + " " +
              (value.is_string()   ? value.get<std::string>()
               : value.is_number() ? bound_text(value.get<double>())
                                   : value.dump());
  return text;
}

bool on_front(const Json& row) { return row.value("on_front", Json(false)) == true; }

/// That of one quantity, where the row says of which it is on.
bool on_front(const Json& row, const std::string& quantity) {
  const Json* fronts = find_value(row, "fronts");
  return fronts && fronts->is_array() ? std::ranges::find(*fronts, Json(quantity)) != fronts->end() : on_front(row);
}

Chart front_chart(const ReportDocument& document, const std::string& quantity, const char* percentile) {
  const std::string what = quantity.empty() ? "error" : "error of " + quantity;
  const auto frames_are = [&](auto&& right) {
    return std::ranges::any_of(document.rows(), [&](const Json& row) { return right(number_at(row, "frames")); });
  };
  const bool at_rest =
      frames_are([](double count) { return count == 1.0; }) && !frames_are([](double count) { return count > 1.0; });
  Chart chart{
      .title = document.name + ": " + what + (at_rest ? " over run time" : " over frame time"),
      .x_label = at_rest ? "time of the whole run [ms]" : std::string("time of a frame, ") + percentile + " [ms]",
      .y_label = what + " [%]",
      .log_x = true,
      .log_y = true,
      .nearest_point = true};
  ChartSeries dominated{.label = "dominated", .x = {}, .y = {}, .line = false, .points = true, .color = 7 - 1};
  ChartSeries front{.label = "on the front", .x = {}, .y = {}, .points = true, .color = 0, .steps = true};
  std::vector<const Json*> rows;
  for (const Json& row : document.rows()) rows.push_back(&row);
  const std::string time = std::string("frame_ms.") + percentile;
  std::ranges::stable_sort(rows, [&](const Json* a, const Json* b) {
    const double left = number_at(*a, time), right = number_at(*b, time);
    return std::isnan(right) ? !std::isnan(left) : left < right;
  });
  for (const Json* row : rows) {
    ChartSeries& series = on_front(*row, quantity) ? front : dominated;
    const double error = 100.0 * part_at(*row, "error", quantity), milliseconds = number_at(*row, time);
    series.x.push_back(milliseconds), series.y.push_back(error);
    series.hover.push_back(number_text(error) + " % in " + number_text(milliseconds) + " ms: " + setting_text(*row));
  }
  // A front that is another quantity's does not fall in this one: a line would pretend an order.
  for (std::size_t i = 1; i < front.y.size(); ++i) front.line = front.line && front.y[i] <= front.y[i - 1];
  chart.series = {std::move(dominated), std::move(front)};
  return chart;
}

std::string front_table(const ReportDocument& document, const std::vector<std::string>& quantities) {
  HtmlTable table{{{"setting on the front", "", false}, {"p50", "ms"}, {"p99", "ms"}, {"dofs"}}, {}};
  for (const std::string& quantity : quantities) table.columns.push_back({quantity.empty() ? "error" : quantity, "%"});
  for (const Json& row : document.rows()) {
    if (!on_front(row)) continue;
    std::vector<std::string>& cells = table.rows.emplace_back();
    cells = {html_escaped(setting_text(row)), number_text(number_at(row, "frame_ms.p50")),
             number_text(number_at(row, "frame_ms.p99")), count_text(number_at(row, "dofs"))};
    for (const std::string& quantity : quantities)
      cells.push_back(number_text(100.0 * part_at(row, "error", quantity)));
  }
  return table.rows.empty() ? "<p class=\"aside\">No setting is marked as on the front.</p>\n" : to_html(table);
}

/// `answers` as a list of objects, or as an object by question.
std::string answers_html(const Json& summary) {
  const Json* answers = find_value(summary, "answers");
  if (!answers || answers->empty()) return {};
  Json list = Json::array();
  if (answers->is_array()) list = *answers;
  if (answers->is_object())
    for (const auto& [question, answer] : answers->items()) {
      Json record = {{"asked", question}};
      if (answer.is_object())
        record.update(answer);
      else
        record["answer"] = answer;
      list.push_back(record);
    }
  for (Json& answer : list)
    if (answer.contains("setting") && answer["setting"].is_object()) answer["setting"] = setting_text(answer);
  const std::string table = records_html(list);
  return table.empty() ? table : "<h4>Cheapest setting for an error and a rate</h4>\n" + table;
}

}  // namespace

std::string trade_section(PageState& page) {
  std::string html;
  for (const ReportDocument& document : page.documents) {
    if (document.kind != "trade") continue;
    html += document_heading(document) + answers_html(document.summary());
    const std::vector<std::string> quantities = parts_of(document.rows(), "error");
    std::vector<std::string> figures;
    for (const std::string& quantity : quantities)
      if (std::string figure = chart_figure(page, front_chart(document, quantity, "p99"),
                                            "Each point is a setting: its error against the scene’s reference run over "
                                            "the time of a frame (of the whole run, "
                                            "where nothing moves). Of the settings that were timed again, those on the "
                                            "front have none left of and below them.",
                                            command_of(document));
          !figure.empty())
        figures.push_back(std::move(figure));
    html += figure_grid(figures) + front_table(document, quantities) +
            details_html("All " + count_text(static_cast<double>(document.rows().size())) + " settings",
                         records_html(document.rows(), 200)) +
            pictures_html(page, document) + checks_html(document);
  }
  return html;
}

std::string audit_section(PageState& page) {
  std::string html;
  for (const ReportDocument& document : page.documents) {
    if (document.kind != "audit") continue;
    const std::vector<std::string> parts = parts_of(document.rows(), "qoi_change"),
                                   time_parts = parts_of(document.rows(), "frame_ms_change");
    std::vector<std::string> names;
    BarPanel change{"largest change of a quantity [%]", {}}, time{"change of frame time [ms]", {}};
    if (const double tolerance = number_at(document.summary(), "tolerance"); tolerance > 0.0)
      change.reference = 100.0 * tolerance;
    const std::string time_part = std::ranges::find(time_parts, "p50") != time_parts.end() ? "p50"
                                  : time_parts.empty()                                     ? ""
                                                                                           : time_parts.front();
    for (const Json& row : document.rows()) {
      const std::string verdict = text_at(row, "verdict");
      names.push_back(text_at(row, "ingredient") + (verdict.empty() ? "" : " — " + verdict));
      change.values.push_back(100.0 * largest_part(row, "qoi_change", parts));
      time.values.push_back(part_at(row, "frame_ms_change", time_part));
    }
    html += document_heading(document);
    if (!names.empty())
      html += figure_html(
          page, bar_panels_html(document.name + ": what each ingredient changes", names, {change, time}),
          "What leaving out or adding one ingredient changes: the largest relative change of a quantity of interest "
          "against the change of "
          "the frame time (negative: faster)." +
              std::string(change.reference > 0.0
                              ? " The dashed line is the tolerance asked for: what stays left of it is spare."
                              : ""),
          command_of(document));
    html += records_html(document.rows(), 100) + pictures_html(page, document) + checks_html(document);
  }
  return html;
}

}  // namespace finegauge
