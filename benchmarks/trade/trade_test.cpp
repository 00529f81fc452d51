#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <random>
#include <set>

#include "benchmarks/program/command.hpp"
#include "benchmarks/trade/front.hpp"
#include "benchmarks/trade/journal.hpp"
#include "benchmarks/trade/trade_result.hpp"
#include "core/parallel/for_parts.hpp"
#include "core/scene/scene_error.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/run_apart.hpp"
#include "verification/support/scene_text.hpp"

namespace finegauge {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

constexpr const char* beam = R"(
name = "beam"
[box]
size = [4, 1, 1]
cells = [4, 1, 1]
[material]
youngs_modulus = 1000
poisson_ratio = 0.3
[[support]]
surface = "x_min"
[[load]]
surface = "x_max"
total_force = [0, 0, -1]
[[quantity]]
kind = "energy"
)";

/// A folder that lives as long as this value.
struct TemporaryFolder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("finegauge_trade_" + std::to_string(::getpid()));
  TemporaryFolder() {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path); }
};

TradeOptions options_for(const std::filesystem::path& scene, const std::filesystem::path& folder) {
  TradeOptions options;
  options.scene = scene;
  options.points = 10;
  options.timing_rounds = 2;
  options.directory = folder;
  options.reference = {"adapt.max_dofs=3000"};
  return options;
}

/// All of a sweep that does not depend on the machine's speed.
Json without_times(const TradeSweep& sweep) {
  Json rows = trade_rows(sweep, "energy_norm");
  for (Json& row : rows)
    for (const char* key : {"frame_ms", "frames_per_second", "promised_rate", "fronts", "on_front", "peak_memory_mb"})
      row.erase(key);
  return rows;
}

}  // namespace

TEST_CASE("the front is what no other point beats, by brute force") {
  std::vector<TradePoint> points = {{1.0, nan}, {nan, 1.0}};
  unsigned state = 7;
  const auto next = [&] { return static_cast<double>((state = state * 1664525u + 1013904223u) >> 24); };  // with ties
  for (int i = 0; i < 400; ++i) points.push_back({next() + 1.0, next() + 1.0});
  const std::vector<std::size_t> front = pareto_front(points);
  REQUIRE(front.size() > 2);
  const auto beats = [](const TradePoint& a, const TradePoint& b) {
    return a.cost <= b.cost && a.error <= b.error && (a.cost < b.cost || a.error < b.error);
  };
  std::set<std::pair<double, double>> expected, found;
  for (const TradePoint& p : points)
    if (!std::isnan(p.cost) && !std::isnan(p.error) &&
        std::ranges::none_of(points, [&](const TradePoint& q) { return beats(q, p); }))
      expected.insert({p.cost, p.error});
  for (const std::size_t i : front) found.insert({points[i].cost, points[i].error});
  CHECK(found == expected);
  CHECK(found.size() == front.size());
}

TEST_CASE("a question is answered by the fastest setting that is right enough, or by what comes nearest") {
  const std::vector<TradeOffer> offers = {{0.5, 1000.0}, {0.1, 100.0}, {0.09, 80.0}, {0.01, 10.0}};
  CHECK(*cheapest(offers, {0.1, 50.0}) == 1);
  CHECK(*cheapest(offers, {0.095, 50.0}) == 2);
  CHECK_FALSE(cheapest(offers, {0.05, 50.0}));
  const NearestOffers near = nearest(offers, {0.05, 50.0});
  CHECK(*near.fast_enough == 2);
  CHECK(*near.right_enough == 3);
  CHECK_FALSE(nearest(offers, {0.001, 5000.0}).fast_enough);
}

TEST_CASE("a promised rate is below that of the worst pass") {
  std::vector<std::vector<double>> passes(3, std::vector<double>(200, 1.0));
  passes[1][10] = passes[1][20] = passes[1][30] = 4.0;  // more than one frame in a hundred
  const FrameTiming timing = frame_timing(passes);
  CHECK(timing.p50 == 1.0);
  CHECK(timing.p99 == 1.0);
  CHECK(timing.worst_p99 == 4.0);
  CHECK(timing.noise == 1.5);
  CHECK(std::abs(promised_rate(timing) - 1000.0 / (2.5 * 4.0)) < 1e-9);  // passes differ by that noise
  passes[1] = passes[0];
  CHECK(std::abs(promised_rate(frame_timing(passes)) - 1000.0 / 1.1) < 1e-9);
  CHECK_THROWS_AS(frame_timing(std::vector<std::vector<double>>{}), std::invalid_argument);
}

TEST_CASE("settings fill the space evenly for every seed, and no setting comes twice") {
  const TemporaryFile file("beam.toml", beam);
  const std::vector<TradeAxis> axes = trade_axes(read(beam), 1, 4);
  REQUIRE(axes.size() >= 3);
  for (const std::uint64_t seed : {1, 2, 3}) {
    TradePlan plan(axes, 50, seed);
    const std::vector<TradeSetting> settings = plan.next_round({});
    CHECK(settings.size() == 30);
    CHECK(settings.front() == own_setting(axes));
    CHECK(std::set<TradeSetting>(settings.begin(), settings.end()).size() == settings.size());
    // Of the 29 others each choice of an axis gets its share but for a few: a random draw would often miss by more.
    for (std::size_t a = 0; a < axes.size(); ++a) {
      std::vector<int> count(axes[a].choices.size());
      for (std::size_t i = 1; i < settings.size(); ++i) ++count[static_cast<std::size_t>(settings[i][a])];
      const double share = 29.0 / static_cast<double>(count.size());
      for (const int n : count) CHECK(std::abs(n - share) <= 0.5 * share + 1.0);
    }
  }
}

TEST_CASE("every setting of an axis is a scene that can be read, and is told by its own words") {
  for (const char* name : {"phantom", "liver", "lshape", "displacement_field"}) {
    const std::filesystem::path file = reference_data() / "scenes" / (std::string(name) + ".toml");
    const Scene scene = read_scene(file);
    const std::vector<TradeAxis> axes = trade_axes(scene, 1, 4);
    for (std::size_t a = 0; a < axes.size(); ++a) {
      CHECK(axes[a].choices[static_cast<std::size_t>(axes[a].own)].overrides.empty());
      for (int c = 0; c < static_cast<int>(axes[a].choices.size()); ++c) {
        if (axes[a].name == "base_mesh" && scene.geometry.index() == 1) continue;  // an organ is cut anew: seconds
        TradeSetting setting = own_setting(axes);
        setting[a] = c;
        const std::vector<std::string> set = overrides(axes, setting);
        INFO(name << ": " << describe(axes, setting));
        CHECK_NOTHROW(read_scene(file, set));
        CHECK((set.empty() && threads(axes, setting) == 0) == (c == axes[a].own));
      }
    }
  }
}

TEST_CASE("a sweep that is stopped anywhere and resumed has the rows of one that was left alone") {
  const TemporaryFile file("beam.toml", beam);
  const TemporaryFolder whole_folder;
  TradeOptions options = options_for(file.path(), whole_folder.path / "whole");
  const TradeSweep whole = run_trade(options);
  REQUIRE(whole.finished);
  REQUIRE(whole.jobs.size() == 10);
  CHECK(whole.jobs.front().run.complete);
  CHECK_THROWS_AS(run_trade(options), UsageError);  // without --resume nothing is overwritten
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(options.directory)) {
    ++files;
    CHECK(entry.path().extension() != ".json");  // `finegauge report` would take it for a result document
  }
  CHECK(files == 3);  // the journal, the reference, and how far that is off

  options.directory = whole_folder.path / "cut";
  int asked = 0;
  bool finished = false;
  int starts = 0;
  for (int allowed = 3; !finished; allowed += 4) {
    asked = 0;
    options.interrupted = [&] { return ++asked > allowed; };
    const TradeSweep part = run_trade(options);
    finished = part.finished;
    options.resume = true;
    ++starts;
    if (finished) CHECK(without_times(part) == without_times(whole));
  }
  CHECK(starts > 3);

  // What a kill in the middle of a line leaves: the line is as if it had not been written.
  const std::filesystem::path journal = options.directory / "beam_journal.jsonl";
  std::filesystem::resize_file(journal, std::filesystem::file_size(journal) / 2);
  options.interrupted = [] { return false; };
  CHECK(without_times(run_trade(options)) == without_times(whole));

  options.seed = 2;
  CHECK_THROWS_AS(run_trade(options), UsageError);  // another sweep's journal

  options.seed = 1;  // a line that is of another plan: its setting is not the one of this number
  std::ifstream in(journal);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::size_t at = text.find("\"setting\":[") + 11;
  text[at] = text[at] == '0' ? '1' : '0';
  std::ofstream(journal) << text;
  CHECK_THROWS_AS(run_trade(options), UsageError);
}

TEST_CASE("a sweep that is killed ten times at random moments and resumed has the rows of one that was left alone") {
  const TemporaryFile file("beam.toml", beam);
  const TemporaryFolder folder;
  TradeOptions options = options_for(file.path(), folder.path / "whole");
  const auto start = std::chrono::steady_clock::now();
  const TradeSweep whole = run_trade(options);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  std::mt19937 random(7);
  std::uniform_real_distribution<double> moment(0.0, seconds);
  std::set<std::uintmax_t> sizes;  // of the journals after the kills
  for (int killed = 0, sweeps = 0; killed < 10; ++sweeps) {
    // The first ones are mostly killed in the reference run, which the others take from the sweep that was left alone.
    if (killed >= 3) options.reference_from = folder.path / "whole";
    options.directory = folder.path / std::to_string(sweeps);
    const std::filesystem::path journal = options.directory / "beam_journal.jsonl";
    for (bool ended = false; !ended && killed < (options.reference_from.empty() ? 3 : 10);) {
      options.resume = std::filesystem::exists(journal);
      end_openmp_threads();
      const pid_t child = ::fork();
      if (child == 0) {
        try {
          run_trade(options);
        } catch (...) {
          ::_exit(2);
        }
        ::_exit(0);
      }
      REQUIRE(child > 0);
      ::usleep(static_cast<useconds_t>(1e6 * moment(random)));
      ::kill(child, SIGKILL);
      int status = 0;
      REQUIRE(::waitpid(child, &status, 0) == child);
      ended = WIFEXITED(status);
      if (ended) REQUIRE(WEXITSTATUS(status) == 0);
      killed += !ended;
      sizes.insert(std::filesystem::exists(journal) ? std::filesystem::file_size(journal) : 0);
    }
    options.resume = std::filesystem::exists(journal);
    CHECK(without_times(run_trade(options)) == without_times(whole));
  }
  CHECK(sizes.size() >= 3);  // kills came in the middle, and the sweep went on from there
}

TEST_CASE("a sweep that cannot start says so and writes nothing") {
  const TemporaryFolder folder;
  const auto sweep = [&](const std::string& text) {
    const TemporaryFile file("beam.toml", text);
    TradeOptions options = options_for(file.path(), folder.path / "none");
    options.reference_from = text == beam ? folder.path / "elsewhere" : std::filesystem::path();
    return run_trade(options);
  };
  CHECK_THROWS_AS(sweep(std::string(beam) + "[[quantity]]\nkind = \"displacement\"\npoint = [5, 0, 0]\n"), SceneError);
  CHECK_THROWS_AS(sweep(beam), UsageError);  // its reference is not there

  // A coarser run with the reference's settings would say that the reference is exact.
  const TemporaryFile file("beam.toml", beam);
  TradeOptions options = options_for(file.path(), folder.path / "none");
  options.reference = {"box.cells=[8, 2, 2]", "adapt.max_dofs=3000"};
  options.interrupted = [] { return true; };
  CHECK_THROWS_AS(run_trade(options), UsageError);
  CHECK_FALSE(std::filesystem::exists(folder.path / "none"));
  options.coarser = {"adapt.max_dofs=1000"};
  CHECK_FALSE(run_trade(options).finished);  // interrupted, not refused
}

TEST_CASE("a journal is written with its first line, by one sweep at a time, and never over another file") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path / "journal.jsonl";
  const Json header = {{"sweep", "test"}, {"name", "not UTF-8: \xff"}};
  const auto content = [&] {
    std::ifstream in(file);
    return std::string{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  };
  {
    Journal journal(file, header, false);
    CHECK_FALSE(std::filesystem::exists(file));
    journal.append({{"job", 0}, {"why", "\xff"}});
    CHECK_THROWS_AS(Journal(file, header, true), UsageError);  // at the same time
    journal.append({{"job", 1}});
  }
  const std::string whole = content();
  CHECK(std::ranges::count(whole, '\n') == 3);
  std::ofstream(file, std::ios::app) << "{\"job\": 2";
  {
    Journal journal(file, header, true);
    CHECK(journal.lines().size() == 2);
    CHECK(content().size() > whole.size());  // read, not yet mended
    journal.append({{"job", 3}});
  }
  CHECK(content() == whole + "{\"job\":3}\n");
  CHECK_THROWS_AS(Journal(file, header, false), UsageError);
  CHECK_THROWS_AS(Journal(file, {{"sweep", "other"}}, true), UsageError);
  for (const char* foreign : {"results of a year\n", "results of a year"}) {
    std::ofstream(file) << foreign;
    CHECK_THROWS_AS(Journal(file, header, true), UsageError);
    CHECK(content() == foreign);
  }
}

TEST_CASE(
    "settings that were timed once are no answer once others were timed again, nor are errors below the truth's") {
  TradeSweep sweep;
  sweep.reference_errors = {{"energy_norm", 0.05}, {"energy", 0.0}};
  const auto job = [&](double ms, double error) {
    TradeJob& made = sweep.jobs.emplace_back();
    made.number = static_cast<int>(sweep.jobs.size()) - 1;
    made.run.complete = true;
    made.run.frame_ms = {{ms}};
    made.run.errors = {{"energy_norm", error}, {"energy", error}};
  };
  job(1.0, 0.2), job(2.0, 0.1), job(4.0, 0.01), job(0.5, 0.3);
  CHECK(*answer(sweep, "energy_norm", {0.5, 1.0}).job == 3);
  for (const std::size_t i : {0, 1, 2}) sweep.jobs[i].more_passes = {sweep.jobs[i].run.frame_ms.front()};
  CHECK(*answer(sweep, "energy_norm", {0.5, 1.0}).job == 0);
  CHECK(timed_front(sweep.jobs, "energy_norm") == std::vector<std::size_t>{0, 1, 2});
  for (const TradeQuestion& question : questions_of_front(sweep, "energy_norm")) CHECK(question.error > 0.05);
  const auto told = [&](const char* quantity, double error) {
    return to_json(sweep, answer(sweep, quantity, {error, 1.0}), quantity, "scene.toml", {});
  };
  CHECK(told("energy_norm", 0.02)["below_reference"] == true);
  CHECK(told("energy_norm", 0.15)["below_reference"] == false);
  CHECK(told("energy", 0.02)["below_reference"].is_null());  // the same as a coarser one: nothing is known
  sweep.jobs[3].run.complete = false;
  sweep.jobs[3].run.why_incomplete = "refused";
  sweep.jobs[3].run.frame_ms.clear();
  const Json rows = trade_rows(sweep, "energy_norm");
  CHECK(rows[3]["frame_ms"]["p99"].is_null());
  CHECK(rows[3]["frame_ms_reason"] == "refused");
  CHECK(rows[0]["dofs"].is_number());
}

TEST_CASE("errors fall along the front as the mesh gets finer") {
  const TemporaryFile file("beam.toml", beam);
  const TemporaryFolder folder;
  const TradeSweep sweep = run_trade(options_for(file.path(), folder.path));
  const std::vector<TradeOffer> all = offers(sweep, "energy");
  const auto questions = questions_of_front(sweep, "energy");
  REQUIRE_FALSE(questions.empty());
  for (const TradeQuestion& question : questions) {
    const TradeAnswer found = answer(sweep, "energy", question);
    REQUIRE(found.job);
    CHECK(found.offer.error <= question.error);
    CHECK(found.offer.rate >= question.rate);
  }
  // The energy's error is the square of the energy norm's, for loads alone and cells like the reference's; the samples
  // integrate within 5 %.
  const auto dilatation = std::ranges::find(sweep.axes, "dilatation", &TradeAxis::name) - sweep.axes.begin();
  for (const TradeJob& job : sweep.jobs)
    if (job.run.complete && job.run.errors.at("energy") > 0.01 &&
        job.setting[static_cast<std::size_t>(dilatation)] == 0)
      CHECK(std::abs(job.run.errors.at("energy_norm") / std::sqrt(job.run.errors.at("energy")) - 1.0) < 0.1);
  CHECK_FALSE(answer(sweep, "energy", {1e-9, 1e9}).job);
}

TEST_CASE("work in a process of its own ends as what it was") {
  using End = ApartResult::End;
  const ApartResult refusal = run_apart([]() -> std::string { throw SceneError("scene.toml:3: no"); }, 60.0);
  CHECK(refusal.end == End::refused);
  CHECK(refusal.why == "scene.toml:3: no");
  CHECK(run_apart([] { return std::string(300000, 'x'); }, 60.0).bytes.size() == 300000);
  CHECK(run_apart([]() -> std::string { throw std::runtime_error("no luck"); }, 60.0).why == "no luck");
  CHECK(run_apart(
            []() -> std::string {
              ::raise(SIGKILL);
              return {};
            },
            60.0)
            .end == End::crashed);
  CHECK(run_apart(
            []() -> std::string {
              for (;;) ::usleep(1000);  // waits: wall time
            },
            0.01)
            .end == End::too_long);
  const ApartResult busy = run_apart(
      []() -> std::string {
        for (volatile bool on = true; on;) {
        }
        return {};
      },
      1.0);
  CHECK(busy.end == End::too_long);
  CHECK(busy.why == "no end within 1 s of processor time");
  CHECK(run_apart(
            []() -> std::string {
              for (;;) ::usleep(1000);
            },
            60.0, [] { return true; })
            .end == End::stopped);
}

TEST_CASE("a setting has the threads that it chooses, whatever the command has", "[trade][parallel]") {
  const auto parts = [] {
    std::atomic<int> count = 0;
    for_parts(2, 1, [&](int, int) { ++count; });
    return count.load();
  };
  use_threads(1);
  CHECK(parts() == 1);
  set_thread_count(2);
  CHECK(parts() == std::min(2, thread_count()));  // one where the core is built without OpenMP
  use_threads(1);
  CHECK(parts() == 1);
  // No axis where there is one processor, as for parts of a sweep, which may share a machine.
  const TemporaryFile file("beam.toml", beam);
  const auto has_axis = [&](int own, int processors) {
    const std::vector<TradeAxis> axes = trade_axes(read(beam), own, processors);
    return std::ranges::find(axes, "threads", &TradeAxis::name) != axes.end();
  };
  CHECK(has_axis(1, 2));
  CHECK_FALSE(has_axis(1, 1));
  CHECK_FALSE(has_axis(2, 1));
}

}  // namespace finegauge
