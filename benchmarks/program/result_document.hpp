#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace finegauge {

using Json = nlohmann::ordered_json;  ///< keys stay in the order in which they were set

/// What a result was computed from.
struct ResultInputs {
  std::string scene;                ///< path as given; empty where a study brings its own problem
  std::string sha256;               ///< of the scene file; empty without one
  Json overrides = Json::object();  ///< the --set options, key to value
};

/// Where and when it was computed.
struct Environment {
  std::string version, commit, compiler, flags;  ///< of the program, fixed when it was configured
  std::string cpu;                               ///< the processor's own name
  int cores = 0;                                 ///< logical processors of the machine
  int threads = 1;                               ///< that the computation was allowed
  std::string started;                           ///< UTC, ISO 8601
  double seconds = 0.0;                          ///< wall time until the document was finished
};
/// The environment of this process, started now.
Environment describe_environment(int threads);

/// The content of OUT/NAME.json; the schema is called finegauge/1.
struct ResultDocument {
  std::string kind;  ///< the command
  std::string name;
  bool quick = false;
  ResultInputs inputs;
  Environment environment;
  Json rows = Json::array();  ///< objects
  Json summary = Json::object();
  Json checks = Json::array();  ///< made by `check`
};

/// A claim about a number, inclusive of its bounds; a value that is not finite does not hold.
Json check(const std::string& name, double value, double low, double high);
bool all_checks_hold(const Json& checks);

/// The document with every number that is not finite replaced by null and a text KEY_reason beside it (an array's
/// reason stands beside the array). A reason that the producer gave already is kept.
Json to_json(const ResultDocument& document);

/// The rows as comma-separated values with a header: nested objects are flattened with dots, arrays of numbers with
/// their index, other arrays and empty ones are one cell of JSON text; null is an empty cell. Columns in the order of
/// first appearance.
std::string to_csv(const Json& rows);

/// Writes DIRECTORY/NAME.json and DIRECTORY/NAME.csv, each whole or not at all (atomic_file.hpp).
void write_result(const ResultDocument& document, const std::filesystem::path& directory);

/// Largest resident memory of this process so far [MB = 1e6 bytes].
double peak_memory_mb();

}  // namespace finegauge
