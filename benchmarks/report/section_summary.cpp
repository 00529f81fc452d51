#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "benchmarks/report/html.hpp"
#include "benchmarks/report/section.hpp"

namespace finegauge {
namespace {

std::string verdict_of(const ReportDocument& document) {
  const std::size_t failing = document.failing_checks().size(), all = document.checks().size();
  if (find_value(document.summary(), "interrupted")) return verdict_html(false, "interrupted");
  if (all == 0) return "no checks";
  if (failing == 0)
    return verdict_html(true, all == 1 ? "1 holds" : "all " + count_text(static_cast<double>(all)) + " hold");
  return verdict_html(
      false, count_text(static_cast<double>(failing)) + " of " + count_text(static_cast<double>(all)) + " fail");
}

std::string link(const ReportDocument& document) {
  return "<a href=\"#" + document.id + "\">" + html_escaped(document.name) + "</a>";
}

std::string seconds_text(double seconds) {
  if (!(seconds >= 120.0)) return number_text(seconds) + " s";
  return number_text(seconds / 60.0) + " min";
}

std::string missing_kinds(const std::vector<ReportDocument>& documents) {
  std::string missing;
  for (const char* kind : {"reproduce", "verify", "run", "trade", "audit", "profile", "atlas", "gate"})
    if (std::ranges::none_of(documents, [&](const ReportDocument& d) { return d.kind == kind; }))
      missing += (missing.empty() ? "" : ", ") + std::string(kind);
  return missing;
}

}  // namespace

std::string summary_section(PageState& page) {
  std::size_t checks = 0, failing = 0, interrupted = 0;
  HtmlTable failures{{{"check", "", false}, {"document", "", false}, {"value"}, {"low"}, {"high"}}, {}};
  HtmlTable table{{{"document", "", false},
                   {"command", "", false},
                   {"verdict", "", false},
                   {"of what", "", false},
                   {"started", "", false},
                   {"took"}},
                  {}};
  for (const ReportDocument& document : page.documents) {
    checks += document.checks().size();
    for (const Json* one : document.failing_checks()) {
      ++failing;
      failures.rows.push_back({verdict_html(false, one->at("name").get<std::string>()), link(document),
                               number_text(number_at(*one, "value"), 4), bound_text(number_at(*one, "low")),
                               bound_text(number_at(*one, "high"))});
      failures.failing.push_back(true);
    }
    interrupted += find_value(document.summary(), "interrupted") ? 1 : 0;
    const std::string scene = text_at(document.content, "inputs.scene");
    const double seconds = number_at(document.content, "environment.seconds");
    table.rows.push_back(
        {link(document), html_escaped(document.kind) + (document.quick ? " <span class=\"tag\">quick</span>" : ""),
         verdict_of(document), html_escaped(scene), html_escaped(text_at(document.content, "environment.started")),
         seconds > 0.0 ? seconds_text(seconds) : "–"});
    table.failing.push_back(!document.failing_checks().empty());
  }
  const bool good = failing == 0 && interrupted == 0;
  std::string words = failing > 0   ? count_text(double(failing)) + " of " + count_text(double(checks)) + " checks fail"
                      : checks == 1 ? std::string("1 check holds")
                      : checks > 0  ? "All " + count_text(double(checks)) + " checks hold"
                                    : "There are no checks";
  if (interrupted > 0) words += "; " + count_text(double(interrupted)) + " documents were interrupted";
  const std::string size =
      count_text(double(page.documents.size())) + (page.documents.size() == 1 ? " document" : " documents");
  std::string html = std::string("<div class=\"verdict ") + (good ? "yes" : "no") + "\"><p><b>" + (good ? "✓ " : "✗ ") +
                     html_escaped(words) + "</b> in " + size + ".</p>\n";
  if (failing > 0) html += to_html(failures);
  html += "</div>\n" + to_html(table);
  if (const std::string missing = missing_kinds(page.documents); !missing.empty())
    html += "<p class=\"aside\">No document of these kinds was given, so the page has nothing of them: " + missing +
            ".</p>\n";
  return html;
}

std::string environments_section(PageState& page) {
  static constexpr std::array keys = {"version", "commit", "compiler", "flags", "cpu", "cores", "threads"};
  std::map<std::vector<std::string>, std::vector<std::string>> documents_of;
  std::vector<std::vector<std::string>> order;
  for (const ReportDocument& document : page.documents) {
    std::vector<std::string> environment;
    for (const char* key : keys) {
      const Json* value = find_value(document.content, std::string("environment.") + key);
      environment.push_back(value ? value_html(*value) : "–");
    }
    if (!documents_of.contains(environment)) order.push_back(environment);
    documents_of[environment].push_back(link(document));
  }
  HtmlTable table{{{"version", "", false},
                   {"commit", "", false},
                   {"compiler", "", false},
                   {"flags", "", false},
                   {"processor", "", false},
                   {"cores"},
                   {"threads"},
                   {"documents", "", false}},
                  {}};
  for (const std::vector<std::string>& environment : order) {
    std::vector<std::string>& row = table.rows.emplace_back(environment);
    std::string links;
    for (const std::string& one : documents_of.at(environment)) links += (links.empty() ? "" : ", ") + one;
    row.push_back(links);
  }
  std::string html = to_html(table);
  if (order.size() > 1)
    html += paragraph_html("The documents are of " + std::to_string(order.size()) +
                           " environments: times of one are not to be compared with those of another.");
  HtmlTable inputs{
      {{"document", "", false}, {"scene", "", false}, {"SHA-256 of the scene", "", false}, {"--set", "", false}}, {}};
  for (const ReportDocument& document : page.documents) {
    const std::string scene = text_at(document.content, "inputs.scene"),
                      sum = text_at(document.content, "inputs.sha256");
    const Json* set = find_value(document.content, "inputs.overrides");
    if (scene.empty()) continue;
    inputs.rows.push_back({link(document), html_escaped(scene),
                           sum.empty() ? "–" : "<code>" + html_escaped(sum.substr(0, 16)) + "…</code>",
                           set && !set->empty() ? value_html(*set) : "–"});
  }
  return html + (inputs.rows.empty() ? "" : to_html(inputs));
}

}  // namespace finegauge
