#include "benchmarks/report/section.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

#include "benchmarks/report/html.hpp"
#include "benchmarks/report/picture.hpp"

namespace fs = std::filesystem;

namespace finegauge {
namespace {

constexpr std::size_t most_picture_bytes = 3000000;  // of all pictures together: the page is to stay below 5 MB

/// Plots of numbers that the page draws itself, by the names that the commands give them.
bool drawn_again(const std::string& stem) {
  static constexpr std::array ends = {"force", "dofs", "eta", "force_loop"};
  const auto is_part = [&](const char* word) { return stem == word || stem.ends_with(std::string("_") + word); };
  return std::ranges::any_of(ends, is_part) || stem.starts_with("convergence_") || stem.starts_with("force_");
}

std::string picture_caption(const std::string& stem) {
  static const std::vector<std::pair<std::string, std::string>> known = {
      {"_mesh", "The surface of the mesh, refined as it was at the end."},
      {"_start_stress", "Cut open at the start, coloured by von Mises stress."},
      {"_start_eta", "Cut open at the start, coloured by each cell's estimated error."},
      {"_depth_stress", "Cut open along the needle at its deepest, coloured by von Mises stress."},
      {"_depth_eta", "Cut open along the needle at its deepest, coloured by each cell's estimated error."},
      {"_end_stress", "Cut open at the end, coloured by von Mises stress."},
      {"_end_eta", "Cut open at the end, coloured by each cell's estimated error."}};
  for (const auto& [end, words] : known)
    if (stem.ends_with(end)) return words + " (<code>" + html_escaped(stem) + ".svg</code>)";
  if (stem.starts_with("mesh_"))
    return "A refined mesh of “" + html_escaped(stem.substr(5)) + "”. (<code>" + html_escaped(stem) + ".svg</code>)";
  if (stem == "safe_box") return "The box in which the simulation is sound, an axis a row.";
  return "<code>" + html_escaped(stem) + ".svg</code>, as the command drew it.";
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {(std::istreambuf_iterator<char>(in)), {}};
}

/// Whose picture it is: of the documents in its directory the one with the longest name that its own begins with, else
/// the first.
bool belongs(const fs::path& picture, const ReportDocument& document, const std::vector<ReportDocument>& documents) {
  const ReportDocument* owner = nullptr;
  std::size_t longest = 0;
  for (const ReportDocument& other : documents) {
    if (other.file.parent_path() != picture.parent_path()) continue;
    const bool named = picture.stem().string().starts_with(other.name);
    if (!owner || (named && other.name.size() > longest)) owner = &other;
    if (named) longest = std::max(longest, other.name.size());
  }
  return owner == &document;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void flatten(const Json& value, const std::string& key, std::vector<std::pair<std::string, const Json*>>& out) {
  if (!value.is_object()) {
    out.emplace_back(key, &value);
    return;
  }
  for (const auto& [part, item] : value.items()) flatten(item, key.empty() ? part : key + "." + part, out);
}

}  // namespace

std::string figure_html(PageState& page, const std::string& body, const std::string& caption,
                        const std::string& command) {
  const std::string number = std::to_string(++page.figures);
  std::string html =
      "<figure id=\"figure-" + number + "\">" + body + "<figcaption><b>Figure " + number + ".</b> " + caption;
  if (!command.empty()) html += " <span class=\"by\">Made by <code>" + html_escaped(command) + "</code></span>";
  return html + "</figcaption></figure>\n";
}

std::string chart_figure(PageState& page, const Chart& chart, const std::string& caption, const std::string& command) {
  return drawable(chart) ? figure_html(page, chart_html(chart), caption, command) : std::string();
}

std::string figure_grid(const std::vector<std::string>& figures) {
  std::string inner;
  for (const std::string& figure : figures) inner += figure;
  return inner.empty() ? inner : "<div class=\"figures\">\n" + inner + "</div>\n";
}

std::string pictures_html(PageState& page, const ReportDocument& document) {
  std::vector<fs::path> files;
  const fs::path directory = document.file.parent_path().empty() ? "." : document.file.parent_path();
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, ignored))
    if (entry.path().extension() == ".svg") files.push_back(document.file.parent_path() / entry.path().filename());
  std::ranges::sort(files);
  std::vector<std::string> figures, again, left_out;
  for (const fs::path& file : files) {
    if (!belongs(file, document, page.documents)) continue;
    const std::string stem = file.stem().string(), name = file.filename().string();
    const std::string content = content_of(file);
    if (content.find("gnuplot_canvas") != std::string::npos && drawn_again(stem)) {
      again.push_back(name);
      continue;
    }
    InlinePicture picture = inline_picture(content, "picture" + std::to_string(page.figures + 1) + "-");
    if (picture.why_not.empty() && page.picture_bytes + picture.svg.size() > most_picture_bytes)
      picture.why_not = "the page's pictures have taken their room";
    if (!picture.why_not.empty()) {
      left_out.push_back(name + " (" + picture.why_not + ")");
      continue;
    }
    page.picture_bytes += picture.svg.size();
    std::string figure = figure_html(page, "<div class=\"paper\">" + picture.svg + "</div>", picture_caption(stem),
                                     command_of(document));
    // A tall picture has small texts, and gets the width of two.
    if (picture.height > picture.width) figure.insert(figure.find("<figure") + 7, " class=\"wide\"");
    figures.push_back(std::move(figure));
  }
  std::string html = figure_grid(figures);
  if (!again.empty())
    html += "<p class=\"aside\">Drawn again here from the same numbers: " + html_escaped(list_of(again)) + ".</p>\n";
  if (!left_out.empty())
    html +=
        "<p class=\"aside\">Left out, to be found beside the document: " + html_escaped(list_of(left_out)) + ".</p>\n";
  return html;
}

std::string document_heading(const ReportDocument& document) {
  std::string html =
      "<h3 id=\"" + document.id + "\">" + html_escaped(document.name) + " <small>" + html_escaped(document.kind);
  if (document.quick) html += ", quick version";
  html += "</small></h3>\n<p class=\"aside\"><code>" + html_escaped(command_of(document)) + "</code> · " +
          html_escaped(document.shown_file) + "</p>\n";
  if (find_value(document.summary(), "interrupted"))
    html += "<p class=\"fail\">✗ It was interrupted: what was finished is shown.</p>\n";
  return html;
}

std::string checks_html(const ReportDocument& document) {
  const TableColumn judged{"check", "", false};
  HtmlTable failing{{judged, {"value"}, {"low"}, {"high"}}, {}}, holding = failing;
  for (const Json& one : document.checks()) {
    const bool ok = one.at("ok").get<bool>();
    HtmlTable& table = ok ? holding : failing;
    table.rows.push_back({verdict_html(ok, one.at("name").get<std::string>()), number_text(number_at(one, "value"), 4),
                          bound_text(number_at(one, "low")), bound_text(number_at(one, "high"))});
    table.failing.push_back(!ok);
  }
  std::string html;
  if (!failing.rows.empty()) html += to_html(failing);
  if (!holding.rows.empty())
    html +=
        details_html(holding.rows.size() == 1 ? std::string("1 check holds")
                                              : count_text(static_cast<double>(holding.rows.size())) + " checks hold",
                     to_html(holding));
  return html;
}

std::string value_html(const Json& value) {
  if (value.is_null()) return "–";
  if (value.is_boolean()) return value.get<bool>() ? "✓" : "✗";
  if (value.is_number_integer()) return count_text(value.get<double>());
  if (value.is_number()) return bound_text(value.get<double>());
  std::string text =
      value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 300) text = text.substr(0, 300) + "…";
  return html_escaped(text);
}

std::string records_html(const Json& records, std::size_t most_rows, std::size_t most_columns) {
  if (!records.is_array()) return {};
  HtmlTable table;
  std::vector<std::string> keys;
  std::vector<std::vector<std::pair<std::string, const Json*>>> flat;
  for (const Json& record : records) {
    if (flat.size() == most_rows) break;
    flatten(record, "", flat.emplace_back());
    for (const auto& [key, value] : flat.back())
      if (!key.ends_with("_reason") && std::ranges::find(keys, key) == keys.end()) keys.push_back(key);
  }
  const std::size_t all_keys = keys.size();
  keys.resize(std::min(keys.size(), most_columns));
  for (const std::string& key : keys) {
    const bool numeric = std::ranges::all_of(flat, [&](const auto& row) {
      return std::ranges::all_of(row, [&](const auto& cell) {
        return cell.first != key || cell.second->is_number() || cell.second->is_null();
      });
    });
    const bool time = key.ends_with("_ms");
    table.columns.push_back({time ? key.substr(0, key.size() - 3) : key, time ? "ms" : "", numeric});
  }
  for (const auto& row : flat) {
    std::vector<std::string>& cells = table.rows.emplace_back(keys.size());
    for (const auto& [key, value] : row)
      if (const auto at = std::ranges::find(keys, key); at != keys.end())
        cells[static_cast<std::size_t>(at - keys.begin())] = value_html(*value);
  }
  if (table.rows.empty() || table.columns.empty()) return {};
  std::string html = to_html(table);
  std::string left;
  if (records.size() > most_rows)
    left += "the first " + count_text(double(most_rows)) + " of " + count_text(double(records.size())) + " rows";
  if (all_keys > most_columns)
    left += (left.empty() ? "" : ", ") + std::string("the first ") + count_text(double(most_columns)) + " of " +
            count_text(double(all_keys)) + " columns";
  if (!left.empty()) html += "<p class=\"aside\">Shown are " + left + "; the document has all.</p>\n";
  return html;
}

std::string facts_html(const std::vector<std::pair<std::string, std::string>>& facts) {
  std::string html;
  for (const auto& [name, value] : facts)
    if (!value.empty() && value != "–") html += "<div><dt>" + html_escaped(name) + "</dt><dd>" + value + "</dd></div>";
  return html.empty() ? html : "<dl class=\"facts\">" + html + "</dl>\n";
}

}  // namespace finegauge
