#include "benchmarks/program/result_document.hpp"

#include <sys/resource.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "benchmarks/program/atomic_file.hpp"
#include "benchmarks/program/build_info.hpp"

namespace finegauge {
namespace {

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    // "model name" on x86, "Model" on boards where the kernel names no processor.
    if (line.rfind("model name", 0) != 0 && line.rfind("Model", 0) != 0) continue;
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos || colon + 2 > line.size()) continue;
    return line.substr(colon + 2);
  }
  return "unknown";
}

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

std::string why_not_finite(double value) {
  if (std::isnan(value)) return "not a number";
  return value > 0.0 ? "infinite" : "minus infinity";
}

// Replaces what is not finite; returns the reason of the first such number directly in this value or array.
std::string replace_not_finite(Json& value) {
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (std::isfinite(number)) return {};
    value = nullptr;
    return why_not_finite(number);
  }
  std::string reason;
  if (value.is_array()) {
    for (Json& item : value) {
      std::string found = replace_not_finite(item);
      if (reason.empty()) reason = std::move(found);
    }
  } else if (value.is_object()) {
    std::vector<std::pair<std::string, std::string>> reasons;
    for (auto& [key, item] : value.items())
      if (std::string found = replace_not_finite(item); !found.empty()) reasons.emplace_back(key, std::move(found));
    for (auto& [key, text] : reasons)
      if (!value.contains(key + "_reason")) value[key + "_reason"] = text;
  }
  return reason;
}

bool all_numbers(const Json& array) {
  for (const Json& item : array)
    if (!item.is_number() && !item.is_null()) return false;
  return true;
}

using Cells = std::vector<std::pair<std::string, std::string>>;

void flatten(const Json& value, const std::string& key, Cells& cells) {
  const auto below = [&](const std::string& part) { return key.empty() ? part : key + "." + part; };
  if (value.is_object()) {
    for (const auto& [part, item] : value.items()) flatten(item, below(part), cells);
  } else if (value.is_array() && !value.empty() && all_numbers(value)) {
    for (std::size_t i = 0; i < value.size(); ++i) flatten(value[i], below(std::to_string(i)), cells);
  } else if (value.is_string()) {
    cells.emplace_back(key, value.get<std::string>());
  } else {
    cells.emplace_back(key, value.is_null() ? std::string() : value.dump());
  }
}

// RFC 4180, but for line ends, which are those of the system's tools.
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

Environment describe_environment(int threads) {
  Environment environment;
  environment.version = build_info::version;
  environment.commit = build_info::commit;
  environment.compiler = build_info::compiler;
  environment.flags = build_info::flags;
  environment.cpu = processor_name();
  environment.cores = static_cast<int>(std::thread::hardware_concurrency());
  environment.threads = threads;
  environment.started = utc_now();
  return environment;
}

Json check(const std::string& name, double value, double low, double high) {
  // Written so that a value that is not a number fails.
  const bool ok = value >= low && value <= high && std::isfinite(value);
  return {{"name", name}, {"value", value}, {"low", low}, {"high", high}, {"ok", ok}};
}

bool all_checks_hold(const Json& checks) {
  for (const Json& item : checks)
    if (!item.at("ok").get<bool>()) return false;
  return true;
}

Json to_json(const ResultDocument& document) {
  const Environment& e = document.environment;
  Json json;
  json["schema"] = "finegauge/1";
  json["kind"] = document.kind;
  json["name"] = document.name;
  json["quick"] = document.quick;
  json["inputs"] = {
      {"scene", document.inputs.scene}, {"sha256", document.inputs.sha256}, {"overrides", document.inputs.overrides}};
  json["environment"] = {{"version", e.version}, {"commit", e.commit},   {"compiler", e.compiler},
                         {"flags", e.flags},     {"cpu", e.cpu},         {"cores", e.cores},
                         {"threads", e.threads}, {"started", e.started}, {"seconds", e.seconds}};
  json["rows"] = document.rows;
  json["summary"] = document.summary;
  json["checks"] = document.checks;
  replace_not_finite(json);
  return json;
}

std::string to_csv(const Json& rows) {
  std::vector<Cells> table;
  std::vector<std::string> columns;
  std::unordered_map<std::string, std::size_t> column_of;
  for (Json row : rows) {
    replace_not_finite(row);
    Cells& cells = table.emplace_back();
    flatten(row, "", cells);
    for (const auto& [key, text] : cells)
      if (column_of.emplace(key, columns.size()).second) columns.push_back(key);
  }
  std::string text;
  const auto write_line = [&](const std::vector<std::string>& line) {
    for (std::size_t i = 0; i < line.size(); ++i) text += (i ? "," : "") + csv_cell(line[i]);
    text += '\n';
  };
  write_line(columns);
  for (const Cells& cells : table) {
    std::vector<std::string> line(columns.size());
    for (const auto& [key, cell] : cells) line[column_of.at(key)] = cell;
    write_line(line);
  }
  return text;
}

void write_result(const ResultDocument& document, const std::filesystem::path& directory) {
  // Names and messages may quote a user's file; bytes that are no UTF-8 must not cost the result.
  const std::string text = to_json(document).dump(2, ' ', false, Json::error_handler_t::replace);
  write_file_atomically(directory / (document.name + ".csv"), to_csv(document.rows));
  write_file_atomically(directory / (document.name + ".json"), text + "\n");
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024.0 / 1e6;
}

}  // namespace finegauge
