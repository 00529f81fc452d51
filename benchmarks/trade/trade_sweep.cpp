#include "benchmarks/trade/trade_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>

#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/sha256.hpp"
#include "benchmarks/trade/front.hpp"
#include "benchmarks/trade/journal.hpp"
#include "core/mesh/immersed_body.hpp"
#include "core/parallel/for_parts.hpp"
#include "core/scene/scene_error.hpp"
#include "core/scene/scene_reader.hpp"
#include "verification/support/run_apart.hpp"

namespace finegauge {
namespace {

constexpr int instants = 6;
constexpr double no_limit = std::numeric_limits<double>::infinity();

// Shares of a sweep's time, for its progress: the reference, a coarser one, the settings; timing the front is the rest.
constexpr double reference_share = 0.15, coarser_share = 0.05, settings_share = 0.6;
constexpr double settings_start = reference_share + coarser_share, timing_start = settings_start + settings_share;

std::vector<std::string> joined(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::string bytes_as_text(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }
std::vector<std::uint8_t> text_as_bytes(const std::string& text) { return {text.begin(), text.end()}; }

/// A run through a pipe, without its curves: the errors are known by now.
std::string packed(MeasuredRun run) {
  run.curves = {};
  return bytes_as_text(Json::to_cbor(to_json(run)));
}

MeasuredRun unpacked(const ApartResult& result) {
  if (result.end == ApartResult::End::done) return measured_run(Json::from_cbor(text_as_bytes(result.bytes)));
  MeasuredRun run;
  run.why_incomplete = (result.end == ApartResult::End::refused ? "refused: " : "") + result.why;
  return run;
}

/// Asked after each frame of a run in a process of its own, says each further hundredth; the run goes on.
std::function<bool(double)> saying(const Say& say) {
  return [&say, told = 0](double done) mutable {
    if (const int percent = static_cast<int>(100.0 * done); percent > told) say(std::to_string(told = percent));
    return true;
  };
}

/// What a scene reads from other files, as it came out: the meshes of gmsh files and of organs, and their surfaces.
std::string geometry_text(const Scene& scene) {
  const auto* mesh = std::get_if<BaseMesh>(&scene.geometry);
  if (!mesh) return {};
  const auto bytes = [](const auto* first, auto count) {
    return sha256(std::as_bytes(std::span(first, static_cast<std::size_t>(count))));
  };
  std::string text = bytes(mesh->nodes.data(), mesh->nodes.size()) + bytes(mesh->cells.data(), mesh->cells.size());
  for (const auto& [name, faces] : mesh->surfaces) text += "\n" + name + bytes(faces.data(), faces.size());
  for (const auto& [name, nodes] : mesh->regions) text += "\n" + name + bytes(nodes.data(), nodes.size());
  if (mesh->body) text += "\n" + bytes(mesh->body->share.data(), mesh->body->share.size());
  return text + "\n";
}

/// Everything about one sweep that its steps share.
class Sweeper {
 public:
  explicit Sweeper(const TradeOptions& options)
      : options_(options),
        scene_(read_scene(options.scene, options.set)),
        // Parts may share a machine, and their threads would only wait for one another.
        axes_(trade_axes(scene_, options.threads, options.shard.of > 1 ? 1 : processor_count())),
        wanted_(trade_reference(scene_)) {
    wanted_.fine = joined(std::move(wanted_.fine), options.reference);
    wanted_.coarser = joined(joined(std::move(wanted_.coarser), options.reference), options.coarser);
    if (parse_overrides(wanted_.fine) == parse_overrides(wanted_.coarser))
      throw UsageError(
          "trade: --reference: the coarser run has the same settings, and would say nothing of how far the reference "
          "is off; --coarser KEY=VALUE makes it coarser");
    // Their messages before anything is written.
    geometry_ = geometry_text(scene_) + geometry_text(read_scene(options.scene, joined(options.set, wanted_.fine))) +
                geometry_text(read_scene(options.scene, joined(options.set, wanted_.coarser)));
    if (axes_.empty()) throw UsageError(options.scene.string() + ": trade: there is nothing to choose in this scene");
    key_ = reference_key();
    if (!options.reference_from.empty())
      for (const std::filesystem::path& file : {fields(), errors()})
        if (!std::filesystem::exists(file))
          throw UsageError("--reference-from: " + file.string() +
                           " is missing: it belongs to another scene, other settings or another build of the program");
  }

  /// Throws SceneError for a scene that cannot start as it is. False when interrupted.
  bool check_start() const {
    const ApartResult start = run_apart(
        [&] {
          require_start(scene_);
          return std::string();
        },
        no_limit, options_.interrupted);
    if (start.end == ApartResult::End::refused) throw SceneError(start.why);
    return start.end != ApartResult::End::stopped;
  }

  Json header() const {
    Json axes = Json::array();
    for (const TradeAxis& axis : axes_) axes.push_back(to_json(axis));
    const Shard& shard = options_.shard;
    return {{"sweep", "trade"},
            {"reference", key_},
            {"points", options_.points},
            {"seed", options_.seed},
            {"seconds", options_.seconds},
            {"timing_rounds", options_.timing_rounds},
            {"cpu", describe_environment(1).cpu},
            {"shard", std::to_string(shard.number) + "/" + std::to_string(shard.of)},
            {"axes", std::move(axes)}};
  }

  /// False when interrupted.
  bool prepare_reference(TradeSweep& sweep) {
    if (!std::filesystem::exists(fields()) && !record(fields())) return false;
    std::ifstream in(fields(), std::ios::binary);
    reference_ = reference_run({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
    if (!std::filesystem::exists(errors()) && !compare_references(errors())) return false;
    std::ifstream found(errors());
    const Json comparison = Json::parse(found);
    for (const auto& [quantity, error] : comparison.at("errors").items())
      sweep.reference_errors[quantity] = error.is_null() ? std::nan("") : error.get<double>();
    return true;
  }

  /// A part of the sweep's progress, and what is done in it.
  struct Step {
    double from = 0.0, share = 0.0;
    std::string doing;
  };

  MeasuredRun measure(const TradeSetting& setting, int passes, bool compared, double seconds, const Step& step) const {
    const std::vector<std::string> set = joined(options_.set, overrides(axes_, setting));
    std::optional<Scene> scene;
    try {
      scene = read_scene(options_.scene, set);
    } catch (const SceneError& error) {
      MeasuredRun refused;
      refused.why_incomplete = std::string("refused: ") + error.what();
      return refused;
    }
    MeasureOptions how;
    how.passes_least = how.passes_most = passes;
    if (compared) how.reference = &*reference_;
    // Of processor time, which the threads take together.
    const int chosen = threads(axes_, setting) > 0 ? threads(axes_, setting) : options_.threads;
    return unpacked(apart(step, chosen * seconds, [&](const Say& say) {
      set_thread_count(chosen);
      how.go_on = saying(say);
      return packed(measure_run(*scene, how));
    }));
  }

  const std::vector<TradeAxis>& axes() const { return axes_; }
  const TradeReference& wanted() const { return wanted_; }
  const std::string& scene_name() const { return scene_.name; }

 private:
  ApartResult apart(const Step& step, double seconds, const std::function<std::string(const Say&)>& compute) const {
    options_.progress(step.from, step.doing);
    ApartOptions how;
    how.seconds = seconds;
    how.interrupted = options_.interrupted;
    how.heard = [&](const std::string& percent) {
      options_.progress(step.from + 0.01 * std::stod(percent) * step.share, step.doing);
    };
    return run_apart(compute, how);
  }

  std::filesystem::path reference_file(const char* extension) const {
    const std::filesystem::path& folder =
        options_.reference_from.empty() ? options_.directory : options_.reference_from;
    return folder / (scene_.name + "_reference_" + key_ + extension);
  }
  std::filesystem::path fields() const { return reference_file(".cbor"); }
  /// Not .json: those of a folder are result documents, which `finegauge report` reads.
  std::filesystem::path errors() const { return reference_file(".jsonl"); }

  /// Of all that the reference depends on, so that one that is found is the right one.
  std::string reference_key() const {
    const Environment here = describe_environment(1);
    std::string text = sha256_of_file(options_.scene) + geometry_;
    for (const std::string& one : {here.version, here.commit, here.compiler, here.flags}) text += "\n" + one;
    for (const auto& list : {options_.set, wanted_.fine, wanted_.coarser}) {
      text += "\n";  // what one list ends with is not what the next begins with
      for (const std::string& one : list) text += "\n" + one;
    }
    constexpr std::size_t digits = 16;
    return sha256(text).substr(0, digits);
  }

  bool record(const std::filesystem::path& file) const {
    const Scene fine = read_scene(options_.scene, joined(options_.set, wanted_.fine));
    const std::vector<double> times = instants_of(scene_, longest_time_step(scene_), instants);
    const ApartResult made = apart({0.0, reference_share, "the reference run"}, no_limit, [&](const Say& say) {
      std::string why;
      const auto reference = record_reference(fine, times, why, saying(say));
      if (!reference) throw std::runtime_error(why);
      return bytes_as_text(to_bytes(*reference));
    });
    if (made.end == ApartResult::End::stopped) return false;
    if (made.end == ApartResult::End::refused) throw SceneError(made.why);
    if (made.end != ApartResult::End::done)
      throw std::runtime_error("the reference run: " + made.why + "; its settings can be changed by --reference");
    write_file_atomically(file, made.bytes);
    return true;
  }

  bool compare_references(const std::filesystem::path& file) const {
    const Scene coarser = read_scene(options_.scene, joined(options_.set, wanted_.coarser));
    MeasureOptions how;
    how.reference = &*reference_;
    const ApartResult made =
        apart({reference_share, coarser_share, "a coarser reference, for how far the reference itself is off"},
              no_limit, [&](const Say& say) {
                how.go_on = saying(say);
                return packed(measure_run(coarser, how));
              });
    if (made.end == ApartResult::End::stopped) return false;
    if (made.end == ApartResult::End::refused) throw SceneError(made.why);
    const MeasuredRun run = unpacked(made);
    if (!run.complete)
      throw std::runtime_error("the coarser reference run: " + run.why_incomplete +
                               "; its settings can be changed by --reference");
    write_file_atomically(
        file,
        Json({{"errors", to_json(run).at("errors")}, {"fine", wanted_.fine}, {"coarser", wanted_.coarser}}).dump());
    return true;
  }

  const TradeOptions& options_;
  Scene scene_;
  std::vector<TradeAxis> axes_;
  TradeReference wanted_;
  std::string key_, geometry_;
  std::optional<ReferenceRun> reference_;
};

/// Rounds of the plan; jobs that the journal has are taken from it. False when interrupted.
bool try_settings(const TradeOptions& options, const Sweeper& sweeper, Journal& journal, TradeSweep& sweep) {
  std::map<int, Json> done;
  for (const Json& line : journal.lines())
    if (line.contains("job")) done[line.at("job").get<int>()] = line;
  TradePlan plan(sweeper.axes(), options.points, options.seed, options.shard.of > 1);
  for (std::vector<TradeSetting> round = plan.next_round(sweep.jobs); !round.empty();
       round = plan.next_round(sweep.jobs))
    for (const TradeSetting& setting : round) {
      TradeJob job;
      job.number = static_cast<int>(sweep.jobs.size());
      job.setting = setting;
      job.elsewhere = !options.shard.has(sweep.jobs.size());
      if (job.elsewhere) {
        sweep.jobs.push_back(std::move(job));
        continue;
      }
      if (const auto found = done.find(job.number); found != done.end()) {
        if (found->second.at("setting") != Json(setting))
          throw UsageError("--resume: the journal's job " + std::to_string(job.number) +
                           " is another setting than the plan's: found " + found->second.at("setting").dump() +
                           ", allowed " + Json(setting).dump());
        job.run = measured_run(found->second.at("run"));
      } else {
        const double share = settings_share / options.points;
        job.run = sweeper.measure(setting, 1, true, options.seconds,
                                  {settings_start + share * job.number, share,
                                   "setting " + std::to_string(job.number + 1) + " of " +
                                       std::to_string(options.points) + ": " + describe(sweeper.axes(), setting)});
        if (options.interrupted() && !job.run.complete) return false;  // what was cut short is not written down
        journal.append({{"job", job.number}, {"setting", setting}, {"run", to_json(job.run)}});
      }
      sweep.jobs.push_back(std::move(job));
    }
  return true;
}

/// Further passes of all settings that are on a front, in an order that no drift of the machine can follow.
bool time_fronts(const TradeOptions& options, const Sweeper& sweeper, Journal& journal, TradeSweep& sweep) {
  std::map<std::pair<int, int>, Json> done;  // by round and job
  std::optional<std::vector<int>> chosen;    // of the first run: a front found again from new times may be another
  for (const Json& line : journal.lines()) {
    if (line.contains("timed")) chosen = line.at("timed").get<std::vector<int>>();
    if (line.contains("round")) done[{line.at("round").get<int>(), line.at("of").get<int>()}] = line;
  }
  if (!chosen) {
    std::set<std::string> names;
    for (const TradeJob& job : sweep.jobs)
      for (const auto& [name, error] : job.run.errors) names.insert(name);
    std::set<int> on_front;
    for (const std::string& name : names)
      for (const std::size_t i : timed_front(sweep.jobs, name)) on_front.insert(static_cast<int>(i));
    chosen = std::vector<int>(on_front.begin(), on_front.end());
    journal.append({{"timed", *chosen}});
  }
  std::mt19937_64 random(options.seed);
  int count = 0;
  for (int round = 0; round < options.timing_rounds; ++round) {
    // Fisher and Yates, by hand: std::shuffle's order is each library's own.
    std::vector<int> order = *chosen;
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    for (const int number : order) {
      TradeJob& job = sweep.jobs[static_cast<std::size_t>(number)];
      ++count;
      if (const auto found = done.find({round, number}); found != done.end()) {
        auto times = found->second.at("frame_ms").get<std::vector<double>>();
        if (!times.empty()) job.more_passes.push_back(std::move(times));
        continue;
      }
      const double share = (1.0 - timing_start) / (options.timing_rounds * static_cast<double>(chosen->size()));
      const MeasuredRun run = sweeper.measure(
          job.setting, 1, false, no_limit,
          {timing_start + share * (count - 1), share, "timing the front: " + describe(sweeper.axes(), job.setting)});
      if (options.interrupted() && !run.complete) return false;
      // A run that failed this time is written down too, or each --resume would try it again.
      std::vector<double> times = run.complete ? run.frame_ms.front() : std::vector<double>{};
      journal.append({{"round", round}, {"of", number}, {"frame_ms", times}});
      if (!times.empty()) job.more_passes.push_back(std::move(times));
    }
  }
  return true;
}

}  // namespace

std::vector<std::vector<double>> all_passes(const TradeJob& job) {
  std::vector<std::vector<double>> passes = job.run.frame_ms;
  passes.insert(passes.end(), job.more_passes.begin(), job.more_passes.end());
  return passes;
}

bool counts(const std::vector<TradeJob>& jobs, const TradeJob& job) {
  return !job.more_passes.empty() || std::ranges::all_of(jobs, [](const TradeJob& j) { return j.more_passes.empty(); });
}

std::vector<std::size_t> timed_front(const std::vector<TradeJob>& jobs, const std::string& quantity) {
  std::vector<TradePoint> points;
  for (const TradeJob& job : jobs) {
    const auto error = job.run.errors.find(quantity);
    if (job.run.complete && error != job.run.errors.end() && counts(jobs, job))
      points.push_back({frame_timing(all_passes(job)).p99, error->second});
    else
      points.push_back({std::nan(""), std::nan("")});
  }
  return pareto_front(points);
}

std::filesystem::path journal_file(const std::filesystem::path& directory, const std::string& scene) {
  return directory / (scene + "_journal.jsonl");
}

TradeSweep run_trade(const TradeOptions& options) {
  Sweeper sweeper(options);
  Journal journal(journal_file(options.directory, sweeper.scene_name()), sweeper.header(), options.resume);
  TradeSweep sweep;
  sweep.axes = sweeper.axes();
  sweep.reference_overrides = sweeper.wanted().fine;
  sweep.finished = sweeper.check_start() && sweeper.prepare_reference(sweep) &&
                   try_settings(options, sweeper, journal, sweep) && time_fronts(options, sweeper, journal, sweep);
  return sweep;
}

MeasuredRun run_again(const TradeOptions& options, const TradeSweep& sweep, const TradeSetting& setting, int passes) {
  Sweeper sweeper(options);
  TradeSweep unused = sweep;
  if (!sweeper.prepare_reference(unused)) return {};
  return sweeper.measure(setting, passes, true, no_limit, {1.0, 0.0, "confirming an answer"});
}

}  // namespace finegauge
