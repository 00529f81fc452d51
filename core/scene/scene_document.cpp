#include "core/scene/scene_document.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/scene/scene_error.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

constexpr std::uintmax_t scene_size_limit = std::uintmax_t{16} << 20;  // larger meshes belong in a gmsh file
constexpr int deepest_dotted_key = 32;

/// Line of the first key with too many dots, 0 if there is none. The parser limits nested brackets but makes a table
/// per dot, and tables are destroyed recursively: a long enough key would exhaust the stack.
std::size_t too_deep_key(std::string_view text) {
  std::size_t line = 1;
  int dots = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      const std::string_view rest = text.substr(i);
      const bool multi_line = rest.size() >= 3 && rest[1] == c && rest[2] == c;
      for (i += multi_line ? 3 : 1; i < text.size(); ++i) {
        if (c == '"' && text[i] == '\\' && i + 1 < text.size()) {
          if (text[++i] == '\n') ++line;
        } else if (text[i] == '\n') {
          ++line;
          if (!multi_line) break;
        } else if (text[i] == c && (!multi_line || text.substr(i + 1).starts_with(std::string(2, c)))) {
          // A text of several lines may itself end with one or two of its quotation marks.
          for (int more = 0; multi_line && more < 4 && i + 1 < text.size() && text[i + 1] == c; ++more) ++i;
          break;
        }
      }
    } else if (c == '#') {
      while (i + 1 < text.size() && text[i + 1] != '\n') ++i;
    } else if (c == '.') {
      if (++dots > deepest_dotted_key) return line;
    } else if (c == '=' || c == ',' || c == '[' || c == ']' || c == '{' || c == '}' || c == '\n') {
      dots = 0;
      if (c == '\n') ++line;
    }
  }
  return 0;
}

struct PathStep {
  std::string key;
  std::optional<std::size_t> index;
};

/// "load[0].traction" into steps; empty when it is not a path.
std::vector<PathStep> parse_path(std::string_view path) {
  std::vector<PathStep> steps;
  while (true) {
    const std::size_t dot = path.find('.');
    std::string_view word = path.substr(0, dot);
    PathStep step;
    if (const std::size_t open = word.find('['); open != std::string_view::npos) {
      const std::string_view digits = word.substr(open + 1);
      std::size_t index = 0;
      const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
      if (error != std::errc{} || std::string_view(end, digits.data() + digits.size() - end) != "]") return {};
      step.index = index;
      word = word.substr(0, open);
    }
    const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
    if (!plain) return {};
    step.key = word;
    steps.push_back(std::move(step));
    if (dot == std::string_view::npos) return steps;
    path = path.substr(dot + 1);
  }
}

/// The value of an override as a table with the one key `value`; empty when it is not TOML.
std::optional<toml::table> parse_value(const std::string& text) {
  if (text.find('\n') != std::string::npos || too_deep_key(text) != 0) return {};
  try {
    toml::table parsed = toml::parse("value = " + text);
    if (parsed.size() == 1) return parsed;
  } catch (const std::exception&) {  // a parse_error is one
  }
  return {};
}

bool begins_with_path(const std::string& field, const std::string& prefix) {
  return field.compare(0, prefix.size(), prefix) == 0 &&
         (field.size() == prefix.size() || field[prefix.size()] == '.' || field[prefix.size()] == '[');
}

}  // namespace

void refuse_unparsable() { throw std::runtime_error("found a character that begins no key and no value"); }

SceneDocument::SceneDocument(const std::filesystem::path& file, std::span<const std::string> overrides,
                             bool (*is_text)(const std::string&, const std::string&))
    : file_(file) {
  const std::string text = read_text_file(file, scene_size_limit);
  if (const std::size_t line = too_deep_key(text))
    throw SceneError(file.string() + ":" + std::to_string(line) + ": found a key with more than " +
                     std::to_string(deepest_dotted_key) + " dots, allowed section.key");
  try {
    root_ = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    const auto line = std::max<toml::source_index>(1, error.source().begin.line);
    throw SceneError(file.string() + ":" + std::to_string(line) +
                     ": not TOML: " + quoted_excerpt(std::string(error.description()), 200));
  } catch (const std::exception& error) {  // see TOML_ASSERT; without a line
    throw SceneError(file.string() + ":1: not TOML: " + error.what());
  }
  for (const std::string& override_text : overrides) apply(override_text, is_text);
}

void SceneDocument::apply(const std::string& text, bool (*is_text)(const std::string&, const std::string&)) {
  const std::string origin = "--set " + quoted_excerpt(text);
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) throw SceneError(origin + ": found no '=', allowed KEY=VALUE");
  const std::vector<PathStep> steps = parse_path(std::string_view(text).substr(0, std::min(equals, text.find(' '))));
  if (steps.empty() || steps.size() > 2)
    throw SceneError(origin + ": found \"" + quoted_excerpt(text.substr(0, equals)) +
                     "\", allowed KEY, SECTION.KEY or SECTION[INDEX].KEY");

  const std::string section = steps.size() == 2 ? steps.front().key : "";
  std::string value_text = text.substr(equals + 1);
  std::optional<toml::table> value = parse_value(value_text);
  if (!value && is_text(section, steps.back().key) && value_text.find_first_of("\"'\\\n") == std::string::npos)
    value = parse_value('"' + value_text + '"');
  if (!value)
    throw SceneError(origin + ": " + quoted_excerpt(text.substr(0, equals)) + ": found " + quoted_excerpt(value_text) +
                     ", allowed a TOML value");

  toml::table* table = &root_;
  std::string field;
  const auto refuse = [&](const std::string& words) { throw SceneError(origin + ": " + field + words); };
  for (std::size_t s = 0; s < steps.size(); ++s) {
    const PathStep& step = steps[s];
    field += (field.empty() ? "" : ".") + step.key;
    if (step.index) field += "[" + std::to_string(*step.index) + "]";
    if (s + 1 == steps.size()) break;
    if (!step.index) {
      if (!table->contains(step.key)) table->insert(step.key, toml::table{});
      table = table->get_as<toml::table>(step.key);
      if (!table) refuse(" is no section here; of several write " + field + "[0]");
      continue;
    }
    if (!table->contains(step.key)) table->insert(step.key, toml::array{});
    toml::array* list = table->get_as<toml::array>(step.key);
    const std::size_t count = list ? list->size() : 0;
    // One past the last adds a section.
    if (!list || *step.index > count)
      refuse(": found index " + std::to_string(*step.index) + ", allowed 0 to " + std::to_string(count));
    if (*step.index == count) list->push_back(toml::table{});
    table = list->get_as<toml::table>(*step.index);
    if (!table) refuse(" is no section");
  }
  toml::node& new_value = *value->get("value");
  const PathStep& last = steps.back();
  if (last.index) {
    toml::array* list = table->get_as<toml::array>(last.key);
    if (!list || *last.index >= list->size())
      throw SceneError(origin + ": " + field + ": found index " + std::to_string(*last.index) + ", allowed one below " +
                       std::to_string(list ? list->size() : 0));
    list->replace(list->cbegin() + static_cast<std::ptrdiff_t>(*last.index), std::move(new_value));
  } else {
    table->insert_or_assign(last.key, std::move(new_value));
  }
  overrides_.push_back({field, text});
}

void SceneDocument::fail(const std::string& field, toml::source_index line, const std::string& what) const {
  const std::string in_file = file_.string() + ":" + std::to_string(std::max<toml::source_index>(1, line));
  std::string where = in_file;
  // The last override wins, as it did when they were applied. Without a line the field is missing from a section that
  // an override may have made.
  for (const Override& set : overrides_) {
    const bool made_section = line == 0 && begins_with_path(set.field, field.substr(0, field.rfind('.')));
    if (begins_with_path(field, set.field) || made_section) where = "--set " + quoted_excerpt(set.text);
  }
  throw SceneError(where + ": " + field + ": " + what);
}

std::string excerpt(const toml::node& node) {
  if (const auto* text = node.as_string()) return '"' + quoted_excerpt(text->get()) + '"';
  if (const auto* boolean = node.as_boolean()) return boolean->get() ? "true" : "false";
  if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
  if (const auto* real = node.as_floating_point()) {
    std::array<char, 40> digits{};  // the fewest that give the number back, as a user would have written it
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), real->get()).ptr;
    return {digits.data(), end};
  }
  if (node.is_table()) return "a table";
  const auto* list = node.as_array();
  if (!list) return "a date or time";
  constexpr std::size_t few_entries = 10;
  if (list->size() > few_entries) return "a list of " + std::to_string(list->size()) + " entries";
  std::string entries;
  for (const toml::node& entry : *list)
    entries += (entries.empty() ? "" : ", ") + (entry.is_array() ? std::string("[...]") : excerpt(entry));
  return "[" + quoted_excerpt(entries) + "]";
}

}  // namespace finegauge
