#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "benchmarks/program/command.hpp"
#include "benchmarks/report/frame_series.hpp"
#include "benchmarks/report/html.hpp"
#include "benchmarks/report/page.hpp"
#include "benchmarks/report/section.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/occurrences.hpp"

using namespace finegauge;
namespace fs = std::filesystem;

namespace {

/// A directory of this test, removed at its end.
class Folder {
 public:
  Folder() { fs::create_directories(root_); }
  ~Folder() { fs::remove_all(root_); }
  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name, std::ios::binary) << text;
    return root_ / name;
  }
  const fs::path& root() const { return root_; }

 private:
  fs::path root_ = fs::temp_directory_path() / ("finegauge_report_" + std::to_string(::getpid()));
};

Json document(const std::string& kind, const std::string& name) {
  return {{"schema", "finegauge/1"},
          {"kind", kind},
          {"name", name},
          {"quick", false},
          {"inputs", {{"scene", "s.toml"}, {"sha256", ""}, {"overrides", Json::object()}}},
          {"environment", {{"version", "1"}, {"started", "2026-01-01T00:00:00Z"}, {"seconds", 1.0}}},
          {"rows", Json::array()},
          {"summary", Json::object()},
          {"checks", Json::array()}};
}

/// A moving scene of many frames, with one extreme that a picture must not lose.
Json run_document(int frames) {
  Json run = document("run", "made");
  for (int i = 0; i < frames; ++i)
    run["rows"].push_back({{"frame", i + 1},
                           {"time", 1e-3 * i},
                           {"tip_displacement", 1e-6 * i},
                           {"force", i == frames / 3 ? 77.0 : 1.0 + (i % 7)},
                           {"dofs", 750 + i % 3},
                           {"eta", 0.1 + 1e-6 * i},
                           {"tolerance_ratio", nullptr},
                           {"frame_ms", 2.0 + 0.01 * (i % 50)},
                           {"events", Json::array()}});
  run["summary"] = {{"frames", frames}, {"deadline_ms", 2.4}, {"frame_ms", {{"p50", 2.2}, {"p99", 2.5}}}};
  run["checks"].push_back({{"name", "bad <b>check</b>"}, {"value", 3.0}, {"low", 0.0}, {"high", 1.0}, {"ok", false}});
  return run;
}

std::string refusal(const std::vector<fs::path>& paths) {
  try {
    (void)read_report_documents(paths);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

std::string page_of(const std::vector<fs::path>& paths) { return report_page(read_report_documents(paths)); }

const fs::path invented = fs::path(FINEGAUGE_SOURCE_DIR) / "benchmarks/report/invented";

}  // namespace

TEST_CASE("text of a result cannot become markup", "[report]") {
  CHECK(html_escaped("<script>&\"'") == "&lt;script&gt;&amp;&quot;&#39;");
  CHECK(html_escaped("μ €") == "μ €");
  CHECK(html_escaped(std::string("a\0b", 3)) ==
        "a\xEF\xBF\xBD"
        "b");
  // Not UTF-8: a lone continuation, an overlong solidus, half a surrogate pair, and an end that is cut off.
  for (const std::string bytes : {"\x80", "\xC0\xAF", "\xED\xA0\x80", "\xE2\x82"})
    CHECK(html_escaped(bytes).find_first_not_of("\xEF\xBF\xBD") == std::string::npos);
}

TEST_CASE("numbers have the digits that a reader can use", "[report]") {
  CHECK(number_text(0.104397) == "0.104");
  CHECK(number_text(42482.9998) == "42,483");
  CHECK(number_text(-2.5e-9) == "−2.5×10⁻⁹");
  CHECK(number_text(1e-12) == "10⁻¹²");
  CHECK(number_text(999999.6) == "1,000,000");
  CHECK(number_text(std::nan("")) == "–");
  CHECK(number_text(0.95, 4) == "0.9500");
  CHECK(bound_text(0.95) == "0.95");
  CHECK(bound_text(100.0) == "100");
  CHECK(count_text(1234567) == "1,234,567");
}

TEST_CASE("what is no result document is refused with its file and place", "[report]") {
  const Folder folder;
  const std::string good = document("run", "a").dump();
  const fs::path broken = folder.write("x/broken.json", good.substr(0, 30) + "\n\n" + "!!" + good.substr(30));
  CHECK_THAT(refusal({broken}), ContainsSubstring("broken.json") && ContainsSubstring("line 3, column 1"));
  CHECK_THAT(refusal({folder.write("x/cut.json", good.substr(0, good.size() / 2))}),
             ContainsSubstring("found its end"));
  Json other = document("run", "a");
  other["schema"] = "other/2";
  CHECK_THAT(refusal({folder.write("x/foreign.json", other.dump())}),
             ContainsSubstring("schema: found \"other/2\", allowed \"finegauge/1\""));
  CHECK_THAT(refusal({folder.write("x/list.json", "[1]")}), ContainsSubstring("found [1]"));
  Json unjudged = document("run", "a");
  unjudged["checks"] = {{{"name", "n"}, {"value", 1}, {"low", 0}, {"high", 2}, {"ok", 1}}};
  CHECK_THAT(refusal({folder.write("x/unjudged.json", unjudged.dump())}),
             ContainsSubstring("checks[0].ok: found 1, allowed true or false"));
  Json rows = document("run", "a");
  rows["rows"] = {1, 2};
  CHECK_THAT(refusal({folder.write("x/rows.json", rows.dump())}), ContainsSubstring("rows[0]: found 1"));
  CHECK_THAT(refusal({folder.root() / "none"}), ContainsSubstring("no such file"));
  fs::create_directories(folder.root() / "empty");
  CHECK_THAT(refusal({folder.root() / "empty"}), ContainsSubstring("no .json file"));
  CHECK(refusal({folder.write("y/good.json", good)}).empty());
}

TEST_CASE("a directory stands for its documents or for those of its directories, each once", "[report]") {
  const Folder folder;
  folder.write("all/b/b.json", document("run", "b").dump());
  folder.write("all/a/a.json", document("atlas", "a").dump());
  folder.write("all/a/trace.json", R"({"traceEvents": []})");  // of `profile`: no document, and no error
  const auto documents = read_report_documents({folder.root() / "all", folder.root() / "all/b/b.json"});
  REQUIRE(documents.size() == 2);
  CHECK(documents[0].name == "b");  // run before atlas, whatever the names of the folders
  CHECK(documents[1].name == "a");
}

TEST_CASE("the page is the same for the same results in any order", "[report]") {
  const Folder folder;
  const fs::path run = folder.write("run/made.json", run_document(300).dump());
  const std::string page = page_of({invented, run});
  CHECK(page == page_of({run, invented}));
  CHECK(page == page_of({invented / "trade.json", invented / "gate_3.json", run, invented}));
}

TEST_CASE("every kind of document has its section, and what fails is said first", "[report]") {
  const Folder folder;
  const std::string page = page_of({invented, folder.write("run/made.json", run_document(300).dump())});
  for (const char* section : {"summary", "scenes", "trade", "audit", "profile", "budgets", "environments"}) {
    CAPTURE(section);
    CHECK(page.find(std::string("<section id=\"") + section + "\">") != std::string::npos);
  }
  CHECK(page.find("<section id=\"atlas\">") == std::string::npos);
  CHECK_THAT(page, ContainsSubstring("so the page has nothing of them: reproduce, verify, atlas."));
  // One of the run's and the breach of the third gate: before anything else, with links.
  const std::size_t verdict = page.find("✗ 2 of 15 checks fail");
  REQUIRE(verdict != std::string::npos);
  CHECK(verdict < page.find("<section id=\"scenes\">"));
  CHECK(page.find("bad &lt;b&gt;check") < page.find("</div>", page.find("</table>", verdict)));
  CHECK(page.find("<b>check</b>") == std::string::npos);
  // Three runs of the gate: every budget of the last has its history.
  CHECK(occurrences(page, "class=\"spark\"") == 4);
}

TEST_CASE("all anchors are there, once", "[report]") {
  const Folder folder;
  folder.write("r/made.json", run_document(40).dump());
  folder.write("r/b.json", run_document(40).dump());  // of one name: told apart
  const std::string page = page_of({invented, folder.root() / "r"});
  std::set<std::string> ids;
  for (std::size_t at = page.find(" id=\""); at != std::string::npos; at = page.find(" id=\"", at + 1))
    CHECK(ids.insert(page.substr(at + 5, page.find('"', at + 5) - at - 5)).second);
  int links = 0;
  for (std::size_t at = page.find("href=\"#"); at != std::string::npos; at = page.find("href=\"#", at + 1), ++links)
    CHECK(ids.contains(page.substr(at + 7, page.find('"', at + 7) - at - 7)));
  CHECK(links > 20);
}

TEST_CASE("a run of many frames makes a small page that keeps its largest force", "[report]") {
  const Folder folder;
  const int frames = 20000;
  const std::string page = page_of({folder.write("run/made.json", run_document(frames).dump())});
  CHECK(page.size() < 300000);
  CHECK(page.size() > 30000);
  // Of 77 N at a third of the way, in 5 % of room at both ends of 480 px: the only point above all others.
  const std::size_t curve = page.find("<polyline", page.find("force over travel"));
  REQUIRE(curve != std::string::npos);
  const std::string points =
      page.substr(page.find("points=\"", curve) + 8,
                  page.find('"', page.find("points=\"", curve) + 8) - page.find("points=\"", curve) - 8);
  std::vector<double> heights;
  for (std::size_t at = points.find(','); at != std::string::npos; at = points.find(',', at + 1))
    heights.push_back(std::stod(points.substr(at + 1)));
  REQUIRE(heights.size() > 100);
  std::ranges::sort(heights);
  CHECK(heights[0] < 60.0);
  CHECK(heights[1] > 200.0);
}

TEST_CASE("missing keys leave parts out and break nothing", "[report]") {
  const Folder folder;
  for (const char* kind : {"run", "reproduce", "verify", "trade", "audit", "profile", "atlas", "gate", "unheard_of"}) {
    CAPTURE(kind);
    Json bare = document(kind, kind);
    const fs::path file = folder.write(std::string(kind) + "/" + kind + ".json", bare.dump());
    CHECK_THAT(page_of({file}), ContainsSubstring("There are no checks"));
    bare["rows"] = {{{"time", nullptr}},
                    {{"stage", 3}, {"error", "x"}, {"qoi_change", {{"a", nullptr}}}, {"curve", "none.csv"}}};
    bare["summary"] = {
        {"answers", 3}, {"tjunctions", "x"}, {"studies", {{"s", 1}}}, {"axes", {{"a", 2}}}, {"comparison", {1}}};
    folder.write(std::string(kind) + "/" + kind + ".json", bare.dump());
    CHECK(page_of({file}).ends_with("</html>\n"));
  }
}

TEST_CASE("frames are read from a study's table as from a run's rows", "[report]") {
  const Folder folder;
  const auto series = read_frame_series(
      folder.write("c.csv",
                   "frame,time,tip_displacement,force,eta,note,events\n1,0.1,0,1.5,,\"a, \"\"b\"\"\",[]\n"
                   "2,0.2,0.001,2.5,,,\"[{\"\"kind\"\":\"\"cut\"\",\"\"force\"\":2.5}]\"\n"));
  REQUIRE(series);
  CHECK(series->column("force") == std::vector<double>{1.5, 2.5});
  CHECK(series->column("eta").empty());  // no number in it
  REQUIRE(series->events.size() == 1);
  CHECK(series->events[0].kind == "cut");
  CHECK(series->events[0].tip == 0.001);
  CHECK_FALSE(read_frame_series(folder.write("d.csv", "a,b\n1,2\n")));
}
