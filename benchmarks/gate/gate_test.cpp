#include "benchmarks/gate/gate.hpp"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "benchmarks/gate/budget.hpp"
#include "benchmarks/gate/child_process.hpp"
#include "benchmarks/gate/result_path.hpp"
#include "core/scene/scene_error.hpp"
#include "verification/support/catch.hpp"

namespace fs = std::filesystem;
using namespace finegauge;

namespace {

/// The program beside this test, or the one that the environment names.
fs::path program() {
  if (const char* given = std::getenv("FINEGAUGE_PROGRAM")) return given;
  return fs::read_symlink("/proc/self/exe").parent_path() / "finegauge";
}

std::string content(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A body of some cells that falls and swings for eight frames; coarse, so that it takes a few milliseconds.
std::string swing(const std::string& cells) {
  return R"(name = "swing"
[box]
size = [2, 1, 1]
cells = )" +
         cells + R"(
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
)";
}

/// A folder with a scene, a budgets file and what the gate made of them.
class GateFolder {
 public:
  GateFolder() { write("swing.toml", swing("[4, 2, 2]")); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path() / name) << text; }
  void write_script(const std::string& name, const std::string& body) const {
    fs::create_directories((path() / name).parent_path());
    write(name, "#!/bin/sh\n" + body);
    fs::permissions(path() / name, fs::perms::owner_all);
  }
  const fs::path& path() const { return temporary_.path(); }

  /// `finegauge gate budgets.toml ARGUMENTS` here; `before` are assignments of the environment.
  int gate(const std::string& budgets, const std::string& arguments = "", const std::string& before = "") {
    write("budgets.toml", budgets);
    const std::string command = "cd '" + path().string() + "' && " + before + " '" + program().string() +
                                "' gate budgets.toml --quiet -o out " + arguments;
    const ProcessEnd end = run_process({"sh", "-c", command}, path() / "told", path() / "complaint", 300.0);
    told = content(path() / "told");
    complaint = content(path() / "complaint");
    result = Json::parse(content(path() / "out" / "gate.json"), nullptr, false);
    return end.exit_code;
  }
  const Json& check(const std::string& name) const {
    for (const Json& one : result.at("checks"))
      if (one.at("name") == name) return one;
    FAIL("no check " << name);
    return result;
  }

  std::string told, complaint;
  Json result;

 private:
  TemporaryFolder temporary_;
};

std::string budget(const std::string& name, const std::string& rest) {
  return "[[budget]]\nname = \"" + name + "\"\nreason = \"of the test\"\n" + rest + "\n";
}
const std::string of_swing = "run = \"run swing.toml\"\n";

}  // namespace

TEST_CASE("a path finds the one number that it names, or says what is missing", "[gate]") {
  const Json document = Json::parse(R"({"summary": {"a": {"b": 2.5}, "n": null, "n_reason": "not asked", "ok": true},
      "rows": [{"claim": "x.y", "mesh": 1, "value": 1}, {"claim": "x.y", "mesh": 2, "value": 2},
               {"claim": "z", "value": 3}], "text": "t"})");
  const auto value = [&](const char* path) { return find_number(document, path).value.value_or(-1.0); };
  CHECK(value("summary.a.b") == 2.5);
  CHECK(value("summary.ok") == 1.0);
  CHECK(value("rows[0].value") == 1.0);
  CHECK(value("rows[-1].value") == 3.0);
  CHECK(value("rows[claim=z].value") == 3.0);
  CHECK(value("rows[claim=x.y,mesh=2].value") == 2.0);
  const std::array<std::array<const char*, 2>, 9> missing = {{{"summary.c", "has no c of summary.c"},
                                                              {"summary.n", "n is null: not asked"},
                                                              {"text", "is no number"},
                                                              {"summary.a", "is no number"},
                                                              {"rows[3].value", "rows has 3 entries"},
                                                              {"rows[-4].value", "rows has 3 entries"},
                                                              {"rows[claim=w].value", "no entry of rows"},
                                                              {"rows[claim=x.y].value", "2 entries of rows"},
                                                              {"summary[0].a", "is no list"}}};
  for (const auto& [path, why] : missing) {
    CAPTURE(path);
    const FoundNumber found = find_number(document, path);
    CHECK_FALSE(found.value);
    CHECK_THAT(found.why, ContainsSubstring(why));
  }
  for (const char* path : {"", ".", "a.", "a..b", "[0]", "a[", "a[]", "a[0", "a[x]", "a[0]b", "a[=1]", "a[b=]", "a]"})
    CHECK_FALSE(parse_result_path(path));
}

TEST_CASE("a mistake in a budgets file is told with its line and field", "[gate][input]") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "budgets.toml";
  const std::string good =
      budget("a", "kind = \"accuracy\"\nrun = \"run x.toml\"\nvalue = \"summary.x\"\nlow = 1\nhigh = 2");
  const auto message = [&](const std::string& text) -> std::string {
    std::ofstream(file) << text;
    try {
      (void)read_budgets(file);
    } catch (const SceneError& error) {
      return error.what();
    }
    return "read";
  };
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return message(text);
  };
  REQUIRE(message(good) == "read");
  const std::string in_file = file.string();
  CHECK(with("low = 1", "lower = 1").find(in_file + ":7: budget[0].lower: unknown key") == 0);
  CHECK(with("low = 1", "percentile = 1").find(in_file + ":7: budget[0].percentile: unknown key") == 0);
  CHECK_THAT(with("low = 1", "high_ms = 1"), ContainsSubstring("a stored time is no bound"));
  CHECK_THAT(with("low = 1\n", ""), ContainsSubstring(":1: budget[0].low: found nothing"));
  CHECK(with("high = 2", "high = 0.5").find(in_file + ":8: budget[0].high: found 0.5, allowed at least low") == 0);
  CHECK_THAT(with("low = 1", "low = nan"), ContainsSubstring(":7: budget[0].low: found nan, allowed a number"));
  CHECK_THAT(with("low = 1", "low = \"1\""), ContainsSubstring("found \"1\", allowed a number"));
  CHECK_THAT(with("accuracy", "speed"), ContainsSubstring(":4: budget[0].kind: found \"speed\""));
  CHECK_THAT(with("run x.toml", "rm x.toml"), ContainsSubstring(":5: budget[0].run: found"));
  CHECK_THAT(with("run x.toml", "run x.toml --out y"), ContainsSubstring("without --out"));
  CHECK_THAT(with("run x.toml", "run 'x.toml"), ContainsSubstring("budget[0].run: found"));
  CHECK_THAT(with("run x.toml", "gate budgets.toml"), ContainsSubstring("budget[0].run: found"));
  CHECK_THAT(with("of the test", ""), ContainsSubstring("budget[0].reason"));
  CHECK_THAT(with("\"a\"", "\"a b\""), ContainsSubstring(":2: budget[0].name: found \"a b\""));
  CHECK_THAT(with("low = 1", "low = 1\noptional = \"base\""), ContainsSubstring("only where a base is compared"));
  CHECK_THAT(message(good + good), ContainsSubstring(":10: budget[1].name: found \"a\", allowed a name that no other"));
  CHECK_THAT(message("x = 1\n" + good), ContainsSubstring(":1: x: unknown key"));
  CHECK_THAT(message("# nothing\n"), ContainsSubstring("found nothing, required: [[budget]]"));
  CHECK_THAT(message("budget = 1\n"), ContainsSubstring(":1: budget: found 1"));
  CHECK_THAT(message(good + "low = 3\n"), ContainsSubstring(":9: not TOML"));
  // A number of milliseconds, or what follows from one, cannot be bounded by any kind.
  for (const char* path : {"summary.frame_ms.p99", "rows[0].total_ms", "summary.frames_per_second",
                           "summary.missed_frames", "environment.seconds"}) {
    CAPTURE(path);
    CHECK_THAT(with("summary.x", path), ContainsSubstring(":6: budget[0].value: found"));
    CHECK_THAT(with("summary.x", path), ContainsSubstring("no time and no rate"));
  }
  const std::string time = "kind = \"time\"\nrun = \"run x.toml\"\npercentile = 99\n";
  CHECK_THAT(message(budget("t", time)), ContainsSubstring("budget[0].against: found nothing"));
  CHECK_THAT(message(budget("t", time + "against = \"20 ms\"")), ContainsSubstring("allowed \"base\" or"));
  CHECK_THAT(message(budget("t", time + "against = \"base\"\nhigh = 20")), ContainsSubstring("calibration\" only"));
  CHECK_THAT(message(budget("t", time + "against = \"base\"\nslower = 0.01")), ContainsSubstring("found 0.01"));
  CHECK_THAT(message(budget("t", time + "against = \"calibration\"\nhigh = 2")), ContainsSubstring("budget[0].low"));
  CHECK(message(budget("t", time + "against = \"base\"\noptional = [\"base\"]")) == "read");
  CHECK_THAT(message(budget("c", "kind = \"counter\"\nrun = \"run x.toml\"\nvalue = \"summary.n\"\nequals = 1.5")),
             ContainsSubstring("allowed a whole number"));
}

TEST_CASE("budgets that hold and that do not are told, and a command they share runs once", "[gate][command-line]") {
  GateFolder folder;
  const std::string holds =
      budget("dofs", of_swing + "kind = \"counter\"\nvalue = \"summary.dofs.max\"\nequals = 135") +
      budget("frames", of_swing + "kind = \"accuracy\"\nvalue = \"summary.frames\"\nlow = 7.5\nhigh = 8.5");
  REQUIRE(folder.gate(holds) == 0);
  CHECK(folder.check("dofs").at("judged") == "exact");
  CHECK(folder.check("dofs").at("value") == 135.0);
  CHECK(folder.check("frames").at("judged") == "band");
  CHECK(folder.result.at("summary").at("jobs").size() == 1);
  CHECK(folder.result.at("summary").at("held") == 2);
  CHECK_THAT(folder.told, ContainsSubstring("2 of 2 budgets hold, 0 fail, 0 skipped"));
  CHECK(content(folder.path() / "out" / "gate.csv").find("name,value,low,high,ok,judged") == 0);

  CHECK(folder.gate(holds +
                    budget("worse", of_swing + "kind = \"counter\"\nvalue = \"rows[-1].dofs\"\nequals = 134")) == 1);
  CHECK_FALSE(folder.check("worse").at("ok").get<bool>());
  CHECK(folder.check("dofs").at("ok").get<bool>());
  CHECK_THAT(folder.complaint, ContainsSubstring("failed: worse: 135 is not in [134, 134]"));
  // Those that are not asked for do not count.
  CHECK(folder.gate(content(folder.path() / "budgets.toml"), "--only frames") == 0);
  CHECK(folder.result.at("rows").size() == 1);
  CHECK(folder.gate(holds, "--only nonsense") == 2);
  CHECK(folder.gate(holds, "--base nonsense") == 2);
  CHECK(folder.gate("[[budget]]\nname = 1\n") == 2);
}

TEST_CASE("a budget that compared nothing fails", "[gate][command-line]") {
  GateFolder folder;
  const std::string number = "kind = \"accuracy\"\nlow = -1e9\nhigh = 1e9\n";
  const std::string time = "kind = \"time\"\npercentile = 50\n";
  const std::string budgets = budget("no_key", of_swing + number + "value = \"summary.nonsense\"") +
                              budget("null", of_swing + number + "value = \"rows[0].force\"") +
                              budget("no_run", "run = \"run none.toml\"\n" + number + "value = \"summary.frames\"") +
                              budget("no_frames", "run = \"verify use-errors\"\n" + time +
                                                      "against = \"calibration\"\nlow = 1e-9\nhigh = 1e9") +
                              budget("no_base", of_swing + time + "against = \"base\"") +
                              budget("skipped", of_swing + time + "against = \"base\"\noptional = \"base\"");
  REQUIRE(folder.gate(budgets) == 1);
  for (const char* name : {"no_key", "null", "no_run", "no_frames", "no_base"}) {
    CAPTURE(name);
    CHECK_FALSE(folder.check(name).at("ok").get<bool>());
    CHECK(folder.check(name).at("value").is_null());
    CHECK_FALSE(folder.check(name).at("why").get<std::string>().empty());
  }
  CHECK_THAT(folder.check("null").at("why").get<std::string>(), ContainsSubstring("null: the scene has no needle"));
  CHECK_THAT(folder.check("no_run").at("why").get<std::string>(), ContainsSubstring("exit code 2: none.toml"));
  CHECK_THAT(folder.check("no_frames").at("why").get<std::string>(), ContainsSubstring("no number processor_ms"));
  CHECK(folder.check("skipped").at("judged") == "skipped");
  CHECK_THAT(folder.told, ContainsSubstring("0 of 6 budgets hold, 5 fail, 1 skipped"));
  // All skipped is nothing compared too.
  CHECK(folder.gate(budgets, "--only skipped") == 1);
  CHECK_FALSE(folder.check("budgets_compared").at("ok").get<bool>());
}

TEST_CASE("frame times are judged against a base of the same run and against the kernel", "[gate][command-line]") {
  GateFolder folder;
  const std::string budgets =
      budget("base", of_swing + "kind = \"time\"\npercentile = 50\nagainst = \"base\"\nslower = 1.0") +
      budget("kernel",
             of_swing + "kind = \"time\"\npercentile = 50\nagainst = \"calibration\"\nlow = 1e-3\nhigh = 1e3");
  // A base with a third of the cells: a frame takes less than half of the head's.
  folder.write_script("faster", "exec '" + program().string() + "' \"$@\" --set box.cells=[2,1,1]\n");
  REQUIRE(folder.gate(budgets, "--base faster --seed 3") == 1);
  CHECK(folder.check("base").at("judged") == "interleaved A/B");
  CHECK(folder.check("base").at("value").get<double>() > 2.0);
  CHECK_THAT(folder.check("base").at("why").get<std::string>(), ContainsSubstring("slower than the base"));
  CHECK(folder.check("kernel").at("ok").get<bool>());
  CHECK(folder.check("kernel").at("judged") == "calibrated");
  CHECK(folder.result.at("rows")[0].at("blocks") >= 12);
  CHECK(folder.result.at("summary").at("seed") == 3);
  CHECK(folder.result.at("summary").at("jobs").size() == 1);

  folder.write_script("broken", "echo no such thing >&2; exit 3\n");
  REQUIRE(folder.gate(budgets, "--base broken") == 1);
  CHECK_THAT(folder.check("base").at("why").get<std::string>(),
             ContainsSubstring("the base: exit code 3: no such thing"));
  CHECK(folder.check("kernel").at("ok").get<bool>());
}

TEST_CASE("instructions are compared where valgrind can count them, else told as missing", "[gate][command-line]") {
  GateFolder folder;
  folder.write("finer.toml", swing("[5, 2, 2]"));
  const std::string counted = "kind = \"instructions\"\nrun = \"run finer.toml\"\nover = \"run swing.toml\"\n";
  const std::string budgets = budget("more", counted + "low = 1.02\nhigh = 1.04");
  // Stands in for callgrind: a million and a half for the finer scene, less for the other.
  folder.write_script("bin/valgrind", R"(
[ "$1" = --version ] && exit 0
share=1
for word; do case $word in
  --log-file=*) log=${word#--log-file=} ;;
  --toggle-collect=frame*int*) share=0 ;;
  finer.toml) count=1545000 finer=1 ;;
esac; done
while [ "${1#--}" != "$1" ]; do shift; done
"$@" || exit
[ $share = 1 ] || count=$((200000 + 50000 * ${finer:-0}))
echo "==1== Collected : ${count:-1500000}" > "$log"
)");
  const std::string with = "PATH=\"$PWD/bin:$PATH\"";
  CHECK(folder.gate(budgets, "", with) == 0);
  CHECK(folder.check("more").at("value").get<double>() == Approx(1.03));
  CHECK(folder.gate(budget("more", counted + "low = 0.99\nhigh = 1.01"), "", with) == 1);
  // A function's own: a change that the rest of the process would hide.
  const std::string within = counted + "within = \"frame(int)\"\n";
  CHECK(folder.gate(
            budget("whole", counted + "low = 1.02\nhigh = 1.04") + budget("frames", within + "low = 1.24\nhigh = 1.26"),
            "", with) == 0);
  CHECK(folder.check("frames").at("value").get<double>() == Approx(1.25));
  CHECK(folder.result.at("rows")[1].at("within") == "frame(int)");

  const std::string without = "PATH=/nonexistent";
  CHECK(folder.gate(budgets, "", without) == 1);
  CHECK_THAT(folder.check("more").at("why").get<std::string>(), ContainsSubstring("valgrind is not installed"));
  CHECK(folder.gate(budget("more", counted + "low = 1.02\nhigh = 1.04\noptional = \"valgrind\"") +
                        budget("dofs", of_swing + "kind = \"counter\"\nvalue = \"summary.dofs.max\"\nequals = 135"),
                    "", without) == 0);
  CHECK(folder.check("more").at("judged") == "skipped");
  folder.write_script("bin/valgrind", R"(
[ "$1" = --version ] && exit 0
for word; do case $word in --log-file=*) log=${word#--log-file=} ;; esac; done
echo 'vex amd64->IR: unhandled instruction bytes: 0x62' > "$log"; exit 132
)");
  CHECK(folder.gate(budgets, "", with) == 1);
  CHECK_THAT(folder.check("more").at("why").get<std::string>(), ContainsSubstring("FINEGAUGE_NATIVE=OFF"));
}

TEST_CASE("counts of the L-shape's matrix are those of its mesh", "[gate]") {
  const Json counters = exact_counters();
  // 17 x 17 x 9 nodes less the 8 x 8 x 9 of the quadrant; a node couples with its neighbours in the cells around it.
  CHECK(counters.at("uniform").at("dofs") == 3 * (17 * 17 * 9 - 8 * 8 * 9));
  CHECK(counters.at("uniform").at("hanging_nodes") == 0);
  CHECK(counters.at("uniform").at("entries_of_T") == 17 * 17 * 9 - 8 * 8 * 9);
  const Json& adaptive = counters.at("adaptive");
  CHECK(adaptive.at("hanging_nodes") > 0);
  // Each hanging node of halved cells has two to four masters at least, and each other node itself.
  const int nodes = adaptive.at("dofs").get<int>() / 3, hanging = adaptive.at("hanging_nodes").get<int>();
  CHECK(adaptive.at("entries_of_T").get<int>() >= nodes + 2 * hanging);
  CHECK(adaptive.at("factor_nonzeros").get<double>() > adaptive.at("dofs").get<double>());
}
