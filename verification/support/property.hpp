#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/base_mesh.hpp"
#include "core/mesh/refinement_forest.hpp"
#include "core/mesh/refinement_template.hpp"

namespace finegauge {

/// Statements that hold after every history of operations, tried on histories drawn from fixed seeds (Claessen & Hughes
/// 2000, QuickCheck). A history that breaks one is cut down to operations none of which can be left out, and is told as
/// text that can be read back and run again.

/// What is broken after a history, in words; empty when nothing is. What it throws is broken too. The same history
/// always has the same answer, and every part of a history is a history.
template <class Operation>
using Property = std::function<std::string(const std::vector<Operation>& history)>;

template <class Operation>
std::string fault_after(const std::vector<Operation>& history, const Property<Operation>& property) {
  try {
    return property(history);
  } catch (const std::exception& error) {
    return std::string("thrown: ") + error.what();
  }
}

template <class Operation>
struct Counterexample {
  std::uint32_t seed = 0;
  std::vector<Operation> drawn;
  std::vector<Operation> history;  ///< the same, shrunk
  std::string fault;               ///< what is broken after `history`
  int runs = 0;                    ///< histories tried while shrinking
};

/// Leaves operations out as long as something stays broken: runs of half the history, of a quarter, ... and single ones
/// until each that is left is needed (the complements of Zeller & Hildebrandt 2002, "Simplifying and isolating
/// failure-inducing input"). Later operations first, since they may rest on earlier ones. The fault may turn into
/// another one on the way; that is as good a find. Throws std::invalid_argument when nothing is broken to begin with.
template <class Operation>
Counterexample<Operation> shrink(std::vector<Operation> history, const Property<Operation>& property) {
  Counterexample<Operation> found;
  found.drawn = history;
  found.fault = fault_after(history, property);
  found.runs = 1;
  if (found.fault.empty()) throw std::invalid_argument("shrink: the history breaks nothing");
  std::size_t length = std::max<std::size_t>(1, history.size() / 2);
  while (true) {
    bool dropped = false;
    for (std::size_t end = history.size(); end > 0;) {
      const std::size_t begin = end > length ? end - length : 0;
      std::vector<Operation> shorter(history.begin(), history.begin() + static_cast<std::ptrdiff_t>(begin));
      shorter.insert(shorter.end(), history.begin() + static_cast<std::ptrdiff_t>(end), history.end());
      std::string fault = fault_after(shorter, property);
      ++found.runs;
      if (!fault.empty()) {
        history = std::move(shorter);
        found.fault = std::move(fault);
        dropped = true;
      }
      end = begin;
    }
    if (length == 1 && !dropped) break;  // what was needed may no longer be once another one is gone
    length = std::max<std::size_t>(1, length / 2);
  }
  found.history = std::move(history);
  return found;
}

template <class Operation>
struct PropertyCheck {
  int histories = 0, operations = 0;  ///< tried, up to the first that breaks it
  std::optional<Counterexample<Operation>> counterexample;
};

/// Tries the histories of the seeds one after another; the first that breaks the property is shrunk and ends the check.
template <class Operation, class Draw>
PropertyCheck<Operation> check_property(std::span<const std::uint32_t> seeds, const Draw& draw,
                                        const Property<Operation>& property) {
  PropertyCheck<Operation> check;
  for (const std::uint32_t seed : seeds) {
    const std::vector<Operation> history = draw(seed);
    ++check.histories;
    check.operations += static_cast<int>(history.size());
    if (fault_after(history, property).empty()) continue;
    check.counterexample = shrink(history, property);
    check.counterexample->seed = seed;
    break;
  }
  return check;
}

/// One change of a forest. The cell is named by its place: the base cell, then the child's number at each level.
struct ForestOperation {
  std::vector<int> path;
  std::optional<RefinementTemplate> refinement;  ///< of the leaf there; none: the cell's children are removed
  bool operator==(const ForestOperation&) const = default;
};
using ForestHistory = std::vector<ForestOperation>;

/// Handle of the cell at a place, -1 where there is none; and back.
int find_cell(const RefinementForest& forest, const std::vector<int>& path);
std::vector<int> path_of(const RefinementForest& forest, int handle);

/// Whether the operation could be done. One that does not fit (no such cell, nothing to refine or coarsen there) does
/// nothing, so that a history can lose any of its operations.
bool perform(const ForestOperation& operation, RefinementForest& forest);
/// Which of them could be done; those alone are a history of the same states.
ForestHistory perform(const ForestHistory& history, RefinementForest& forest);
/// What takes the operation back; asked while the forest is as it was before it. Of one that cannot be done: anything.
ForestOperation inverse(const ForestOperation& operation, const RefinementForest& forest);

struct RandomHistory {
  std::span<const RefinementTemplate> templates;
  int operations = 30;
  double coarsening = 0.3;  ///< share of the operations that coarsen
  int max_depth = 4;
  int max_leaves = 200;
};
/// Operations that can all be done one after the other, from the unrefined mesh on: random leaves by random templates,
/// deep leaves rather than shallow ones, and random families.
ForestHistory random_history(const BaseMesh& base, const RandomHistory& options, std::uint32_t seed);

/// "refine 3/0/7 2x3x2" or "coarsen 3/0", an operation a line; and back, throwing std::invalid_argument with the line
/// on anything else.
std::string to_text(const ForestOperation& operation);
std::string to_text(const ForestHistory& history);
ForestHistory parse_history(const std::string& text);

}  // namespace finegauge
