#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <utility>

#include "benchmarks/commands/commands.hpp"
#include "benchmarks/measure/overrides.hpp"
#include "benchmarks/program/command.hpp"
#include "benchmarks/program/interrupt.hpp"
#include "benchmarks/program/sha256.hpp"
#include "benchmarks/program/shard.hpp"
#include "benchmarks/trade/trade_output.hpp"
#include "benchmarks/trade/trade_result.hpp"
#include "core/parallel/for_parts.hpp"
#include "core/scene/scene_reader.hpp"

namespace finegauge {
namespace {

struct TradeCommand {
  std::string scene, quantity = "energy_norm", reference_from, shard;
  std::vector<std::string> reference, coarser;
  std::vector<double> errors, rates;
  int points = 40;
  std::uint64_t seed = 1;
  double seconds = 600.0;
  bool resume = false, confirm = false;
  CommonOptions common;
};

constexpr int quick_points = 8;

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

void require_positive(const char* option, double value) {
  if (!(value > 0.0 && std::isfinite(value)))
    throw UsageError(std::string("trade: ") + option + ": found " + std::to_string(value) +
                     ", allowed is finite and > 0");
}

void check_usage(const TradeCommand& asked, const Scene& scene) {
  require_positive("--seconds", asked.seconds);
  for (const double error : asked.errors) require_positive("--error", error);
  for (const double rate : asked.rates) require_positive("--rate", rate);
  for (const auto& [option, list] : {std::pair("--reference ", &asked.reference), {"--coarser ", &asked.coarser}})
    for (const std::string& text : *list)
      if (const std::size_t equals = text.find('='); equals == std::string::npos || equals == 0)
        throw UsageError(option + text + ": expected KEY=VALUE");
  if (asked.errors.size() != asked.rates.size())
    throw UsageError("trade: each --error needs its --rate: found " + std::to_string(asked.errors.size()) + " and " +
                     std::to_string(asked.rates.size()));
  std::vector<std::string> known = {"energy_norm"};
  for (const QuantityOfInterest& quantity : scene.quantities) {
    if (quantity.name == known.front())
      throw UsageError(asked.scene + ": quantity: name: found " + known.front() +
                       ", which trade has for the energy norm of the error; allowed is any other name");
    known.push_back(quantity.name);
  }
  if (std::ranges::find(known, asked.quantity) == known.end())
    throw UsageError("trade: --quantity " + asked.quantity + ": this scene has " + join(known));
}

TradeOptions options_of(const TradeCommand& asked, const Scene& scene, const std::filesystem::path& directory) {
  TradeOptions options;
  options.scene = asked.scene;
  options.set = asked.common.set;
  options.reference = asked.reference;
  options.coarser = asked.coarser;
  options.points = asked.common.quick ? std::min(asked.points, quick_points) : asked.points;
  if (asked.common.quick)
    for (std::string& one : quick_overrides(scene)) options.set.push_back(std::move(one));
  options.seed = asked.seed;
  options.seconds = asked.seconds;
  options.timing_rounds = asked.common.quick ? 1 : 3;
  options.threads = asked.common.threads;
  options.shard = parse_shard(asked.shard);
  options.resume = asked.resume;
  options.directory = directory;
  options.reference_from = asked.reference_from;
  options.interrupted = [] { return interrupt_signal() != 0; };
  return options;
}

/// Each answer once more, in random order: its error the same, since a run is the same to the last bit on the same
/// machine, and its rate what was promised.
void confirm_answers(const TradeOptions& options, const TradeSweep& sweep, const std::string& quantity,
                     const std::vector<TradeAnswer>& answers, const Progress& progress, ResultDocument& document) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < answers.size(); ++i)
    if (answers[i].job) order.push_back(i);
  document.checks.push_back(check("answers_to_confirm", static_cast<double>(order.size()), 1.0,
                                  std::max(1.0, static_cast<double>(answers.size()))));
  std::mt19937_64 random(options.seed + 1);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  for (const std::size_t i : order) {
    if (options.interrupted()) return;
    progress.note("confirming answer " + std::to_string(i + 1));
    const MeasuredRun run = run_again(options, sweep, sweep.jobs[*answers[i].job].setting, 1);
    if (options.interrupted() && !run.complete) return;
    const std::string name = "answer" + std::to_string(i + 1);
    const bool complete = run.complete && run.errors.contains(quantity);
    const double error = complete ? run.errors.at(quantity) : std::nan("");
    const double rate = complete ? 1e3 / frame_timing(run.frame_ms).p99 : std::nan("");
    const double promised = answers[i].offer.error;
    constexpr double bits = 1e-12;
    document.checks.push_back(
        check(name + ".reproducible", error == promised ? 0.0 : std::abs(error - promised) / promised, 0.0, bits));
    document.checks.push_back(check(name + ".rate", rate, answers[i].offer.rate, 1e9));
  }
}

int trade(const TradeCommand& asked) {
  const CommonOptions& common = asked.common;
  (void)parse_overrides(common.set);
  const Scene scene = read_scene(asked.scene, common.set);
  check_usage(asked, scene);
  if (common.threads > processor_count())
    throw UsageError("trade: --threads: found " + std::to_string(common.threads) +
                     ", allowed are the processors of this machine, " + std::to_string(processor_count()) +
                     ": times of more would say nothing");
  const Shard shard = parse_shard(asked.shard);
  if (shard.of > 1 && asked.confirm)
    throw UsageError("trade: --confirm: a part has no answers, allowed without --shard");
  const std::filesystem::path directory = common.directory(scene.name + "_trade");
  require_writable(directory);
  use_threads(common.threads);
  Progress progress(common.quiet);
  TradeOptions options = options_of(asked, scene, directory);
  options.progress = [&](double fraction, const std::string& doing) { progress.update(fraction, doing); };

  ResultDocument document;
  document.kind = "trade";
  document.name = scene.name;
  document.quick = common.quick;
  document.inputs = {asked.scene, sha256_of_file(asked.scene), parse_overrides(options.set)};
  document.environment = describe_environment(common.threads);

  const TradeSweep sweep = run_trade(options);
  document.rows = trade_rows(sweep, asked.quantity);
  std::vector<TradeQuestion> asked_questions;
  for (std::size_t i = 0; i < asked.errors.size(); ++i) asked_questions.push_back({asked.errors[i], asked.rates[i]});
  std::vector<TradeQuestion> questions = asked_questions;
  if (questions.empty() && sweep.finished) questions = questions_of_front(sweep, asked.quantity);
  std::vector<TradeAnswer> answers;
  for (const TradeQuestion& question : questions) answers.push_back(answer(sweep, asked.quantity, question));
  if (sweep.finished && shard.of == 1)
    document.checks.push_back(check("settings_on_front",
                                    static_cast<double>(timed_front(sweep.jobs, asked.quantity).size()), 1.0,
                                    static_cast<double>(sweep.jobs.size())));
  if (asked.confirm && sweep.finished) confirm_answers(options, sweep, asked.quantity, answers, progress, document);
  progress.clear();

  document.summary["finished"] = sweep.finished;
  document.summary["seed"] = asked.seed;
  document.summary["questions"] = Json::array();
  for (const TradeQuestion& question : asked_questions)
    document.summary["questions"].push_back({{"error", question.error}, {"rate", question.rate}});
  if (shard.of > 1) {
    document.summary["jobs"] = sweep.jobs.size();
    document.summary["shard"] = asked.shard;
    summarize_sweep(sweep, asked.quantity, document);
    progress.note("part " + asked.shard + ": " + std::to_string(document.rows.size()) + " of " +
                  std::to_string(sweep.jobs.size()) + " settings; finegauge merge joins the parts and finds the front");
  } else {
    summarize_sweep(sweep, asked.quantity, document);
    conclude_sweep(sweep, asked.quantity, answers, document, directory, !common.json, progress);
  }
  if (!sweep.finished) progress.note("interrupted: --resume goes on with it");
  if (!common.json) std::fflush(stdout);
  return finish(document, common, directory, progress);
}

}  // namespace

void add_trade_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "trade", "Speed against accuracy: tries what a user can choose in a scene, and finds what pays");
  const auto asked = std::make_shared<TradeCommand>();
  command->add_option("SCENE", asked->scene, "Scene file (finegauge help scene)")->required();
  command->add_option("--error", asked->errors, "Largest error allowed, a fraction; repeatable, with a --rate each")
      ->check(CLI::PositiveNumber);
  command->add_option("--rate", asked->rates, "Frames per second that 99 of 100 frames must keep; repeatable")
      ->check(CLI::PositiveNumber);
  command->add_option("--quantity", asked->quantity,
                      "What the error is of: energy_norm (default) or a quantity of the scene");
  command->add_option("--points", asked->points, "Settings to try (default 40)")->check(CLI::Range(1, 100000));
  command->add_option("--seed", asked->seed, "Of the settings that are tried (default 1)");
  command->add_option("--seconds", asked->seconds, "That one run may take before it counts as too slow (default 600)")
      ->check(CLI::PositiveNumber);
  command->add_option(
      "--reference", asked->reference,
      "KEY=VALUE on top of the reference's settings; repeatable. By default it has twice the cells along "
      "each axis, half the time step, tighter tolerances");
  command->add_option(
      "--coarser", asked->coarser,
      "KEY=VALUE on top of those of the coarser run that tells how far the reference is off; repeatable");
  command->add_option("--reference-from", asked->reference_from, "Directory of a sweep that has the reference already");
  command
      ->add_option("--shard", asked->shard,
                   "Every N-th setting only, from the I-th on; finegauge merge joins the parts")
      ->type_name("I/N");
  command->add_flag("--resume", asked->resume, "Goes on with the sweep in --out; what was finished is not repeated");
  command->add_flag("--confirm", asked->confirm, "Runs each answer once more, and checks what was promised");
  add_common_options(*command, asked->common,
                     "KEY=VALUE: replaces a key of the scene before anything is tried; repeatable");
  command->footer(
      "The error of each run is its distance from a finer run of the scene, the reference, in the energy norm and for\n"
      "each quantity; how far a coarser reference is from it is printed. Settings fill the space evenly first and\n"
      "come nearer to the front then. Those on a front are timed three times more, in random order. A promised rate\n"
      "is what the worst pass kept in 99 of 100 frames, less a tenth or the noise. Numbers of threads, up to that\n"
      "of the processors, are among the settings, but not of a part (--shard). Writes NAME.json, NAME.csv, a plot\n"
      "per quantity, NAME_journal.jsonl (finished runs, for --resume) and the reference.\n"
      "\n"
      "Examples:\n"
      "  finegauge trade reference_data/scenes/phantom.toml --error 0.3 --rate 30 -o phantom_trade\n"
      "  finegauge trade my_scene.toml --points 100 --quantity tip_force --resume\n"
      "\n"
      "In parts, on machines with the same processor; all of them fill the space, and none comes nearer to the front:\n"
      "  finegauge trade my_scene.toml --points 1 -o ref\n"
      "  parallel finegauge trade my_scene.toml --points 400 --reference-from ref --shard {}/8 -o part_{} ::: "
      "{1..8}\n"
      "  finegauge merge part_* -o results/my_trade\n"
      "or, of a Slurm array (sbatch --array=1-8), each task with --shard $SLURM_ARRAY_TASK_ID/8.");
  command->callback([&exit_code, asked] { exit_code = trade(*asked); });
}

}  // namespace finegauge
