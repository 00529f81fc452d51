#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "benchmarks/program/command.hpp"
#include "verification/support/catch.hpp"

namespace fs = std::filesystem;

namespace {

/// The program beside this test, or the one that the environment names.
fs::path program() {
  if (const char* given = std::getenv("FINEGAUGE_PROGRAM")) return given;
  return fs::read_symlink("/proc/self/exe").parent_path() / "finegauge";
}

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

/// An empty working directory of this test, removed at its end, and runs of the program in it.
class CommandLine {
 public:
  CommandLine() {
    fs::remove_all(root_);
    fs::create_directories(work_);
  }
  ~CommandLine() { fs::remove_all(root_); }

  Outcome run(const std::string& arguments) const {
    const std::string command = "cd '" + work_.string() + "' && '" + program().string() + "' " + arguments + " > '" +
                                (root_ / "out").string() + "' 2> '" + (root_ / "err").string() + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(root_ / "out"), content(root_ / "err")};
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(work_ / name) << text; }
  bool wrote_results() const { return fs::exists(work_ / "results") || fs::exists(work_ / "new"); }
  fs::path work() const { return work_; }

  static std::string content(const fs::path& file) {
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }

 private:
  fs::path root_ = fs::temp_directory_path() / ("finegauge_command_line_" + std::to_string(::getpid()));
  fs::path work_ = root_ / "work";
};

// Coarse enough to end in well under a second.
const std::string block = R"(name = "block"
[box]
size = [2, 1, 1]
cells = [4, 2, 2]
[material]
youngs_modulus = 1e3
poisson_ratio = 0.3
[[support]]
surface = "x_min"
[[load]]
surface = "x_max"
traction = [0, 0, -1]
[adapt]
steps = 2
[[quantity]]
kind = "displacement"
name = "tip"
point = [2, 0.5, 0.5]
)";

// A few frames of a coarse block that falls and swings.
const std::string swing = R"(name = "swing"
[box]
size = [2, 1, 1]
cells = [4, 2, 2]
[material]
youngs_modulus = 1e5
poisson_ratio = 0.3
kinematics = "corotational"
[[support]]
surface = "x_min"
[dynamics]
time_step = 0.01
duration = 0.08
density = 1000
gravity = [0, 0, -9.81]
[adapt]
[[quantity]]
kind = "displacement"
name = "end"
point = [2, 0.5, 0.5]
)";

const std::string insertion = R"(name = "insertion"
[box]
size = [0.04, 0.02, 0.02]
cells = [4, 2, 2]
[material]
youngs_modulus = 1e5
poisson_ratio = 0.4
kinematics = "corotational"
[[support]]
surface = "x_max"
[dynamics]
time_step = 0.01
density = 1000
[needle]
youngs_modulus = 1e9
poisson_ratio = 0.3
radius = 1e-3
density = 7800
base = [-0.0325, 0.01, 0.01]
tip = [-0.0005, 0.01, 0.01]
elements = 4
[[stroke]]
displacement = [0.004, 0, 0]
speed = 0.02
[contact]
puncture_strength = 0.02
cut_advance = 1e-3
friction = 0.5
clamping = 1
)";

}  // namespace

TEST_CASE("every command explains itself with an example", "[command-line]") {
  const CommandLine shell;
  for (const std::string arguments :
       {"--help", "list --help", "run --help", "reproduce --help", "atlas --help", "trade --help", "audit --help",
        "profile --help", "gate --help", "report --help", "merge --help", "help --help"}) {
    CAPTURE(arguments);
    const Outcome outcome = shell.run(arguments);
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.out.find("Example") != std::string::npos);
  }
  const Outcome keys = shell.run("help scene");
  CHECK(keys.exit_code == 0);
  CHECK(keys.out.find("poisson_ratio") != std::string::npos);
  CHECK(shell.run("list").exit_code == 0);
}

TEST_CASE("bad usage and bad input end with code 2, a message, and nothing written", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  shell.write("empty.toml", "");
  for (const std::string arguments : {"",
                                      "unknown",
                                      "run",
                                      "run --nonsense block.toml",
                                      "run missing.toml",
                                      "run empty.toml",
                                      "run block.toml --set material.poisson_ratio=0.6",
                                      "run block.toml --set nonsense",
                                      "run block.toml --threads 0",
                                      "run block.toml --set material.colour=3",
                                      "run block.toml --quick --full",
                                      "run block.toml -o new --vtu 0",
                                      "reproduce nonsense -o new",
                                      "profile missing.toml",
                                      "verify nonsense",
                                      "verify --quick",
                                      "atlas nonsense",
                                      "atlas --shard 3/2",
                                      "merge missing -o new",
                                      "reproduce lshape --shard 0/2",
                                      "trade block.toml --rate 30",
                                      "help nonsense"}) {
    CAPTURE(arguments);
    const Outcome outcome = shell.run(arguments);
    CHECK(outcome.exit_code == 2);
    CHECK_FALSE(outcome.err.empty());
    CHECK(outcome.out.empty());
    CHECK_FALSE(shell.wrote_results());
  }
}

TEST_CASE("a command, study or topic that is none is answered with those that there are", "[command-line]") {
  const CommandLine shell;
  for (const std::string arguments : {"nonsense", "reproduce nonsense", "help nonsense"}) {
    CAPTURE(arguments);
    const Outcome outcome = shell.run(arguments);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find("finegauge: ") == 0);  // the program is named once
    CHECK(outcome.err.find(arguments.starts_with("reproduce") ? "lshape" : "reproduce") != std::string::npos);
  }
}

TEST_CASE("a profile is one document of stages, hanging nodes and a trace, of scenes that move and that do not",
          "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  shell.write("swing.toml", swing);
  for (const std::string scene : {"block", "swing"}) {
    const Outcome outcome = shell.run("profile " + scene + ".toml --quick --json");
    CAPTURE(scene, outcome.err);
    REQUIRE(outcome.exit_code == 0);
    const auto printed = nlohmann::json::parse(outcome.out);
    CHECK(printed["kind"] == "profile");
    double shares = 0.0;
    for (const auto& row : printed["rows"]) shares += row["share"].get<double>();
    CHECK(std::abs(shares - 1.0) < 1e-9);
    const auto& summary = printed["summary"];
    CHECK(summary["machine"]["flops_per_second"].get<double>() > 0.0);
    REQUIRE(summary["tjunctions"]["hanging_nodes"].get<int>() > 0);
    for (const std::string handling : {"elementwise", "explicit", "multiplier"})
      CHECK(summary["tjunctions"][handling]["solved"] == true);
    CHECK(summary["instrumentation"].is_object() == (scene == "swing"));
    const auto trace = nlohmann::json::parse(
        CommandLine::content(shell.work() / "results" / (scene + "_profile") / (scene + "_profile_trace.json")));
    CHECK(trace["traceEvents"].size() > 10);
  }
}

TEST_CASE("the parts of a sweep join to what one run writes, and only those that fit together do", "[command-line]") {
  const CommandLine shell;
  const auto read = [&](const std::string& directory) {
    return nlohmann::ordered_json::parse(CommandLine::content(shell.work() / directory / "atlas.json"));
  };
  const auto write = [&](const std::string& directory, const nlohmann::ordered_json& document) {
    fs::create_directories(shell.work() / directory);
    shell.write(directory + "/atlas.json", document.dump());
  };
  const std::string axes = "atlas auxetic half_turn_cell --quiet ";
  REQUIRE(shell.run(axes + "-o whole").exit_code == 0);
  for (const std::string part : {"1", "2", "3"})
    REQUIRE(shell.run(axes + "--shard " + part + "/3 -o part_" + part).exit_code == 0);
  REQUIRE(shell.run("merge part_3 part_1 part_2 part_1 -o joined").exit_code == 0);
  const auto whole = read("whole"), joined = read("joined");
  REQUIRE(whole["rows"].size() > 6);
  REQUIRE(whole["rows"].size() % 3 != 0);  // parts of different sizes
  for (const char* key : {"schema", "kind", "name", "quick", "inputs", "rows", "checks"}) {
    CAPTURE(key);
    CHECK(joined[key] == whole[key]);
  }
  for (const char* key : {"jobs", "axes", "safe", "answered", "first_failing"}) {
    CAPTURE(key);
    CHECK(joined["summary"][key] == whole["summary"][key]);
  }
  for (const char* file : {"atlas.csv", "safe_box.svg"})
    CHECK(CommandLine::content(shell.work() / "joined" / file) == CommandLine::content(shell.work() / "whole" / file));
  CHECK(joined["environment"]["commit"] == whole["environment"]["commit"]);
  REQUIRE(joined["summary"]["parts"].size() == 3);
  double seconds = 0.0;
  for (const auto& part : joined["summary"]["parts"]) seconds += part["environment"]["seconds"].get<double>();
  CHECK_THAT(joined["environment"]["seconds"].get<double>(), Catch::Matchers::WithinRel(seconds, 1e-12));

  const auto part = read("part_2");
  auto other = part;
  other["environment"]["commit"] = "another";
  write("of_another_commit", other);
  (other = part)["rows"][0]["measure"] = 0.125;
  write("with_another_number", other);
  (other = part)["rows"].erase(0);
  write("unfinished", other);
  (other = part)["quick"] = true;
  write("quick", other);
  (other = part)["rows"][0] = read("part_1")["rows"][0];
  write("with_a_row_of_part_1", other);
  other = part;
  std::swap(other["rows"][0], other["rows"][1]);
  write("in_another_order", other);
  struct Refused {
    const char *parts, *words;
  };
  for (const auto& [parts, words] :
       {Refused{"part_1 part_3", "found no part 2/3"}, Refused{"part_1 of_another_commit part_3", "commit"},
        Refused{"part_1 part_2 part_3 with_another_number", "another row"},
        Refused{"part_1 unfinished part_3", "--resume"}, Refused{"part_1 quick part_3", "quick"},
        Refused{"part_1 with_a_row_of_part_1 part_3", "has too"},
        Refused{"part_1 in_another_order part_3", "not in its place"}, Refused{"whole", "found a whole result"},
        Refused{"part_1 .", "found 0 results"}}) {
    CAPTURE(parts);
    const Outcome refused = shell.run(std::string("merge ") + parts + " -o new");
    CHECK(refused.exit_code == 2);
    CAPTURE(refused.err);
    CHECK(refused.err.find(words) != std::string::npos);
    CHECK(std::count(refused.err.begin(), refused.err.end(), '\n') == 1);
    CHECK_FALSE(shell.wrote_results());
  }
  CHECK(shell.run("merge part_1 part_2 part_3 -o part_2").exit_code == 2);
  CHECK(read("part_2") == part);
}

TEST_CASE("a part of the paper's studies is every N-th of those named", "[command-line]") {
  const CommandLine shell;
  // Neither study takes this key, so that the one whose turn it is says so at once.
  const auto run = [&](const std::string& shard) {
    return shell.run("reproduce lshape displacement-field --quick -o new --set nonsense=1 --shard " + shard);
  };
  const Outcome first = run("1/2"), second = run("2/2"), none = run("3/3");
  CHECK(first.exit_code == 2);
  CHECK(first.err.find("notch") != std::string::npos);  // a key of lshape
  CHECK(second.exit_code == 2);
  CHECK(second.err.find("notch") == std::string::npos);
  CHECK(none.exit_code == 0);
  CHECK(none.err.find("no study") != std::string::npos);
}

TEST_CASE("evidence is one document of claims that hold, under its factor of credibility", "[command-line]") {
  const CommandLine shell;
  const Outcome outcome = shell.run("verify use-errors --json");
  CAPTURE(outcome.err);
  REQUIRE(outcome.exit_code == 0);
  const auto printed = nlohmann::json::parse(outcome.out);
  CHECK(printed["kind"] == "verify");
  REQUIRE(printed["rows"].size() == 4);
  CHECK(printed["rows"][0]["factor"] == "use error");
  CHECK(printed["checks"].size() == printed["rows"].size());
  CHECK(printed["summary"]["claims_that_hold"] == printed["summary"]["claims"]);
}

TEST_CASE("a quantity at a point outside the body is refused before anything is written", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block + "[[quantity]]\nkind = \"displacement\"\nname = \"far\"\npoint = [9, 0, 0]\n");
  const Outcome outcome = shell.run("run block.toml");
  CHECK(outcome.exit_code == 2);
  CHECK(outcome.err.find("quantity") != std::string::npos);
  CHECK_FALSE(shell.wrote_results());
}

TEST_CASE("a run writes its files, the same numbers in each, and the same state twice", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  const Outcome first = shell.run("run block.toml --json --vtu 1");
  CAPTURE(first.err);
  REQUIRE(first.exit_code == 0);
  const auto printed = nlohmann::json::parse(first.out);
  const auto written = nlohmann::json::parse(CommandLine::content(shell.work() / "results/block/block.json"));
  CHECK(printed == written);
  REQUIRE(written["rows"].size() == 3);
  CHECK(written["rows"][2]["hanging_nodes"].get<int>() > 0);
  CHECK(written["rows"][0]["quantities"]["tip"][2].get<double>() < 0.0);
  CHECK(written["summary"]["dofs"]["end"] == written["rows"][2]["dofs"]);
  for (const char* name : {"block.csv", "block_mesh.svg", "block_0000.vtu", "block_0002.vtu", "block.pvd"}) {
    CAPTURE(name);
    CHECK(fs::exists(shell.work() / "results/block" / name));
  }
  const Outcome second = shell.run("run block.toml --json --quiet -o new");
  REQUIRE(second.exit_code == 0);
  CHECK(second.err.empty());
  CHECK(nlohmann::json::parse(second.out)["summary"]["state_sha256"] == written["summary"]["state_sha256"]);
}

TEST_CASE("a result of another command under the same name stays, and the new one goes beside it", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  const fs::path usual = shell.work() / "results/block/block.json",
                 beside = shell.work() / "results/block_run/block.json";
  REQUIRE(shell.run("run block.toml --quiet").exit_code == 0);
  REQUIRE(shell.run("run block.toml --quiet").exit_code == 0);  // its own is replaced
  CHECK_FALSE(fs::exists(beside));
  CHECK_THAT(CommandLine::content(usual), ContainsSubstring("\"kind\": \"run\""));

  const std::string of_study = "{\n  \"schema\": \"finegauge/1\",\n  \"kind\": \"reproduce\"\n}\n";
  std::ofstream(usual) << of_study;
  const Outcome run = shell.run("run block.toml");
  CHECK(run.exit_code == 0);
  CHECK_THAT(run.err, ContainsSubstring("results: results/block_run/block.json"));
  CHECK(CommandLine::content(usual) == of_study);
  CHECK_THAT(CommandLine::content(beside), ContainsSubstring("\"kind\": \"run\""));

  // The same for a study, told apart by its kind, and not for a folder that the user names.
  finegauge::CommonOptions options;
  const fs::path here = fs::current_path();
  fs::current_path(shell.work());
  using finegauge::result_directory;
  CHECK(result_directory(options, "block", "reproduce") == "results/block");
  CHECK(result_directory(options, "block", "run") == "results/block_run");
  CHECK(result_directory(options, "none", "run") == "results/none");
  options.out = "results/block";
  CHECK(result_directory(options, "block", "run") == "results/block");
  fs::current_path(here);
}

TEST_CASE("an output directory that cannot be written is refused before anything is computed", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  shell.write("taken", "a file");
  const std::string command = GENERATE("run block.toml", "reproduce lshape");
  const std::string out = GENERATE("taken", "taken/deeper/new", "/proc/finegauge");
  const Outcome outcome = shell.run(command + " -o " + out);
  CAPTURE(command, out, outcome.err);
  CHECK(outcome.exit_code == 2);
  CHECK(outcome.out.empty());
  CHECK(outcome.err.rfind("finegauge: --out " + out + ": found ", 0) == 0);
  CHECK(outcome.err.find("allowed a directory that can be written") != std::string::npos);
  CHECK(outcome.err.find("step") == std::string::npos);
  CHECK(CommandLine::content(shell.work() / "taken") == "a file");
}

TEST_CASE("bad input leaves no output directory behind, not even one that could be written", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block + "[[quantity]]\nkind = \"displacement\"\nname = \"far\"\npoint = [9, 0, 0]\n");
  CHECK(shell.run("run block.toml -o new/deeper").exit_code == 2);
  CHECK(shell.run("reproduce lshape -o new/deeper --set theta=7").exit_code == 2);
  CHECK(std::distance(fs::directory_iterator(shell.work()), {}) == 1);
}

TEST_CASE("every key that the help of reproduce names for lshape is one that it takes", "[command-line]") {
  const CommandLine shell;
  const std::string help = shell.run("reproduce --help").out;
  CHECK(help.find("material.") == std::string::npos);
  for (const char* key : {"notch", "clamped", "roller", "loaded", "theta", "directional_theta"}) {
    CAPTURE(key);
    CHECK(help.find(key) != std::string::npos);
    // The bad last value ends the study while it reads its options; were the first one bad, it would be named.
    const std::string good = std::string(key).find("theta") != std::string::npos ? "0.5"
                             : std::string(key) == "notch"                       ? "lower_left"
                             : std::string(key) == "clamped"                     ? "x_max"
                                                                                 : "y_max";
    const Outcome outcome = shell.run("reproduce lshape --set " + std::string(key) + "=" + good + " --set zzz=1");
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.err.find("--set zzz") != std::string::npos);
  }
}

TEST_CASE("help without a topic lists the commands, and help of a command shows how to type it", "[command-line]") {
  const CommandLine shell;
  const Outcome all = shell.run("help");
  CHECK(all.exit_code == 0);
  for (const char* command : {"list", "run", "reproduce", "Exit codes"})
    CHECK(all.out.find(command) != std::string::npos);
  CHECK(shell.run("help run").out.find("finegauge run [OPTIONS] SCENE") != std::string::npos);
}

TEST_CASE("a quick run is held to the tolerance unless --quick is what ended it", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  const std::string strict = "run block.toml --quick --quiet -o new --set adapt.tolerance=1e-6";
  const Outcome all_steps = shell.run(strict);
  CHECK(all_steps.exit_code == 1);
  CHECK(all_steps.err.find("failed: eta: 0.") != std::string::npos);
  CHECK(all_steps.out.find("tolerance not checked") == std::string::npos);
  // Above the limit of --quick from the first mesh on, with more steps allowed.
  const Outcome cut = shell.run(strict + " --set box.cells=[36,18,18] --set solver.method=multigrid");
  CAPTURE(cut.err);
  CHECK(cut.exit_code == 0);
  CHECK(cut.out.find("tolerance not checked") != std::string::npos);
  const auto written = nlohmann::json::parse(CommandLine::content(shell.work() / "new/block.json"));
  CHECK(written["rows"].size() == 1);
  CHECK(written["summary"]["notes"][0].get<std::string>().find("tolerance not checked") == 0);
}

TEST_CASE("the energy of interest is told apart from the strain energy of the table", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block + "[[quantity]]\nkind = \"energy\"\nname = \"work\"\n");
  const Outcome outcome = shell.run("run block.toml --quiet -o new");
  REQUIRE(outcome.exit_code == 0);
  CHECK(outcome.out.find("strain energy [J]") != std::string::npos);
  CHECK(outcome.out.find("twice the strain energy") != std::string::npos);
  const auto written = nlohmann::json::parse(CommandLine::content(shell.work() / "new/block.json"));
  const auto& last = written["rows"].back();
  CHECK(last["quantities"]["work"].get<double>() == 2.0 * last["strain_energy"].get<double>());
}

TEST_CASE("a doubtful scene is solved, with notes in the table and in the result", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  // Bent by about a radian: linear kinematics, which is the default, makes strain of it.
  const Outcome bent = shell.run("run block.toml --quiet -o new --set load[0].traction=[0,0,-60]");
  CAPTURE(bent.err);
  REQUIRE(bent.exit_code == 0);
  CHECK(bent.out.find("note: cells turn by up to") != std::string::npos);
  auto written = nlohmann::json::parse(CommandLine::content(shell.work() / "new/block.json"));
  REQUIRE(written["summary"]["notes"].size() == 1);
  CHECK(written["summary"]["notes"][0].get<std::string>().find("cells turn by up to") == 0);
  const Outcome idle = shell.run("run block.toml --quiet -o new --set load[0].traction=[0,0,0]");
  CAPTURE(idle.err);
  REQUIRE(idle.exit_code == 0);
  CHECK(idle.out.find("note: nothing acts on the body") != std::string::npos);
  written = nlohmann::json::parse(CommandLine::content(shell.work() / "new/block.json"));
  REQUIRE(written["summary"]["notes"].size() == 1);
  CHECK(written["summary"]["notes"][0].get<std::string>().find("nothing acts") == 0);
  const Outcome plain = shell.run("run block.toml --quiet -o new");
  CHECK(plain.out.find("note:") == std::string::npos);
}

TEST_CASE("the grids of an earlier run are not left among those of a new one", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  REQUIRE(shell.run("run block.toml --quiet --vtu 1 -o new").exit_code == 0);
  REQUIRE(fs::exists(shell.work() / "new/block_0002.vtu"));
  std::ofstream(shell.work() / "new/block_0001_mine.vtu") << "kept";
  REQUIRE(shell.run("run block.toml --quiet --vtu 1 -o new --set adapt.steps=1").exit_code == 0);
  CHECK(fs::exists(shell.work() / "new/block_0001.vtu"));
  CHECK_FALSE(fs::exists(shell.work() / "new/block_0002.vtu"));
  CHECK(fs::exists(shell.work() / "new/block_0001_mine.vtu"));
}

TEST_CASE("a solve that does not converge ends with code 1 and is kept", "[command-line]") {
  const CommandLine shell;
  shell.write("block.toml", block);
  const Outcome outcome = shell.run(
      "run block.toml --quiet --set solver.method=multigrid --set solver.iterations=1 --set "
      "solver.relative_residual=1e-12 --set box.cells=[16,8,8] -o new");
  CHECK(outcome.exit_code == 1);
  CHECK(outcome.err.find("unconverged_frames") != std::string::npos);
  const auto written = nlohmann::json::parse(CommandLine::content(shell.work() / "new/block.json"));
  CHECK(written["rows"].back()["converged"] == false);
  CHECK(written["checks"][0]["ok"] == false);
}

TEST_CASE("a moving run writes a row for each frame, its files, and the same state twice", "[command-line]") {
  const CommandLine shell;
  shell.write("swing.toml", swing);
  const Outcome first = shell.run("run swing.toml --json --vtu 3");
  CAPTURE(first.err);
  REQUIRE(first.exit_code == 0);
  const auto printed = nlohmann::json::parse(first.out);
  const fs::path results = shell.work() / "results/swing";
  CHECK(printed == nlohmann::json::parse(CommandLine::content(results / "swing.json")));
  REQUIRE(printed["rows"].size() == 8);
  CHECK(printed["rows"][7]["time"].get<double>() == Approx(0.08));
  CHECK(printed["rows"][7]["quantities"]["end"][2].get<double>() < 0.0);  // it falls
  CHECK(printed["rows"][7]["energy"]["kinetic"].get<double>() > 0.0);
  CHECK(printed["rows"][0]["force"].is_null());
  CHECK(printed["summary"]["frames"] == 8);
  for (const char* name : {"swing.csv", "swing_mesh.svg", "swing_dofs.svg", "swing_0003.vtu", "swing_0006.vtu",
                           "swing_0008.vtu", "swing.pvd"}) {
    CAPTURE(name);
    CHECK(fs::exists(results / name));
  }
  CHECK_FALSE(fs::exists(results / "swing_force.svg"));
  const Outcome second = shell.run("run swing.toml --json --quiet -o new");
  REQUIRE(second.exit_code == 0);
  CHECK(second.err.empty());
  CHECK(nlohmann::json::parse(second.out)["summary"]["state_sha256"] == printed["summary"]["state_sha256"]);
}

TEST_CASE("a run with a needle tells its forces, events and files", "[command-line][needle]") {
  const CommandLine shell;
  shell.write("insertion.toml", insertion);
  const Outcome outcome = shell.run("run insertion.toml --vtu 20");
  CAPTURE(outcome.err, outcome.out);
  REQUIRE(outcome.exit_code < 2);
  const fs::path results = shell.work() / "results/insertion";
  const auto written = nlohmann::json::parse(CommandLine::content(results / "insertion.json"));
  CHECK(written["rows"].size() == 20);
  // A frame that did not converge is all that may end it with 1.
  CHECK((outcome.exit_code == 0) == (written["summary"]["unconverged_frames"] == 0));
  CHECK(written["summary"]["events"]["puncture"] == 1);
  CHECK(written["summary"]["largest_force"].get<double>() > 0.02);
  CHECK(outcome.out.find("puncture at depth") != std::string::npos);
  for (const char* name : {"insertion.csv", "insertion_mesh.svg", "insertion_force.svg", "insertion_dofs.svg",
                           "insertion_start_stress.svg", "insertion_start_eta.svg", "insertion_depth_stress.svg",
                           "insertion_depth_eta.svg", "insertion_end_stress.svg", "insertion_end_eta.svg",
                           "insertion_0020.vtu", "insertion_needle_0020.vtu", "insertion_needle.pvd"}) {
    CAPTURE(name);
    CHECK(fs::exists(results / name));
  }
  CHECK_FALSE(fs::exists(results / "insertion_surface.pvd"));  // its cells are full
}

TEST_CASE("bad input of a moving scene ends with code 2, one message, and nothing written", "[command-line][needle]") {
  const CommandLine shell;
  shell.write("insertion.toml", insertion);
  for (const std::string set :
       {"needle.radius=0", "needle.radius=-1", "needle.tip=[0.01,0.01,0.01]", "contact.friction=-0.1",
        "dynamics.time_step=0", "dynamics.density=0", "contact.cut_advance=1", "dynamics.duration=1e-3",
        "adapt.steps=2", "support[0].course=[[1,0],[0,0]]", "needle.radius=nan", "stroke[0].speed=0"}) {
    CAPTURE(set);
    const Outcome outcome = shell.run("run insertion.toml --set " + std::string("'") + set + "'");
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.out.empty());
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    CHECK(outcome.err.find(set.substr(0, set.find('='))) != std::string::npos);
    CHECK_FALSE(shell.wrote_results());
  }
}

TEST_CASE("a quick moving run ends after 200 frames and says so", "[command-line]") {
  const CommandLine shell;
  shell.write("swing.toml", swing);
  const Outcome outcome = shell.run(
      "run swing.toml --quick --quiet -o new --set dynamics.duration=10 --set box.cells=[1,1,1] --set "
      "dynamics.estimate_error=true");
  CAPTURE(outcome.err);
  CHECK(outcome.exit_code == 0);
  const auto written = nlohmann::json::parse(CommandLine::content(shell.work() / "new/swing.json"));
  CHECK(written["quick"] == true);
  CHECK(written["rows"].size() == 200);
  CHECK(written["summary"]["notes"].dump().find("after 200 of 1000 frames") != std::string::npos);
}

TEST_CASE("frames that do not converge end with code 1, are kept, and the last line says which", "[command-line]") {
  const CommandLine shell;
  shell.write("swing.toml", swing);
  const Outcome outcome = shell.run(
      "run swing.toml --quiet -o new --set solver.step_method=plain --set solver.iterations=1 --set "
      "solver.relative_residual=1e-12");
  CHECK(outcome.exit_code == 1);
  CHECK(outcome.err.find("failed: unconverged_frames: 8 is not in [0, 0]") != std::string::npos);
  CHECK(outcome.err.find("8 of 8 frames did not converge, the first is frame 1 (t = 0.01): residual") !=
        std::string::npos);
  const auto written = nlohmann::json::parse(CommandLine::content(shell.work() / "new/swing.json"));
  CHECK(written["rows"].size() == 8);
  CHECK(written["rows"][0]["converged"] == false);
  CHECK(written["checks"][0]["ok"] == false);
}

TEST_CASE("a run ends in the same bits for one thread and for two", "[command-line][needle]") {
  const CommandLine line;
  // Large enough for the direct solver to use BLAS on blocks that several threads would share.
  const std::string phantom = "run '" FINEGAUGE_SOURCE_DIR
                              "/reference_data/scenes/phantom.toml' --quick --json --quiet "
                              "--set 'box.cells=[18,8,8]' --set dynamics.duration=0.2 ";
  std::vector<std::string> states;
  for (const char* threads : {"1", "2"}) {
    const Outcome outcome = line.run(phantom + "--threads " + threads + " -o " + threads);
    CAPTURE(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    states.push_back(nlohmann::json::parse(outcome.out).at("summary").at("state_sha256"));
  }
  CHECK(states[0] == states[1]);
}
