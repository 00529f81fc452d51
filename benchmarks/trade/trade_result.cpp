#include "benchmarks/trade/trade_result.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "benchmarks/measure/overrides.hpp"

namespace finegauge {
namespace {

std::string number(double value, const char* format = "%.3g") {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

double error_of(const TradeJob& job, const std::string& quantity) {
  const auto error = job.run.errors.find(quantity);
  return job.run.complete && error != job.run.errors.end() ? error->second : std::nan("");
}

double mean_rate(const TradeJob& job) {
  const std::vector<double>& pass = job.run.frame_ms.front();
  return 1e3 * static_cast<double>(pass.size()) / std::accumulate(pass.begin(), pass.end(), 0.0);
}

/// Down, and up, to two digits: what a person would ask for.
double rounded(double value, bool up) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return unit * (up ? std::ceil(value / unit - 1e-9) : std::floor(value / unit + 1e-9));
}

/// Names of quantities are any text.
std::string file_name(std::string text) {
  for (char& letter : text)
    if (!std::isalnum(static_cast<unsigned char>(letter)) && letter != '.' && letter != '_' && letter != '-')
      letter = '_';
  return text;
}

/// A scene at rest, whose run is one frame.
bool of_one_frame(const TradeSweep& sweep) {
  const auto moves = [](const TradeJob& job) { return job.run.complete && job.run.frames > 1; };
  return std::ranges::any_of(sweep.jobs, [](const TradeJob& job) { return job.run.complete; }) &&
         std::ranges::none_of(sweep.jobs, moves);
}

}  // namespace

std::vector<std::string> measured_quantities(const TradeSweep& sweep) {
  std::vector<std::string> names = {"energy_norm"};
  for (const auto& [name, error] : sweep.reference_errors)
    if (name != names.front()) names.push_back(name);
  return names;
}

std::optional<double> reference_error(const TradeSweep& sweep, const std::string& quantity) {
  const auto found = sweep.reference_errors.find(quantity);
  if (found == sweep.reference_errors.end() || !(found->second > 0.0 && std::isfinite(found->second))) return {};
  return found->second;
}

std::vector<TradeOffer> offers(const TradeSweep& sweep, const std::string& quantity) {
  std::vector<TradeOffer> list;
  for (const TradeJob& job : sweep.jobs) {
    const double error = error_of(job, quantity);
    list.push_back(std::isfinite(error) && counts(sweep.jobs, job)
                       ? TradeOffer{error, promised_rate(frame_timing(all_passes(job)))}
                       : TradeOffer{std::numeric_limits<double>::infinity(), 0.0});
  }
  return list;
}

TradeAnswer answer(const TradeSweep& sweep, const std::string& quantity, const TradeQuestion& question) {
  const std::vector<TradeOffer> list = offers(sweep, quantity);
  TradeAnswer found{question, cheapest(list, question), {}, {}};
  if (found.job)
    found.offer = list[*found.job];
  else
    found.nearest = nearest(list, question);
  return found;
}

std::vector<TradeQuestion> questions_of_front(const TradeSweep& sweep, const std::string& quantity) {
  const std::vector<TradeOffer> list = offers(sweep, quantity);
  std::vector<std::size_t> front = timed_front(sweep.jobs, quantity);
  const double least = reference_error(sweep, quantity).value_or(0.0);
  std::erase_if(front, [&](std::size_t i) { return !(list[i].error > least); });
  std::vector<TradeQuestion> questions;
  if (front.empty()) return questions;
  const double worst = std::log(list[front.front()].error), best = std::log(list[front.back()].error);
  // Quarters of the way, but of settings that differ: two with the same error ask the same.
  constexpr double alike = 0.05;
  for (const double share : {0.25, 0.5, 0.75}) {
    if (front.empty()) break;
    const double wanted = worst + share * (best - worst);
    const std::size_t at =
        *std::ranges::min_element(front, {}, [&](std::size_t i) { return std::abs(std::log(list[i].error) - wanted); });
    questions.push_back({rounded(list[at].error, true), rounded(list[at].rate, false)});
    std::erase_if(front, [&](std::size_t i) { return std::abs(std::log(list[i].error / list[at].error)) < alike; });
  }
  return questions;
}

Json trade_rows(const TradeSweep& sweep, const std::string& quantity) {
  std::map<std::size_t, std::vector<std::string>> fronts;
  for (const std::string& name : measured_quantities(sweep))
    for (const std::size_t i : timed_front(sweep.jobs, name)) fronts[i].push_back(name);
  Json rows = Json::array();
  for (std::size_t i = 0; i < sweep.jobs.size(); ++i) {
    const TradeJob& job = sweep.jobs[i];
    if (job.elsewhere) continue;
    Json row = {{"job", job.number}};
    for (std::size_t a = 0; a < sweep.axes.size(); ++a)
      row["setting"][sweep.axes[a].name] = sweep.axes[a].choices[static_cast<std::size_t>(job.setting[a])].label;
    row["overrides"] = overrides(sweep.axes, job.setting);
    if (const int chosen = threads(sweep.axes, job.setting)) row["threads"] = chosen;
    row["complete"] = job.run.complete;
    if (!job.run.complete) row["why_incomplete"] = job.run.why_incomplete;
    for (const std::string& name : measured_quantities(sweep)) {
      const double error = error_of(job, name);
      row["error"][name] = std::isfinite(error) ? Json(error) : Json();
      if (!std::isfinite(error))
        row["error"][name + "_reason"] = job.run.complete ? "nothing to compare" : job.run.why_incomplete;
    }
    if (job.run.complete) {
      const FrameTiming timing = frame_timing(all_passes(job));
      row["frame_ms"] = {{"p50", timing.p50},
                         {"p99", timing.p99},
                         {"worst_p99", timing.worst_p99},
                         {"noise", timing.noise},
                         {"passes", timing.passes}};
      if (timing.passes < 2) {
        row["frame_ms"]["noise"] = Json();
        row["frame_ms"]["noise_reason"] = "one pass: not on a front";
      }
      row["frames_per_second"] = mean_rate(job);
      row["promised_rate"] = promised_rate(timing);
    } else {
      row["frame_ms"] = {{"p50", Json()}, {"p99", Json()}};
      row["frame_ms_reason"] = job.run.why_incomplete;
    }
    row["frames"] = job.run.frames;
    row["unconverged_frames"] = job.run.unconverged;
    row["dofs"] = job.run.dofs_max;
    row["dofs_start"] = job.run.dofs_start, row["dofs_mean"] = job.run.dofs_mean;
    row["refined"] = job.run.refined, row["coarsened"] = job.run.coarsened;
    row["iterations"] = job.run.iterations;
    row["work"] = job.run.work;
    row["peak_memory_mb"] = job.run.peak_memory_mb;
    row["not_compared"] = job.run.left_out;
    const auto found = fronts.find(i);
    row["fronts"] = found == fronts.end() ? std::vector<std::string>{} : found->second;
    row["on_front"] = found != fronts.end() && std::ranges::find(found->second, quantity) != found->second.end();
    rows.push_back(std::move(row));
  }
  return rows;
}

Json to_json(const TradeSweep& sweep, const TradeAnswer& answer, const std::string& quantity, const std::string& scene,
             const std::vector<std::string>& set) {
  Json json = {{"quantity", quantity},
               {"error_asked", answer.question.error},
               {"rate_asked", answer.question.rate},
               {"found", answer.job.has_value()}};
  const auto tell = [&](std::size_t i) {
    const TradeJob& job = sweep.jobs[i];
    const FrameTiming timing = frame_timing(all_passes(job));
    std::string command = run_command(scene, set, overrides(sweep.axes, job.setting));
    if (const int chosen = threads(sweep.axes, job.setting)) command += " --threads " + std::to_string(chosen);
    return Json{{"job", job.number},
                {"setting", describe(sweep.axes, job.setting)},
                {"command", command},
                {"error", error_of(job, quantity)},
                {"promised_rate", promised_rate(timing)},
                {"frame_ms", {{"p50", timing.p50}, {"p99", timing.p99}}},
                {"noise", timing.noise},
                {"dofs_mean", job.run.dofs_mean}};
  };
  if (answer.job) {
    json.update(tell(*answer.job));
    const std::optional<double> least = reference_error(sweep, quantity);
    json["reference_error"] = least ? Json(*least) : Json();
    if (!least) json["reference_error_reason"] = "a coarser reference says nothing of it";
    json["below_reference"] = least ? Json(answer.offer.error < *least) : Json();
    if (!least) json["below_reference_reason"] = json["reference_error_reason"];
  } else {
    json["why"] = "no setting that was tried is both right and fast enough";
    if (answer.nearest.fast_enough) json["fast_enough"] = tell(*answer.nearest.fast_enough);
    if (answer.nearest.right_enough) json["right_enough"] = tell(*answer.nearest.right_enough);
  }
  return json;
}

std::vector<Plot> trade_plots(const TradeSweep& sweep, const std::string& name) {
  std::vector<Plot> plots;
  for (const std::string& quantity : measured_quantities(sweep)) {
    Plot plot;
    plot.file = file_name(std::string(name).append("_trade_").append(quantity)) + ".svg";
    const std::string timed = of_one_frame(sweep) ? "the whole run" : "a frame";
    plot.title = std::string(name).append(": error of ").append(quantity).append(" against the time of ").append(timed);
    plot.x_label = of_one_frame(sweep) ? "time of the whole run [processor ms]"
                                       : "frame time, 99 of 100 frames are faster [processor ms]";
    plot.y_label = "relative error against the reference";
    PlotSeries all{"settings tried", {}, {}, PlotLine::none};
    PlotSeries front{"front", {}, {}, PlotLine::steps};  // between two settings there is none
    PlotSeries own{"as the scene has it", {}, {}, PlotLine::none};
    const std::vector<std::size_t> on_front = timed_front(sweep.jobs, quantity);
    for (const TradeJob& job : sweep.jobs) {
      const double error = error_of(job, quantity);
      if (!std::isfinite(error)) continue;
      PlotSeries& series = job.number == 0 ? own : all;
      series.x.push_back(frame_timing(all_passes(job)).p99), series.y.push_back(error);
    }
    for (const std::size_t i : on_front) {
      front.x.push_back(frame_timing(all_passes(sweep.jobs[i])).p99);
      front.y.push_back(error_of(sweep.jobs[i], quantity));
    }
    plot.series = {all, front, own};
    if (const auto off = reference_error(sweep, quantity); off && !front.x.empty())
      plot.series.push_back({"error of the reference", {front.x.front(), front.x.back()}, {*off, *off}});
    plots.push_back(std::move(plot));
  }
  return plots;
}

std::vector<std::string> trade_table(const TradeSweep& sweep, const std::string& quantity) {
  const std::vector<std::string> names = measured_quantities(sweep);
  const int tried = static_cast<int>(sweep.jobs.size());
  const auto failed = std::ranges::count_if(sweep.jobs, [](const TradeJob& job) { return !job.run.complete; });
  std::vector<std::string> lines;
  lines.push_back(std::to_string(tried) + " settings tried, " + std::to_string(failed) +
                  " of them refused, not converged or too slow; errors against a finer run");
  if (of_one_frame(sweep)) lines.emplace_back("  a scene at rest: its whole run is its frame");
  for (const std::string& name : names)
    if (const auto off = sweep.reference_errors.find(name); off != sweep.reference_errors.end())
      lines.push_back("  " + name + ": the reference is " +
                      (reference_error(sweep, name) ? number(100.0 * off->second) + " % from a coarser one"
                       : off->second == 0.0         ? "the same as a coarser one, which says nothing of its error"
                                                    : "nothing to compare with"));
  std::string head = "       p50 ms   p99 ms  noise   dofs";
  for (const std::string& name : names) head += "  " + name;
  lines.push_back("");
  lines.push_back("front of " + quantity + ", fastest first (* : the scene's own)");
  lines.push_back(head + "  setting");
  for (const std::size_t i : timed_front(sweep.jobs, quantity)) {
    const TradeJob& job = sweep.jobs[i];
    const FrameTiming timing = frame_timing(all_passes(job));
    std::array<char, 120> text;
    std::snprintf(text.data(), text.size(), "%4d%s %8.3g %8.3g %5.0f%% %6.0f", job.number, job.number == 0 ? "*" : " ",
                  timing.p50, timing.p99, 100.0 * timing.noise, job.run.dofs_mean);
    std::string line = text.data();
    for (const std::string& name : names) {
      const double error = error_of(job, name);
      const std::string cell = std::isfinite(error) ? number(100.0 * error) + "%" : "-";
      line += "  " + std::string(name.size() > cell.size() ? name.size() - cell.size() : 0, ' ') + cell;
    }
    lines.push_back(line + "  " + describe(sweep.axes, job.setting));
  }
  return lines;
}

}  // namespace finegauge
