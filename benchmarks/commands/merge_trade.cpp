#include <algorithm>
#include <cmath>

#include "benchmarks/commands/merge.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/trade/journal.hpp"
#include "benchmarks/trade/trade_output.hpp"

namespace finegauge {
namespace {

std::string job_name(const Json& row) { return "job " + std::to_string(row.at("job").get<int>()); }

/// All of a header that parts of one sweep have in common.
void require_same_header(const MergePart& part, const Json& first, const Json& other) {
  for (const auto& [key, value] : first.items())
    if (key != "shard" && other.value(key, Json()) != value)
      throw UsageError("merge: " + part.directory.string() + ": found a sweep of another " + key + ", " +
                       other.value(key, Json()).dump() + ", allowed that of the other parts, " + value.dump());
}

void add_lines(const MergePart& part, const std::vector<Json>& lines, TradeSweep& sweep) {
  const auto job_of = [&](const Json& number) -> TradeJob& {
    const auto i = number.get<std::size_t>();
    if (i >= sweep.jobs.size() || !part.shard.has(i))
      throw UsageError("merge: " + part.directory.string() + ": found job " + std::to_string(i) +
                       " in its journal, which is of another part");
    return sweep.jobs[i];
  };
  for (const Json& line : lines) {
    if (line.contains("job")) {
      TradeJob& job = job_of(line.at("job"));
      job.setting = line.at("setting").get<TradeSetting>();
      job.run = measured_run(line.at("run"));
      job.elsewhere = false;
    } else if (line.contains("round")) {
      auto times = line.at("frame_ms").get<std::vector<double>>();
      if (!times.empty()) job_of(line.at("of")).more_passes.push_back(std::move(times));
    }
  }
}

/// The sweep as its parts wrote it down.
TradeSweep joined_sweep(std::span<const MergePart> parts, const std::string& name, std::size_t jobs) {
  TradeSweep sweep;
  sweep.finished = true;
  for (std::size_t i = 0; i < jobs; ++i) {
    TradeJob& job = sweep.jobs.emplace_back();
    job.number = static_cast<int>(i);
    job.elsewhere = true;
  }
  Json header;
  std::vector<int> seen;
  for (const MergePart& part : parts) {
    const Json& summary = part.document.at("summary");
    if (!summary.at("finished").get<bool>())
      throw UsageError("merge: " + part.directory.string() +
                       ": found a part that was stopped; --resume goes on with it");
    std::vector<Json> lines = journal_lines(journal_file(part.directory, name));
    if (header.is_null()) {
      header = lines.front();
      for (const Json& axis : header.at("axes")) sweep.axes.push_back(trade_axis(axis));
      const Json& reference = summary.at("reference");
      reference.at("overrides").get_to(sweep.reference_overrides);
      for (const auto& [quantity, error] : reference.at("distance_of_coarser").items())
        sweep.reference_errors[quantity] = error.is_null() ? std::nan("") : error.get<double>();
    }
    require_same_header(part, header, lines.front());
    if (std::ranges::find(seen, part.shard.number) != seen.end()) continue;  // there twice, and the same
    seen.push_back(part.shard.number);
    lines.erase(lines.begin());
    add_lines(part, lines, sweep);
  }
  for (const TradeJob& job : sweep.jobs)
    if (job.elsewhere) throw UsageError("merge: found no journal that has job " + std::to_string(job.number));
  return sweep;
}

void conclude_trade(std::span<const MergePart> parts, ResultDocument& whole, const std::filesystem::path& out,
                    bool print) {
  const Json& first = parts.front().document.at("summary");
  for (const MergePart& part : parts)
    for (const char* key : {"quantity", "questions"})
      if (part.document.at("summary").at(key) != first.at(key))
        throw UsageError("merge: " + part.directory.string() + ": found other " + key + " than in the other parts");
  const TradeSweep sweep = joined_sweep(parts, whole.name, whole.rows.size());
  const auto quantity = first.at("quantity").get<std::string>();
  whole.rows = trade_rows(sweep, quantity);
  std::vector<TradeQuestion> questions;
  for (const Json& one : first.at("questions"))
    questions.push_back({one.at("error").get<double>(), one.at("rate").get<double>()});
  if (questions.empty()) questions = questions_of_front(sweep, quantity);
  std::vector<TradeAnswer> answers;
  for (const TradeQuestion& question : questions) answers.push_back(answer(sweep, quantity, question));
  whole.summary["finished"] = true;
  whole.summary["seed"] = first.at("seed");
  summarize_sweep(sweep, quantity, whole);
  whole.checks.push_back(check("settings_on_front", static_cast<double>(timed_front(sweep.jobs, quantity).size()), 1.0,
                               static_cast<double>(sweep.jobs.size())));
  std::filesystem::create_directories(out);
  const Progress progress(!print);
  conclude_sweep(sweep, quantity, answers, whole, out, print, progress);
}

}  // namespace

MergeableKind mergeable_trade() { return {"trade", job_name, conclude_trade}; }

}  // namespace finegauge
