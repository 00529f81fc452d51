#include "core/scene/scene_keys.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "core/scene/plain_number.hpp"

namespace finegauge {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string range_words(const KeyRange& range) {
  const bool below = range.low > -infinity, above = range.high < infinity;
  std::string words;
  if (below && above)
    words = (range.low_allowed ? " in [" : " in (") + plain_number(range.low) + ", " + plain_number(range.high) +
            (range.high_allowed ? "]" : ")");
  else if (below)
    words = (range.low_allowed ? " >= " : " > ") + plain_number(range.low);
  else if (above)
    words = (range.high_allowed ? " <= " : " < ") + plain_number(range.high);
  if (!range.why.empty()) words += " (" + std::string(range.why) + ")";
  return words;
}

std::string choice_words(std::string_view choices) {
  std::string words = "\"";
  for (const char c : choices) words += c == '|' ? std::string("\" or \"") : std::string(1, c);
  return words + "\"";
}

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string_view>& candidates) {
  constexpr std::size_t longest_sensible = 64;
  if (word.size() > longest_sensible) return {};
  std::string_view best;
  int best_distance = 2 + static_cast<int>(word.size() / 4);  // exclusive
  for (const std::string_view candidate : candidates) {
    // A key that was cut short or written out is nearer than its edit distance says.
    const bool part = word.size() >= 3 && (candidate.find(word) != std::string_view::npos ||
                                           (candidate.size() >= 3 && word.find(candidate) != std::string_view::npos));
    const int distance = part ? 1 : edit_distance(word, candidate);
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = candidate;
  }
  return std::string(best);
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates) {
  const std::string best = nearest(word, candidates);
  std::string words = best.empty() ? "" : ", the nearest known one is \"" + best + "\"";
  words += ", allowed ";
  for (const std::string_view candidate : candidates)
    words += (candidate == candidates.front() ? "" : ", ") + std::string(candidate);
  return words;
}

}  // namespace

const SceneSection* find_section(std::string_view name) {
  const auto found = std::ranges::find(scene_sections(), name, &SceneSection::name);
  return found == scene_sections().end() ? nullptr : &*found;
}

const SceneKey* find_key(std::string_view section, std::string_view key) {
  const auto found =
      std::ranges::find_if(scene_keys(), [&](const SceneKey& row) { return row.section == section && row.key == key; });
  return found == scene_keys().end() ? nullptr : &*found;
}

std::string allowed_values(const SceneKey& key) {
  const std::string range = range_words(key.range);
  const std::string each = range.empty() ? "" : ", each" + range;
  switch (key.type) {
    case KeyType::text:
      return "a text that is not empty";
    case KeyType::choice:
      return choice_words(key.choices);
    case KeyType::boolean:
      return "true or false";
    case KeyType::integer:
      return "a whole number" + range;
    case KeyType::number:
      return "a finite number" + range;
    case KeyType::integers3:
      return "three whole numbers" + each;
    case KeyType::vector:
      return "three finite numbers" + each;
    case KeyType::direction:
      return "three finite numbers, not all zero";
    case KeyType::matrix:
      return "three rows of three finite numbers";
    case KeyType::axes:
      return "one to three of \"x\", \"y\", \"z\", none twice";
    case KeyType::refinement:
      return "a text \"NxMxK\", N, M, K from 1 to 4 and not all 1 (tetrahedra: \"2x2x2\" only)";
    case KeyType::points:
      return "a list of one or more triples of finite numbers";
    case KeyType::index_list:
      return "a list of one or more whole numbers" + each;
    case KeyType::index_lists:
      return "a list of one or more lists of whole numbers" + each;
    case KeyType::course:
      return "a list of one or more pairs [time, factor] of finite numbers, each time after the one before";
  }
  return {};
}

std::string suggest_key(std::string_view section, std::string_view word) {
  std::vector<std::string_view> candidates;
  for (const SceneKey& row : scene_keys())
    if (row.section == section) candidates.push_back(row.key);
  return suggestion(word, candidates);
}

std::string suggest_section(std::string_view word) {
  std::vector<std::string_view> candidates;
  for (const SceneSection& row : scene_sections())
    if (!row.name.empty()) candidates.push_back(row.name);
  return suggestion(word, candidates);
}

}  // namespace finegauge
