#include "verification/support/property.hpp"

#include <algorithm>
#include <charconv>
#include <random>
#include <sstream>
#include <string_view>

#include "verification/support/refinement_history.hpp"

namespace finegauge {
namespace {

[[noreturn]] void refuse(int line, const std::string& text) {
  throw std::invalid_argument("line " + std::to_string(line) + " of the history: found \"" + text +
                              "\", allowed \"refine PATH NxMxK\" or \"coarsen PATH\"");
}

/// Numbers with slashes between them; empty when it is anything else.
std::vector<int> parse_path(std::string_view text) {
  std::vector<int> path;
  while (true) {
    int number = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || number < 0) return {};
    path.push_back(number);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.empty()) return path;
    if (text.front() != '/') return {};
    text.remove_prefix(1);
  }
}

}  // namespace

int find_cell(const RefinementForest& forest, const std::vector<int>& path) {
  if (path.empty() || path[0] < 0 || path[0] >= static_cast<int>(forest.base().cells.size())) return -1;
  int handle = path[0];
  for (std::size_t level = 1; level < path.size(); ++level) {
    if (forest.is_leaf(handle)) return -1;
    const RefinementForest::Cell& cell = forest.cell(handle);
    if (path[level] < 0 || path[level] >= cell.refinement.child_count()) return -1;
    handle = cell.first_child + path[level];
  }
  return handle;
}

std::vector<int> path_of(const RefinementForest& forest, int handle) {
  std::vector<int> path;
  while (forest.cell(handle).parent >= 0) {
    const int parent = forest.cell(handle).parent;
    path.push_back(handle - forest.cell(parent).first_child);
    handle = parent;
  }
  path.push_back(handle);
  std::reverse(path.begin(), path.end());
  return path;
}

bool perform(const ForestOperation& operation, RefinementForest& forest) {
  const int handle = find_cell(forest, operation.path);
  if (handle < 0) return false;
  if (operation.refinement) {
    if (!forest.can_refine(handle, *operation.refinement)) return false;
    forest.refine(handle, *operation.refinement);
    return true;
  }
  if (!forest.can_coarsen(handle)) return false;
  forest.coarsen(handle);
  return true;
}

ForestHistory perform(const ForestHistory& history, RefinementForest& forest) {
  ForestHistory done;
  for (const ForestOperation& operation : history)
    if (perform(operation, forest)) done.push_back(operation);
  return done;
}

ForestOperation inverse(const ForestOperation& operation, const RefinementForest& forest) {
  const int handle = find_cell(forest, operation.path);
  if (operation.refinement || handle < 0) return {operation.path, std::nullopt};
  return {operation.path, forest.cell(handle).refinement};
}

ForestHistory random_history(const BaseMesh& base, const RandomHistory& options, std::uint32_t seed) {
  std::mt19937 generator(seed);
  BaseMesh lattice = base;
  lattice.body.reset();  // what fills the cells decides nothing here, and costs an integral a child
  RefinementForest forest(std::move(lattice));
  ForestHistory history;
  const auto draw = [&](const std::vector<int>& from) { return from[generator() % from.size()]; };
  // An operation that does not fit is drawn again; a body that is full and may not be coarsened ends the history.
  for (int attempt = 0; attempt < 20 * options.operations; ++attempt) {
    if (static_cast<int>(history.size()) == options.operations) break;
    ForestOperation next;
    if (generator() / 4294967296.0 < options.coarsening) {
      const std::vector<int> found = families(forest);
      if (found.empty()) continue;
      next.path = path_of(forest, draw(found));
    } else {
      const std::vector<int> found = leaves(forest);
      int leaf = draw(found);
      if (const int other = draw(found); forest.cell(other).depth > forest.cell(leaf).depth) leaf = other;
      next.refinement = options.templates[generator() % options.templates.size()];
      if (forest.cell(leaf).depth >= options.max_depth) continue;
      if (forest.leaf_count() + next.refinement->child_count() - 1 > options.max_leaves) continue;
      next.path = path_of(forest, leaf);
    }
    if (perform(next, forest)) history.push_back(std::move(next));
  }
  return history;
}

std::string to_text(const ForestOperation& operation) {
  std::string text = operation.refinement ? "refine " : "coarsen ";
  for (std::size_t level = 0; level < operation.path.size(); ++level)
    text += (level > 0 ? "/" : "") + std::to_string(operation.path[level]);
  if (operation.refinement) text += ' ' + to_string(*operation.refinement);
  return text;
}

std::string to_text(const ForestHistory& history) {
  std::string text;
  for (const ForestOperation& operation : history) text += to_text(operation) + '\n';
  return text;
}

ForestHistory parse_history(const std::string& text) {
  ForestHistory history;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string verb, path, refinement, more;
    if (!(words >> verb)) continue;  // an empty line
    words >> path >> refinement >> more;
    ForestOperation operation{parse_path(path), std::nullopt};
    const bool refines = verb == "refine";
    if (operation.path.empty() || !more.empty() || (!refines && (verb != "coarsen" || !refinement.empty())))
      refuse(number, line);
    try {
      if (refines) operation.refinement = parse_refinement_template(refinement);
    } catch (const std::invalid_argument&) {
      refuse(number, line);
    }
    history.push_back(std::move(operation));
  }
  return history;
}

}  // namespace finegauge
