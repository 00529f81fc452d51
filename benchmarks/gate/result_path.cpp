#include "benchmarks/gate/result_path.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace finegauge {
namespace {

bool parse_brackets(std::string_view inside, PathPart& part) {
  if (inside.empty()) return false;
  if (inside.find('=') == std::string_view::npos) {
    long index = 0;
    const auto [end, error] = std::from_chars(inside.data(), inside.data() + inside.size(), index);
    part.index = index;
    return error == std::errc{} && end == inside.data() + inside.size();
  }
  while (true) {
    const std::size_t comma = inside.find(',');
    const std::string_view pair = inside.substr(0, comma);
    const std::size_t equals = pair.find('=');
    if (equals == std::string_view::npos || equals == 0 || equals + 1 == pair.size()) return false;
    part.where.emplace_back(pair.substr(0, equals), pair.substr(equals + 1));
    if (comma == std::string_view::npos) return true;
    inside = inside.substr(comma + 1);
  }
}

bool has_text(const Json& entry, const std::string& key, const std::string& text) {
  if (!entry.is_object() || !entry.contains(key)) return false;
  const Json& value = entry.at(key);
  return value.is_string() ? value.get<std::string>() == text : value.dump() == text;
}

/// Steps into the brackets of a part; false with a reason when they lead nowhere.
bool enter_list(const Json*& node, const PathPart& part, std::string& why) {
  if (!part.index && part.where.empty()) return true;
  if (!node->is_array()) {
    why = part.key + " is no list";
    return false;
  }
  const long size = static_cast<long>(node->size());
  if (part.index) {
    const long at = *part.index < 0 ? size + *part.index : *part.index;
    if (at < 0 || at >= size) {
      why = part.key + " has " + std::to_string(size) + " entries, none is number " + std::to_string(*part.index);
      return false;
    }
    node = &(*node)[static_cast<std::size_t>(at)];
    return true;
  }
  const Json* found = nullptr;
  int count = 0;
  for (const Json& entry : *node)
    if (std::ranges::all_of(part.where, [&](const auto& pair) { return has_text(entry, pair.first, pair.second); })) {
      found = &entry;
      ++count;
    }
  if (count != 1) {
    std::string wanted;
    for (const auto& [key, text] : part.where) wanted.append(wanted.empty() ? "" : ", ").append(key + " = " + text);
    why = (count == 0 ? "no entry" : std::to_string(count) + " entries") + " of " + part.key + " with " + wanted;
    return false;
  }
  node = found;
  return true;
}

}  // namespace

std::optional<std::vector<PathPart>> parse_result_path(std::string_view path) {
  std::vector<PathPart> parts;
  while (true) {
    PathPart part;
    const std::size_t key_end = std::min(path.find_first_of(".[]"), path.size());
    part.key = path.substr(0, key_end);
    if (part.key.empty()) return {};
    path = path.substr(key_end);
    if (path.starts_with('[')) {
      const std::size_t close = path.find(']');
      if (close == std::string_view::npos || !parse_brackets(path.substr(1, close - 1), part)) return {};
      path = path.substr(close + 1);
    }
    parts.push_back(std::move(part));
    if (path.empty()) return parts;
    if (!path.starts_with('.')) return {};
    path = path.substr(1);
  }
}

bool is_time(std::string_view key) {
  constexpr std::array<std::string_view, 7> times = {
      "ms", "milliseconds", "seconds", "frames_per_second", "missed_frames", "longest_miss_streak", "time_all_steps"};
  return key.ends_with("_ms") || key.ends_with("_ns") || std::ranges::find(times, key) != times.end();
}

FoundNumber find_number(const Json& document, const std::string& path) {
  const std::optional<std::vector<PathPart>> parts = parse_result_path(path);
  if (!parts) return {{}, "no path: " + path};
  const Json* node = &document;
  std::string why;
  for (const PathPart& part : *parts) {
    if (!node->is_object() || !node->contains(part.key)) return {{}, "the result has no " + part.key + " of " + path};
    const Json& parent = *node;
    node = &parent.at(part.key);
    if (!enter_list(node, part, why)) return {{}, why};
    if (node->is_null()) {
      const std::string reason = part.key + "_reason";
      return {
          {},
          part.key + " is null" +
              (parent.contains(reason) && parent.at(reason).is_string() ? ": " + parent.at(reason).get<std::string>()
                                                                        : std::string())};
    }
  }
  if (node->is_boolean()) return {node->get<bool>() ? 1.0 : 0.0, {}};
  if (!node->is_number()) return {{}, path + " is no number"};
  return {node->get<double>(), {}};
}

}  // namespace finegauge
