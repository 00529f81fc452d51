#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <string_view>

#include "benchmarks/gate/budget.hpp"
#include "benchmarks/gate/result_path.hpp"
#include "core/scene/scene_document.hpp"
#include "core/scene/scene_error.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

constexpr std::array kinds = {BudgetKind::accuracy, BudgetKind::counter, BudgetKind::instructions, BudgetKind::time};

/// The keys that a kind of budget has beside those that all have.
std::vector<std::string_view> keys_of(BudgetKind kind) {
  std::vector<std::string_view> keys = {"name", "kind", "run", "reason", "optional", "slow"};
  const auto add = [&](std::initializer_list<std::string_view> more) { keys.insert(keys.end(), more); };
  switch (kind) {
    case BudgetKind::accuracy:
      add({"value", "low", "high"});
      break;
    case BudgetKind::counter:
      add({"value", "equals", "low", "high"});
      break;
    case BudgetKind::instructions:
      add({"over", "within", "low", "high"});
      break;
    case BudgetKind::time:
      add({"against", "percentile", "frames", "slower", "low", "high"});
      break;
  }
  return keys;
}

std::string joined(std::span<const std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

/// Words of a command line, separated by spaces; quotation marks of either kind keep spaces in a word. None where a
/// quotation mark is not closed.
std::optional<JobWords> split_words(std::string_view line) {
  JobWords words;
  bool open = false;
  char quote = 0;
  for (const char c : line) {
    if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '"' || c == '\'')) {
      quote = c;
      if (!open) words.emplace_back();
      open = true;
    } else if (quote == 0 && c == ' ') {
      open = false;
    } else {
      if (!open) words.emplace_back();
      open = true;
      words.back() += c;
    }
  }
  if (quote != 0) return {};
  return words;
}

/// One [[budget]] and the messages about it.
class BudgetTable {
 public:
  BudgetTable(const SceneDocument& document, std::size_t index, const toml::table& table)
      : document_(document), field_("budget[" + std::to_string(index) + "]"), table_(table) {}

  Budget read() const {
    Budget budget;
    budget.kind = kind();
    refuse_unknown_keys(budget.kind);
    budget.name = text("name").value_or("");
    if (!has("name")) missing("name", "a name of its own");
    if (!plain_name(budget.name)) refuse("name", "letters, digits, '_', '-' and '.'");
    budget.run = command("run");
    if (!has("run")) missing("run", "a command of finegauge");
    budget.reason = text("reason").value_or("");
    if (budget.reason.empty()) missing("reason", "why the bounds are what they are");
    budget.slow = boolean("slow");
    read_optional(budget);
    switch (budget.kind) {
      case BudgetKind::accuracy:
        budget.value = result_path();
        read_bounds(budget);
        break;
      case BudgetKind::counter:
        budget.value = result_path();
        read_count(budget);
        break;
      case BudgetKind::instructions:
        budget.over = text("over").value_or("base") == "base" ? JobWords{} : command("over");
        if (!has("over")) missing("over", "\"base\" or a command of finegauge");
        budget.within = text("within").value_or("");
        read_bounds(budget);
        if (!(budget.low > 0.0)) refuse("low", "a ratio above 0");
        break;
      case BudgetKind::time:
        read_time(budget);
        break;
    }
    check_optional(budget);
    return budget;
  }

  [[noreturn]] void refuse(const std::string& key, const std::string& allowed) const {
    const toml::node* node = table_.get(key);
    document_.fail(field_ + "." + key, node->source().begin.line, "found " + excerpt(*node) + ", allowed " + allowed);
  }

 private:
  bool has(std::string_view key) const { return table_.contains(key); }
  [[noreturn]] void missing(const std::string& key, const std::string& allowed) const {
    document_.fail(field_ + "." + key, table_.source().begin.line, "found nothing, required: " + allowed);
  }

  std::optional<std::string> text(const std::string& key) const {
    const toml::node* node = table_.get(key);
    if (!node) return {};
    const auto* value = node->as_string();
    if (!value || value->get().empty() || value->get().find('\0') != std::string::npos)
      refuse(key, "a text that is not empty");
    return value->get();
  }
  bool boolean(const std::string& key) const {
    const toml::node* node = table_.get(key);
    if (!node) return false;
    if (!node->is_boolean()) refuse(key, "true or false");
    return node->as_boolean()->get();
  }
  std::optional<double> number(const std::string& key) const {
    const toml::node* node = table_.get(key);
    if (!node) return {};
    const double value = node->is_integer()          ? static_cast<double>(node->as_integer()->get())
                         : node->is_floating_point() ? node->as_floating_point()->get()
                                                     : std::nan("");
    if (!std::isfinite(value)) refuse(key, "a number");
    return value;
  }

  BudgetKind kind() const {
    if (!has("kind")) missing("kind", "accuracy, counter, instructions or time");
    const std::string word = text("kind").value();
    const auto found = std::ranges::find_if(kinds, [&](BudgetKind kind) { return word == to_string(kind); });
    if (found == kinds.end()) refuse("kind", "accuracy, counter, instructions or time");
    return *found;
  }

  void refuse_unknown_keys(BudgetKind kind) const {
    const std::vector<std::string_view> keys = keys_of(kind);
    for (const auto& [key, node] : table_) {
      if (std::ranges::find(keys, key.str()) != keys.end()) continue;
      const std::string name(key.str());
      document_.fail(field_ + "." + quoted_excerpt(name), key.source().begin.line,
                     is_time(name) ? "a stored time is no bound: the same build has another one tomorrow; allowed "
                                     "kind = \"time\" with against = \"base\" or \"calibration\""
                                   : std::string("unknown key of a budget of kind ") + to_string(kind) +
                                         "; there are: " + joined(keys));
    }
  }

  static bool plain_name(const std::string& name) {
    return !name.empty() && std::ranges::all_of(name, [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
             c == '.';
    });
  }

  JobWords command(const std::string& key) const {
    const std::optional<std::string> line = text(key);
    if (!line) return {};
    const std::optional<JobWords> words = split_words(*line);
    constexpr std::array<std::string_view, 8> known = {"run",   "reproduce", "verify",  "atlas",
                                                       "trade", "audit",     "profile", "gate"};
    const std::string allowed = "a command of finegauge with its options: " + joined(known) + " (of gate: --counters)";
    if (!words || words->empty() || std::ranges::find(known, words->front()) == known.end()) refuse(key, allowed);
    if (words->front() == "gate" && *words != JobWords{"gate", "--counters"}) refuse(key, allowed);
    for (const std::string& word : *words)
      if (word == "-o" || word.starts_with("--out") || word == "--json" || word == "--quiet")
        refuse(key, "a command without " + word + ": where results go is the gate's affair");
    return *words;
  }

  std::string result_path() const {
    if (!has("value")) missing("value", "where in the result the number stands, such as summary.dofs.max");
    const std::string path = text("value").value();
    const std::optional<std::vector<PathPart>> parts = parse_result_path(path);
    if (!parts) refuse("value", "a path such as summary.dofs.max, rows[-1].eta or rows[claim=spr.crack].value");
    for (const PathPart& part : *parts)
      if (is_time(part.key))
        refuse("value",
               "no time and no rate: a stored one is no bound; judge it by kind = \"time\" with against = \"base\" or "
               "\"calibration\"");
    return path;
  }

  void read_bounds(Budget& budget) const {
    for (const char* key : {"low", "high"})
      if (!has(key)) missing(key, "a number; a bound has two sides");
    budget.low = number("low").value();
    budget.high = number("high").value();
    if (!(budget.low <= budget.high)) refuse("high", "at least low");
  }

  void read_count(Budget& budget) const {
    if (has("equals")) {
      for (const char* key : {"low", "high"})
        if (has(key)) refuse(key, "either equals, or low and high");
      budget.low = budget.high = number("equals").value();
      if (budget.low != std::floor(budget.low)) refuse("equals", "a whole number");
      return;
    }
    if (!has("low") && !has("high")) missing("equals", "a whole number, or low and high");
    read_bounds(budget);
    for (const char* key : {"low", "high"})
      if (const double value = number(key).value(); value != std::floor(value)) refuse(key, "a whole number");
  }

  void read_time(Budget& budget) const {
    if (!has("against")) missing("against", "\"base\" or \"calibration\"");
    const std::string against = text("against").value();
    if (against != "base" && against != "calibration") refuse("against", "\"base\" or \"calibration\"");
    budget.against_base = against == "base";
    if (!has("percentile")) missing("percentile", "a whole number, 1 to 100; 50 is the median frame");
    const double percentile = number("percentile").value();
    if (!(percentile >= 1.0 && percentile <= 100.0 && percentile == std::floor(percentile)))
      refuse("percentile", "a whole number, 1 to 100");
    budget.percentile = static_cast<int>(percentile);
    budget.frames = text("frames").value_or("processor_ms");
    if (!budget.against_base) {
      if (has("slower")) refuse("slower", "with against = \"base\" only; a calibrated time has low and high");
      read_bounds(budget);
      if (!(budget.low > 0.0)) refuse("low", "a ratio above 0");
      return;
    }
    for (const char* key : {"low", "high"})
      if (has(key)) refuse(key, "with against = \"calibration\" only; against the base the bound is `slower`");
    budget.slower = number("slower").value_or(0.10);
    if (!(budget.slower >= 0.05 && budget.slower <= 1.0))
      refuse("slower", "0.05 to 1: less than 5 % is within what the placement of code does");
    budget.high = 1.0 + budget.slower;
  }

  void read_optional(Budget& budget) const {
    const toml::node* node = table_.get("optional");
    if (!node) return;
    const auto take = [&](const toml::node& word) {
      const auto* given = word.as_string();
      if (given && given->get() == "base")
        budget.without_base = true;
      else if (given && given->get() == "valgrind")
        budget.without_valgrind = true;
      else
        refuse("optional", "\"base\", \"valgrind\" or a list of both");
    };
    if (const auto* list = node->as_array())
      for (const toml::node& word : *list) take(word);
    else
      take(*node);
  }
  void check_optional(const Budget& budget) const {
    if (budget.without_base && !budget.needs_base()) refuse("optional", "\"base\" only where a base is compared with");
    if (budget.without_valgrind && budget.kind != BudgetKind::instructions)
      refuse("optional", "\"valgrind\" only with kind = \"instructions\"");
  }

  const SceneDocument& document_;
  std::string field_;
  const toml::table& table_;
};

}  // namespace

const char* to_string(BudgetKind kind) {
  switch (kind) {
    case BudgetKind::accuracy:
      return "accuracy";
    case BudgetKind::counter:
      return "counter";
    case BudgetKind::instructions:
      return "instructions";
    case BudgetKind::time:
      return "time";
  }
  return "";
}

std::string to_string(const JobWords& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::vector<Budget> read_budgets(const std::filesystem::path& file) {
  const SceneDocument document(file, {}, [](const std::string&, const std::string&) { return false; });
  for (const auto& [key, node] : document.root())
    if (key.str() != "budget")
      document.fail(quoted_excerpt(std::string(key.str())), key.source().begin.line, "unknown key; there is: budget");
  const toml::node* list = document.root().get("budget");
  if (!list) document.fail("budget", 1, "found nothing, required: [[budget]], once or more");
  const toml::array* tables = list->as_array();
  if (!tables || tables->empty() || !tables->is_homogeneous(toml::node_type::table))
    document.fail("budget", list->source().begin.line, "found " + excerpt(*list) + ", allowed [[budget]] sections");
  std::vector<Budget> budgets;
  std::set<std::string> names;
  for (std::size_t i = 0; i < tables->size(); ++i) {
    const BudgetTable table(document, i, *tables->get_as<toml::table>(i));
    budgets.push_back(table.read());
    if (!names.insert(budgets.back().name).second) table.refuse("name", "a name that no other budget has");
  }
  return budgets;
}

}  // namespace finegauge
