#include "benchmarks/program/result_document.hpp"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "benchmarks/program/atomic_file.hpp"
#include "verification/support/catch.hpp"

using namespace finegauge;
namespace fs = std::filesystem;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// A directory of this test alone, removed at its end.
struct TemporaryDirectory {
  fs::path path = fs::temp_directory_path() / ("finegauge_result_test_" + std::to_string(::getpid()));
  TemporaryDirectory() { fs::remove_all(path); }
  ~TemporaryDirectory() { fs::remove_all(path); }
};

std::string content(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("a result document has the schema's keys in their order", "[result]") {
  ResultDocument document;
  document.kind = "run", document.name = "block", document.environment = describe_environment(1);
  const Json json = to_json(document);
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  CHECK(keys == std::vector<std::string>{"schema", "kind", "name", "quick", "inputs", "environment", "rows", "summary",
                                         "checks"});
  CHECK(json["schema"] == "finegauge/1");
  for (const char* key : {"version", "commit", "compiler", "flags", "cpu", "started"}) {
    CAPTURE(key);
    CHECK_FALSE(json["environment"][key].get<std::string>().empty());
  }
  CHECK(json["environment"]["cores"].get<int>() >= 1);
}

TEST_CASE("numbers that are not finite become null with a reason, at every depth", "[result]") {
  ResultDocument document;
  document.rows.push_back(
      {{"eta", not_a_number}, {"force", {1.0, -infinity}}, {"inner", {{"rate", infinity}}}, {"fine", 2.5}});
  document.summary = {{"slope", not_a_number}, {"slope_reason", "one mesh only"}};
  const Json json = to_json(document);
  const Json& row = json["rows"][0];
  CHECK(row["eta"].is_null());
  CHECK(row["eta_reason"] == "not a number");
  CHECK(row["force"][0] == 1.0);
  CHECK(row["force"][1].is_null());
  CHECK(row["force_reason"] == "minus infinity");
  CHECK(row["inner"]["rate_reason"] == "infinite");
  CHECK(row["fine"] == 2.5);
  CHECK_FALSE(row.contains("fine_reason"));
  CHECK(json["summary"]["slope_reason"] == "one mesh only");
  CHECK(json.dump().find("nan") == std::string::npos);
}

TEST_CASE("a check holds on its bounds and fails beyond them and on what is no number", "[result]") {
  CHECK(check("a", 1.0, 1.0, 2.0)["ok"] == true);
  CHECK(check("a", 2.0, 1.0, 2.0)["ok"] == true);
  CHECK(check("a", std::nextafter(2.0, 3.0), 1.0, 2.0)["ok"] == false);
  CHECK(check("a", std::nextafter(1.0, 0.0), 1.0, 2.0)["ok"] == false);
  CHECK(check("a", not_a_number, 1.0, 2.0)["ok"] == false);
  CHECK(all_checks_hold(Json::array({check("a", 1.0, 0.0, 2.0)})));
  CHECK_FALSE(all_checks_hold(Json::array({check("a", 1.0, 0.0, 2.0), check("b", 3.0, 0.0, 2.0)})));
}

TEST_CASE("the table of rows flattens, quotes and keeps a column for every key", "[result]") {
  Json rows = Json::array();
  rows.push_back({{"scheme", "a,\"b\""}, {"times", {{"solve_ms", 0.1}}}, {"point", {1, 2.5}}});
  rows.push_back({{"scheme", "c"}, {"extra", nullptr}, {"events", Json::array({{{"kind", "cut"}}})}});
  CHECK(to_csv(rows) ==
        "scheme,times.solve_ms,point.0,point.1,extra,events\n"
        "\"a,\"\"b\"\"\",0.1,1,2.5,,\n"
        "c,,,,,\"[{\"\"kind\"\":\"\"cut\"\"}]\"\n");
}

TEST_CASE("files of a result are readable again and leave nothing else behind", "[result]") {
  const TemporaryDirectory directory;
  ResultDocument document;
  document.kind = "run", document.name = "block";
  document.rows.push_back({{"third", 1.0 / 3.0}});
  write_result(document, directory.path / "deeper");
  const Json read = Json::parse(content(directory.path / "deeper" / "block.json"));
  CHECK(read["rows"][0]["third"].get<double>() == 1.0 / 3.0);
  int files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(directory.path / "deeper")) ++files;
  CHECK(files == 2);
}

TEST_CASE("a file that cannot be written whole leaves the old one as it was", "[result]") {
  const TemporaryDirectory directory;
  const fs::path file = directory.path / "result.json";
  write_file_atomically(file, "old");
  // A directory in the temporary file's place makes the write fail, even for a superuser.
  fs::create_directories(temporary_beside(file));
  CHECK_THROWS_AS(write_file_atomically(file, "new"), std::runtime_error);
  CHECK(content(file) == "old");
}

TEST_CASE("an empty list is a cell of its own, so that columns do not depend on what happened", "[result]") {
  CHECK(to_csv(Json::array({{{"events", Json::array()}, {"x", 1}}})) == "events,x\n[],1\n");
}
