#include "benchmarks/report/report_input.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <tuple>

#include "benchmarks/program/command.hpp"

namespace fs = std::filesystem;

namespace finegauge {
namespace {

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw UsageError("report: " + file.string() + ": " + what);
}

/// "line 3, column 7" of a byte, both from 1.
std::string place(const std::string& text, std::size_t byte) {
  const std::size_t end = std::min(byte > 0 ? byte - 1 : 0, text.size());
  const auto lines = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
  const std::size_t line_start = text.rfind('\n', end > 0 ? end - 1 : 0);
  const std::size_t column = lines == 0 ? end + 1 : end - line_start;
  return "line " + std::to_string(lines + 1) + ", column " + std::to_string(column);
}

/// A value cut short enough for a message.
std::string shown(const Json& value) {
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

void require(const fs::path& file, const Json& object, const std::string& where, const std::string& key,
             bool (*allowed)(const Json&), const std::string& kind) {
  if (!object.contains(key)) refuse(file, where + key + ": found none, allowed " + kind);
  if (!allowed(object.at(key))) refuse(file, where + key + ": found " + shown(object.at(key)) + ", allowed " + kind);
}

bool is_text(const Json& value) { return value.is_string(); }
bool is_flag(const Json& value) { return value.is_boolean(); }
bool is_object(const Json& value) { return value.is_object(); }
bool is_list(const Json& value) { return value.is_array(); }
bool is_number_or_null(const Json& value) { return value.is_number() || value.is_null(); }

void check_schema(const fs::path& file, const Json& json) {
  if (!json.is_object()) refuse(file, "found " + shown(json) + ", allowed a result document of schema finegauge/1");
  if (!json.contains("schema") || json.at("schema") != "finegauge/1")
    refuse(file, "schema: found " + (json.contains("schema") ? shown(json.at("schema")) : std::string("none")) +
                     ", allowed \"finegauge/1\"");
  for (const char* key : {"kind", "name"}) require(file, json, "", key, is_text, "a text");
  for (const char* key : {"summary", "environment", "inputs"}) require(file, json, "", key, is_object, "an object");
  for (const char* key : {"rows", "checks"}) require(file, json, "", key, is_list, "a list");
  require(file, json, "", "quick", is_flag, "true or false");
  for (std::size_t i = 0; i < json.at("rows").size(); ++i)
    if (!json.at("rows")[i].is_object())
      refuse(file, "rows[" + std::to_string(i) + "]: found " + shown(json.at("rows")[i]) + ", allowed an object");
  for (std::size_t i = 0; i < json.at("checks").size(); ++i) {
    const Json& one = json.at("checks")[i];
    const std::string where = "checks[" + std::to_string(i) + "]";
    if (!one.is_object()) refuse(file, where + ": found " + shown(one) + ", allowed an object");
    require(file, one, where + ".", "name", is_text, "a text");
    require(file, one, where + ".", "ok", is_flag, "true or false");
    for (const char* key : {"value", "low", "high"})
      require(file, one, where + ".", key, is_number_or_null, "a number or null");
  }
}

bool is_trace(const Json& json) {
  if (json.is_object()) return json.contains("traceEvents");
  return json.is_array() && !json.empty() && json[0].is_object() && json[0].contains("ph");
}

std::vector<fs::path> json_files(const fs::path& directory) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory))
    if (entry.is_regular_file() && entry.path().extension() == ".json" && entry.path().filename().string()[0] != '.')
      files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

std::vector<fs::path> files_of(const fs::path& path) {
  std::error_code error;
  if (fs::is_regular_file(path, error)) return {path};
  if (!fs::is_directory(path, error)) refuse(path, "found no such file or directory");
  try {
    std::vector<fs::path> files = json_files(path);
    if (!files.empty()) return files;
    std::vector<fs::path> folders;
    for (const fs::directory_entry& entry : fs::directory_iterator(path))
      if (entry.is_directory()) folders.push_back(entry.path());
    std::ranges::sort(folders);
    for (const fs::path& folder : folders) std::ranges::copy(json_files(folder), std::back_inserter(files));
    if (files.empty()) refuse(path, "found no .json file in it nor in its directories, allowed one or more");
    return files;
  } catch (const fs::filesystem_error& failed) {
    refuse(path, failed.code().message());
  }
}

int order_of(const std::string& kind) {
  static constexpr std::array kinds = {"reproduce", "verify", "run", "trade", "audit", "profile", "atlas", "gate"};
  const auto* const found = std::ranges::find(kinds, kind);
  return static_cast<int>(found - kinds.begin());
}

std::string identifier(const ReportDocument& document, std::set<std::string>& taken) {
  std::string id;
  for (const char c : document.kind + "-" + document.name)
    id += std::isalnum(static_cast<unsigned char>(c)) && static_cast<unsigned char>(c) < 0x80 ? c : '-';
  std::string unique = id;
  for (int number = 2; !taken.insert(unique).second; ++number) unique = id + "-" + std::to_string(number);
  return unique;
}

}  // namespace

std::vector<const Json*> ReportDocument::failing_checks() const {
  std::vector<const Json*> failing;
  for (const Json& one : checks())
    if (!one.at("ok").get<bool>()) failing.push_back(&one);
  return failing;
}

std::optional<ReportDocument> read_report_document(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse(file, "cannot be read");
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  ReportDocument document;
  try {
    document.content = Json::parse(text);
  } catch (const Json::parse_error& error) {
    refuse(file, place(text, error.byte) + ": not JSON: found " +
                     (error.byte > text.size() ? std::string("its end") : "an error") + ", allowed a whole document");
  } catch (const Json::exception& error) {
    refuse(file, std::string("not JSON: ") + error.what());  // a number beyond double's range
  }
  if (is_trace(document.content)) return std::nullopt;
  check_schema(file, document.content);
  document.file = file;
  document.shown_file = file.lexically_normal().string();
  document.kind = document.content.at("kind").get<std::string>();
  document.name = document.content.at("name").get<std::string>();
  document.quick = document.content.at("quick").get<bool>();
  return document;
}

std::vector<ReportDocument> read_report_documents(const std::vector<fs::path>& paths) {
  std::vector<ReportDocument> documents;
  std::set<fs::path> seen;
  for (const fs::path& path : paths)
    for (const fs::path& file : files_of(path)) {
      if (!seen.insert(fs::canonical(file)).second) continue;
      if (auto document = read_report_document(file)) documents.push_back(std::move(*document));
    }
  if (documents.empty()) throw UsageError("report: found no result document, allowed one or more");
  const auto key = [](const ReportDocument& d) {
    return std::tuple(order_of(d.kind), d.kind, text_at(d.content, "environment.started"), d.name, d.shown_file);
  };
  std::ranges::sort(documents, [&](const auto& a, const auto& b) { return key(a) < key(b); });
  std::set<std::string> taken;
  for (ReportDocument& document : documents) document.id = identifier(document, taken);
  return documents;
}

std::string command_of(const ReportDocument& document) {
  std::string command = "finegauge " + document.kind;
  if (document.kind == "reproduce")
    command += " " + document.name;
  else if (const std::string scene = text_at(document.content, "inputs.scene");
           !scene.empty() && scene.find(' ') == std::string::npos)
    command += " " + scene;
  if (document.quick) command += " --quick";
  if (const Json* overrides = find_value(document.content, "inputs.overrides"); overrides && overrides->is_object())
    for (const auto& [set, value] : overrides->items())
      command += " --set " + set + "=" + (value.is_string() ? value.get<std::string>() : shown(value));
  if (const double threads = number_at(document.content, "environment.threads"); threads > 1.0)
    command += " --threads " + std::to_string(static_cast<int>(threads));
  return command;
}

const Json* find_value(const Json& object, const std::string& path) {
  const Json* at = &object;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    if (!at->is_object()) return nullptr;
    const auto found = at->find(path.substr(begin, end - begin));
    if (found == at->end() || found->is_null()) return nullptr;
    at = &*found;
    begin = end + 1;
  }
  return at;
}

double number_at(const Json& object, const std::string& path) {
  const Json* value = find_value(object, path);
  return value && value->is_number() ? value->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string text_at(const Json& object, const std::string& path) {
  const Json* value = find_value(object, path);
  return value && value->is_string() ? value->get<std::string>() : std::string();
}

}  // namespace finegauge
