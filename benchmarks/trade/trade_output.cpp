#include "benchmarks/trade/trade_output.hpp"

#include <cmath>
#include <cstdio>

#include "benchmarks/program/plots.hpp"

namespace finegauge {
namespace {

void print_answer(const TradeSweep& sweep, const TradeAnswer& found, const std::string& quantity, const Json& json) {
  std::printf("\nerror of %s <= %.3g %% at %.3g frames/s: ", quantity.c_str(), 100.0 * found.question.error,
              found.question.rate);
  if (found.job) {
    std::printf("%s\n  promised: %.3g %% at %.3g frames/s (p50 %.3g ms, p99 %.3g ms)\n  %s\n",
                describe(sweep.axes, sweep.jobs[*found.job].setting).c_str(), 100.0 * found.offer.error,
                found.offer.rate, json["frame_ms"]["p50"].get<double>(), json["frame_ms"]["p99"].get<double>(),
                json["command"].get<std::string>().c_str());
    if (json["below_reference"] == true)
      std::printf("  less than the reference's own error, %.3g %%: how far it is off is not known so well\n",
                  100.0 * json["reference_error"].get<double>());
    return;
  }
  std::printf("nothing that was tried\n");
  for (const auto& [key, words] : {std::pair{"fast_enough", "fast enough"}, std::pair{"right_enough", "right enough"}})
    if (json.contains(key))
      std::printf("  the nearest that is %s: %.3g %% at %.3g frames/s: %s\n", words,
                  100.0 * json[key]["error"].get<double>(), json[key]["promised_rate"].get<double>(),
                  json[key]["setting"].get<std::string>().c_str());
}

void print_checks(const Json& checks) {
  for (const Json& one : checks)
    std::printf("%s %s: %.4g, allowed %.4g to %.4g\n", one["ok"].get<bool>() ? "ok    " : "FAILED",
                one["name"].get<std::string>().c_str(), one["value"].get<double>(), one["low"].get<double>(),
                one["high"].get<double>());
}

/// As arguments of --set.
std::vector<std::string> set_of(const Json& overrides) {
  std::vector<std::string> set;
  for (const auto& [key, value] : overrides.items()) set.push_back(std::string(key) + "=" + value.get<std::string>());
  return set;
}

}  // namespace

void summarize_sweep(const TradeSweep& sweep, const std::string& quantity, ResultDocument& document) {
  Json& summary = document.summary;
  summary["quantity"] = quantity;
  summary["reference"] = {{"overrides", sweep.reference_overrides}, {"distance_of_coarser", Json::object()}};
  for (const auto& [name, error] : sweep.reference_errors)
    summary["reference"]["distance_of_coarser"][name] = std::isfinite(error) ? Json(error) : Json();
  for (const TradeAxis& axis : sweep.axes) summary["axes"][axis.name] = axis.about;
}

void conclude_sweep(const TradeSweep& sweep, const std::string& quantity, const std::vector<TradeAnswer>& answers,
                    ResultDocument& document, const std::filesystem::path& directory, bool print,
                    const Progress& progress) {
  const std::vector<std::string> set = set_of(document.inputs.overrides);
  if (print)
    for (const std::string& line : trade_table(sweep, quantity)) std::printf("%s\n", line.c_str());
  document.summary["answers"] = Json::array();
  for (const TradeAnswer& found : answers) {
    Json json = to_json(sweep, found, quantity, document.inputs.scene, set);
    if (print) print_answer(sweep, found, quantity, json);
    document.summary["answers"].push_back(std::move(json));
  }
  if (print) print_checks(document.checks);
  for (const Plot& plot : trade_plots(sweep, document.name))
    if (const PlotReport report = draw_plot(plot, directory); !report.written) progress.note(report.why_not);
}

}  // namespace finegauge
