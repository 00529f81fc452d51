#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>

#include "benchmarks/report/frame_series.hpp"
#include "benchmarks/report/html.hpp"
#include "benchmarks/report/section.hpp"

namespace finegauge {
namespace {

/// A scene's run, or a case of a study.
struct Case {
  std::string label;
  FrameSeries frames;
  const Json* summary;  ///< of a run, or the row of a study: both have the same keys
};

std::vector<double> times(double factor, std::vector<double> values) {
  for (double& value : values) value *= factor;
  return values;
}

bool varies(const std::vector<double>& values) {
  const auto finite = [](double value) { return std::isfinite(value); };
  const auto first = std::ranges::find_if(values, finite);
  return std::any_of(first, values.end(), [&](double value) { return finite(value) && value != *first; });
}

/// The tolerance that a scene asks of η: η over its ratio to it, where both are told.
double tolerance_of(const FrameSeries& frames) {
  const std::vector<double>&eta = frames.column("eta"), &ratio = frames.column("tolerance_ratio");
  std::vector<double> asked;
  for (std::size_t i = 0; i < std::min(eta.size(), ratio.size()); ++i)
    if (ratio[i] > 1e-3 && eta[i] > 0.0) asked.push_back(eta[i] / ratio[i]);
  if (asked.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::ranges::nth_element(asked, asked.begin() + static_cast<std::ptrdiff_t>(asked.size() / 2));
  return asked[asked.size() / 2];
}

Chart force_chart(const std::string& name, const std::vector<Case>& cases) {
  Chart chart{.title = name + ": force over travel",
              .x_label = "travel of the tip [mm]",
              .y_label = "needle force [N]",
              .nearest_point = true};
  for (const Case& one : cases) {
    const std::vector<double>&tip = one.frames.column("tip_displacement"), &force = one.frames.column("force");
    if (varies(tip) && varies(force)) chart.series.push_back({.label = one.label, .x = times(1e3, tip), .y = force});
  }
  if (chart.series.empty() || cases.size() > 1) return chart;
  // Sticking and slipping alternate too often to be told apart in a picture; the table counts them.
  ChartSeries events{
      .label = "touch, puncture, cut, retract, exit", .x = {}, .y = {}, .line = false, .points = true, .color = 1};
  // On the curve, in the frame before: the event's own force is the tip's, and is gone at the end of its frame.
  const std::vector<double>&time = cases[0].frames.column("time"), &tip = cases[0].frames.column("tip_displacement"),
        &force = cases[0].frames.column("force");
  for (const FrameEvent& event : cases[0].frames.events) {
    if (event.kind == "stick" || event.kind == "slip" || !(event.time > 0.0)) continue;
    const auto frame = std::ranges::lower_bound(time, event.time) - time.begin();
    const auto before = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, frame - 1));
    if (before >= std::min(tip.size(), force.size())) continue;
    events.x.push_back(1e3 * tip[before]), events.y.push_back(force[before]);
    events.hover.push_back(event.kind + " at " + number_text(event.time) + " s, travel " +
                           number_text(1e3 * tip[before]) + " mm, by " + number_text(event.force) + " N at the tip");
  }
  if (!events.x.empty()) chart.series.push_back(std::move(events));
  return chart;
}

Chart over_time(const std::string& name, const std::vector<Case>& cases, const char* column, const std::string& label,
                double factor) {
  Chart chart{.title = name + ": " + label, .x_label = "time [s]", .y_label = label, .y_from_zero = true};
  for (const Case& one : cases)
    if (!one.frames.column(column).empty())
      chart.series.push_back(
          {.label = one.label, .x = one.frames.column("time"), .y = times(factor, one.frames.column(column))});
  return chart;
}

/// The certified range of the true error, where a run has one.
void add_certified(const std::vector<Case>& cases, Chart& chart) {
  if (cases.size() != 1) return;
  const FrameSeries& frames = cases[0].frames;
  if (frames.column("error_low").empty()) return;
  chart.bands.push_back({"certified range of the true error", frames.column("time"),
                         times(100.0, frames.column("error_low")), times(100.0, frames.column("error_high")), 2});
}

Chart frame_times(const std::string& name, const std::vector<Case>& cases) {
  Chart chart{.title = name + ": frame times",
              .x_label = "time of a frame [ms]",
              .y_label = "frames",
              .log_x = true,
              .y_from_zero = true,
              .nearest_point = true};
  const auto add_rule = [&](double at, const std::string& label) {
    if (at > 0.0) chart.rules.push_back({at, label + " " + bound_text(at, 3) + " ms", true});
  };
  if (cases.size() == 1) {
    chart.bars.push_back(histogram("frames", cases[0].frames.column("frame_ms")));
    add_rule(number_at(*cases[0].summary, "frame_ms.p50"), "p50");
    add_rule(number_at(*cases[0].summary, "frame_ms.p99"), "p99");
    add_rule(number_at(*cases[0].summary, "deadline_ms"), "deadline");
    return chart;
  }
  std::vector<double> all;
  for (const Case& one : cases) std::ranges::copy(one.frames.column("frame_ms"), std::back_inserter(all));
  const ChartBars common = histogram("", all, 60);
  double deadline = 0.0;
  for (const Case& one : cases) {
    if (common.edges.empty() || one.frames.column("frame_ms").empty()) continue;
    const ChartBars bars = histogram_over(common.edges, one.frames.column("frame_ms"));
    ChartSeries outline{.label = one.label, .x = {}, .y = {}};
    for (std::size_t i = 0; i < bars.counts.size(); ++i) {
      outline.x.insert(outline.x.end(), {bars.edges[i], bars.edges[i + 1]});
      outline.y.insert(outline.y.end(), {bars.counts[i], bars.counts[i]});
    }
    chart.series.push_back(std::move(outline));
    deadline = std::max(deadline, number_at(*one.summary, "deadline_ms"));
  }
  add_rule(deadline, "deadline");
  return chart;
}

std::string charts(PageState& page, const std::string& name, const std::vector<Case>& cases, const std::string& by) {
  std::vector<std::string> figures;
  const auto add = [&](const Chart& chart, const std::string& caption) {
    if (std::string figure = chart_figure(page, chart, caption, by); !figure.empty())
      figures.push_back(std::move(figure));
  };
  const std::string of = "<b>" + html_escaped(name) + ".</b> ";
  add(force_chart(name, cases),
      of + "Axial force between needle and tissue over the travel of the tip since it first touched; positive against "
           "insertion, negative while the needle is drawn out.");
  add(over_time(name, cases, "dofs", "degrees of freedom", 1.0), of + "Size of the mesh as it follows the solution.");
  Chart eta = over_time(name, cases, "eta", "estimated error η [%]", 100.0);
  const double tolerance = cases.empty() ? 0.0 : tolerance_of(cases.back().frames);
  if (tolerance > 0.0) eta.rules.push_back({100.0 * tolerance, "tolerance " + bound_text(100.0 * tolerance, 3) + " %"});
  add_certified(cases, eta);
  add(eta,
      of + "Estimated relative error in the energy norm" +
          (tolerance > 0.0 ? " and the tolerance that the scene asks for." : "; the scene asks for no tolerance."));
  const Chart frames = frame_times(name, cases);
  const bool deadline =
      std::ranges::any_of(frames.rules, [](const ChartRule& rule) { return rule.label.starts_with("deadline"); });
  add(frames, of +
                  "How many frames took how long (logarithmic). A bar of a single frame is drawn two pixels high, so "
                  "that the worst are seen. " +
                  (deadline ? "Frames right of the deadline are missed." : "The scene has no deadline."));
  return figure_grid(figures);
}

std::string percent_text(double share) { return std::isfinite(share) ? number_text(100.0 * share) + " %" : "–"; }

std::string run_facts(const Json& s) {
  const auto number = [&](const char* path) { return number_text(number_at(s, path)); };
  const auto count = [&](const char* path) { return count_text(number_at(s, path)); };
  const auto milliseconds = [&](const char* path) {
    return std::isfinite(number_at(s, path)) ? number(path) + " ms" : "–";
  };
  std::string events;
  if (const Json* counted = find_value(s, "events"); counted && counted->is_object())
    for (const auto& [kind, times_seen] : counted->items())
      if (times_seen.is_number() && times_seen.get<double>() > 0.0)
        events += (events.empty() ? "" : ", ") + count_text(times_seen.get<double>()) + " × " + html_escaped(kind);
  std::string hash = text_at(s, "state_sha256");
  if (hash.size() > 12) hash = "<code>" + html_escaped(hash.substr(0, 12)) + "…</code>";
  return facts_html(
      {{"frames", count("frames")},
       {"frames per second", number("frames_per_second")},
       {"frame, p50", milliseconds("frame_ms.p50")},
       {"p95", milliseconds("frame_ms.p95")},
       {"p99", milliseconds("frame_ms.p99")},
       {"slowest", milliseconds("frame_ms.max")},
       {"deadline", milliseconds("deadline_ms")},
       {"missed frames", count("missed_frames")},
       {"longest streak of misses", count("longest_miss_streak")},
       {"dofs at the start", count("dofs.start")},
       {"most dofs", count("dofs.max")},
       {"dofs at the end", count("dofs.end")},
       {"most hanging nodes", count("hanging_nodes.max")},
       {"largest η", percent_text(number_at(s, "eta.max"))},
       {"frames within tolerance", percent_text(number_at(s, "tolerance.share"))},
       {"solver iterations, mean", number("solver_iterations.mean")},
       {"Uzawa iterations, mean", number("uzawa_iterations.mean")},
       {"unconverged frames", count("unconverged_frames")},
       {"largest violation", number("constraint_violation_max")},
       {"energy left over", percent_text(number_at(s, "energy.relative_closure"))},
       {"largest force", std::isfinite(number_at(s, "largest_force")) ? number("largest_force") + " N" : "–"},
       {"events", events},
       {"allocations per quiet frame", count("heap_allocations_per_quiet_frame")},
       {"peak memory", std::isfinite(number_at(s, "peak_memory_mb")) ? number("peak_memory_mb") + " MB" : "–"},
       {"state", hash},
       {"stopped because", html_escaped(text_at(s, "stopped_because"))}});
}

std::string cases_table(const std::vector<Case>& cases) {
  HtmlTable table{{{"case", "", false},
                   {"frames"},
                   {"frames/s"},
                   {"p50", "ms"},
                   {"p99", "ms"},
                   {"slowest", "ms"},
                   {"missed"},
                   {"mean dofs"},
                   {"most dofs"},
                   {"largest η", "%"},
                   {"solver iterations"},
                   {"unconverged"}},
                  {}};
  for (const Case& one : cases) {
    const Json& s = *one.summary;
    table.rows.push_back({html_escaped(one.label), count_text(number_at(s, "frames")),
                          number_text(number_at(s, "frames_per_second")), number_text(number_at(s, "frame_ms.p50")),
                          number_text(number_at(s, "frame_ms.p99")), number_text(number_at(s, "frame_ms.max")),
                          count_text(number_at(s, "missed_frames")), count_text(std::round(number_at(s, "mean_dofs"))),
                          count_text(number_at(s, "dofs.max")), number_text(100.0 * number_at(s, "eta.max")),
                          number_text(number_at(s, "solver_iterations.mean")),
                          count_text(number_at(s, "unconverged_frames"))});
  }
  return to_html(table);
}

/// What tells the cases of a study apart beside their mesh; cases that share it share a chart.
std::string scene_group(const Json& row) {
  std::string group;
  const auto add = [&](const std::string& part) { group += (group.empty() ? "" : ", ") + part; };
  if (const double strength = number_at(row, "puncture_strength"); std::isfinite(strength))
    add("puncture at " + bound_text(strength) + " N");
  if (const double friction = number_at(row, "friction"); std::isfinite(friction))
    add("friction " + bound_text(friction));
  if (const std::string solver = text_at(row, "solver"); !solver.empty() && solver != "best") add(solver + " solver");
  return group;
}

std::string study(PageState& page, const ReportDocument& document) {
  std::vector<std::string> groups, missing;
  std::map<std::string, std::vector<Case>> cases;
  for (const Json& row : document.rows()) {
    const std::string curve = text_at(row, "curve");
    if (curve.empty()) continue;
    // A name and not a path: nothing is read from beyond the document's directory.
    const std::filesystem::path name = std::filesystem::path(curve).filename();
    auto frames = read_frame_series(document.file.parent_path() / name);
    if (!frames) {
      missing.push_back(name.string());
      continue;
    }
    const std::string group = scene_group(row), mesh = text_at(row, "mesh");
    if (!cases.contains(group)) groups.push_back(group);
    cases[group].push_back({mesh.empty() ? name.stem().string() : mesh, std::move(*frames), &row});
  }
  std::string html;
  for (const std::string& group : groups) {
    const std::string name = group.empty() ? document.name : document.name + ", " + group;
    if (!group.empty()) html += "<h4>" + html_escaped(group) + "</h4>\n";
    html += cases_table(cases.at(group)) + charts(page, name, cases.at(group), command_of(document));
  }
  for (const std::string& name : missing)
    html += "<p class=\"aside\">No curve of " + html_escaped(name) +
            ": the file is not beside the document or is no table of frames.</p>\n";
  if (!html.empty())
    html = "<h3>" + html_escaped(document.name) + " <small>the study’s cases; its table is under <a href=\"#" +
           document.id + "\">Accuracy</a></small></h3>\n" + html + pictures_html(page, document);
  return html;
}

}  // namespace

std::string scenes_section(PageState& page) {
  std::string html;
  for (const ReportDocument& document : page.documents) {
    if (document.kind == "reproduce") html += study(page, document);
    if (document.kind != "run") continue;
    std::vector<Case> cases = {{document.name, frame_series(document.rows()), &document.summary()}};
    if (cases[0].frames.column("time").empty() && !document.rows().empty()) continue;  // static: shown under accuracy
    html += document_heading(document) + run_facts(document.summary()) +
            charts(page, document.name, cases, command_of(document));
    html += pictures_html(page, document) + checks_html(document);
  }
  return html;
}

}  // namespace finegauge
