#include "core/adapt/frame_adaptivity.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/adapt/apply_refinements.hpp"
#include "core/adapt/directional_marking.hpp"
#include "core/adapt/marking_comparison.hpp"
#include "core/adapt/tolerance_marking.hpp"

namespace finegauge {

namespace {

void check_range(const char* name, double value, bool inside, const char* range) {
  if (!inside)
    throw std::invalid_argument(std::string(name) + ": found " + std::to_string(value) + ", allowed is " + range);
}

/// The largest η², refusing what would make comparisons false in silence.
double largest_square(const Eigen::VectorXd& eta, const Eigen::VectorXd& von_mises) {
  double largest = 0.0;
  for (Eigen::Index cell = 0; cell < eta.size(); ++cell) {
    if (!(eta[cell] >= 0.0 && std::isfinite(eta[cell])))
      throw std::invalid_argument("eta of cell " + std::to_string(cell) + ": found " + std::to_string(eta[cell]) +
                                  ", allowed is finite and >= 0");
    if (!(von_mises[cell] >= 0.0 && std::isfinite(von_mises[cell])))
      throw std::invalid_argument("von Mises stress of cell " + std::to_string(cell) + ": found " +
                                  std::to_string(von_mises[cell]) + ", allowed is finite and >= 0");
    largest = std::max(largest, square(eta[cell]));
  }
  return largest;
}

void resize(FrameAdaptHistory& history, int handles) {
  const auto size = static_cast<std::size_t>(handles);
  history.von_mises.resize(size, -1.0);
  history.changed.resize(size, FrameAdaptHistory::long_ago);
  history.coarsened.resize(size, 0);
}

void set_entry(FrameAdaptHistory& history, int handle, double von_mises, int changed, bool coarsened) {
  history.von_mises[handle] = von_mises;
  history.changed[handle] = changed;
  history.coarsened[handle] = coarsened;
}

void clear_entry(FrameAdaptHistory& history, int handle) {
  set_entry(history, handle, -1.0, FrameAdaptHistory::long_ago, false);
}

/// Cells whose error asks for a template, before stress and budget have their say; ascending.
std::vector<Refinement> wanted_refinements(const Mesh& mesh, const ErrorEstimate& estimate, double largest,
                                           const FrameAdaptRules& rules) {
  if (rules.directional) {
    const auto& divisions = rules.refinement.divisions;
    const int division = std::count(divisions.begin(), divisions.end(), 3) > 0 ? 3 : 2;
    return choose_templates(mesh, estimate,
                            {.theta = rules.refine_above, .division = division, .may_repeat = division == 2},
                            rules.max_depth);
  }
  const int levels = divides_by_four(rules.refinement) ? 2 : 1;
  std::vector<Refinement> wanted;
  for (int cell = 0; cell < mesh.cell_count(); ++cell)
    if (mesh.frames[cell].depth + levels <= rules.max_depth && estimate.eta[cell] > 0.0 &&
        at_least(square(estimate.eta[cell]), square(rules.refine_above) * largest))
      wanted.push_back({cell, rules.refinement});
  return wanted;
}

/// What a refinement adds to the dofs at most. A node that is new, or stops to hang, is on the lattice of a cell that
/// is refined and none of its corners; neighbours that share it, and nodes that hang, make it less.
int most_new_dofs(CellShape shape, RefinementTemplate refinement) {
  if (shape == CellShape::tetrahedron) return 3 * 6;
  const auto& n = refinement.divisions;
  return 3 * ((n[0] + 1) * (n[1] + 1) * (n[2] + 1) - 8);
}

/// Keeps those with the largest errors whose dofs surely fit, ties by cell, and their order. What the bound leaves
/// unused is known in the next frame.
void keep_within_budget(const Mesh& mesh, const Eigen::VectorXd& eta, int budget, std::vector<Refinement>& refine) {
  std::sort(refine.begin(), refine.end(), [&](const Refinement& a, const Refinement& b) {
    return eta[a.cell] > eta[b.cell] || (eta[a.cell] == eta[b.cell] && a.cell < b.cell);
  });
  std::size_t kept = 0;
  for (; kept < refine.size(); ++kept) {
    budget -= most_new_dofs(mesh.shape, refine[kept].refinement);
    if (budget < 0) break;
  }
  refine.resize(kept);
  std::sort(refine.begin(), refine.end(), [](const Refinement& a, const Refinement& b) { return a.cell < b.cell; });
}

/// The frame's errors and the signs of the rates.
struct FrameErrors {
  const ErrorEstimate& estimate;
  double largest;                   ///< max η² [J]
  std::vector<std::uint8_t> rises;  ///< per cell, 1: the stress rises, 0: it does not, 2: no rate
  bool at_rest;
};

std::vector<std::uint8_t> rising_cells(const Mesh& mesh, const Eigen::VectorXd& von_mises,
                                       const FrameAdaptHistory& history) {
  std::vector<std::uint8_t> rises(static_cast<std::size_t>(mesh.cell_count()));
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const double last = history.von_mises[mesh.forest_cell[cell]];
    rises[cell] = last < 0.0 ? 2 : von_mises[cell] > last;
  }
  return rises;
}

bool family_may_go(const Mesh& mesh, const FrameErrors& errors, int first, int count, int frame,
                   const FrameAdaptRules& rules, const FrameAdaptHistory& history) {
  double sum = 0.0;
  for (int cell = first; cell < first + count; ++cell) {
    if (frame - history.changed[mesh.forest_cell[cell]] < rules.dwell) return false;
    if (errors.rises[cell] != 0 && !errors.at_rest) return false;
    sum += square(errors.estimate.eta[cell]);
  }
  return errors.at_rest || at_most(sum, square(rules.coarsen_below) * errors.largest);
}

std::vector<int> families_to_coarsen(const RefinementForest& forest, const Mesh& mesh, const FrameErrors& errors,
                                     int frame, const FrameAdaptRules& rules, const FrameAdaptHistory& history) {
  std::vector<int> coarsen;
  visit_families(forest, mesh, [&](int parent, int first, int count) {
    if (family_may_go(mesh, errors, first, count, frame, rules, history)) coarsen.push_back(parent);
  });
  std::sort(coarsen.begin(), coarsen.end());
  return coarsen;
}

/// The paper's rule, and what a body at rest does under any.
void mark_by_rate(const RefinementForest& forest, const Mesh& mesh, const FrameErrors& errors, int frame, int dofs,
                  const FrameAdaptRules& rules, const FrameAdaptHistory& history, FrameMarks& marks) {
  if (!errors.at_rest) {
    marks.refine = wanted_refinements(mesh, errors.estimate, errors.largest, rules);
    std::erase_if(marks.refine, [&](const Refinement& r) {
      return errors.rises[r.cell] != 1 || !forest.can_refine(mesh.forest_cell[r.cell], r.refinement);
    });
    if (rules.max_dofs > 0) keep_within_budget(mesh, errors.estimate.eta, rules.max_dofs - dofs, marks.refine);
  }
  marks.coarsen = families_to_coarsen(forest, mesh, errors, frame, rules, history);
}

void mark_by_tolerance(const RefinementForest& forest, const Mesh& mesh, const ErrorEstimate& estimate, int frame,
                       int dofs, const FrameAdaptRules& rules, const FrameAdaptHistory& history, FrameMarks& marks) {
  const std::vector<RefinementCandidate> candidates = refinement_candidates(forest, mesh, estimate, rules);
  const ToleranceLevels levels = tolerance_levels(estimate, candidates, rules);
  marks.refine = refine_to_tolerance(estimate, levels, candidates, rules);
  const std::size_t wanted = marks.refine.size();
  if (rules.max_dofs > 0) keep_within_budget(mesh, estimate.eta, rules.max_dofs - dofs, marks.refine);
  if (tolerance_ratio(estimate, rules) > 1.0) {
    if (marks.refine.size() < wanted)
      marks.limit = AdaptLimit::dofs;
    else if (!levels.reachable || local_tolerance_is_out_of_reach(estimate, candidates, rules))
      marks.limit = AdaptLimit::depth;
  }
  std::vector<std::uint8_t> marked(static_cast<std::size_t>(mesh.cell_count()), 0);
  for (const Refinement& r : marks.refine) marked[r.cell] = 1;
  marks.coarsen = coarsen_within_tolerance(forest, mesh, estimate, levels, marked, frame, rules, history);
}

void coarsen_family(int parent, int frame, RefinementForest& forest, FrameAdaptHistory& history) {
  const int first = forest.cell(parent).first_child, end = first + forest.cell(parent).refinement.child_count();
  double sum = 0.0;
  bool known = true, toggled = false;
  for (int child = first; child < end; ++child) {
    known = known && history.von_mises[child] >= 0.0;
    sum += history.von_mises[child];
    toggled = toggled || (!history.coarsened[child] && frame - history.changed[child] < history.toggle_window);
    clear_entry(history, child);
  }
  forest.coarsen(parent);
  set_entry(history, parent, known ? sum / (end - first) : -1.0, frame, true);
  history.toggles += toggled;
}

/// All below a cell that was a leaf, a level or two.
void enter_descendants(const RefinementForest& forest, int handle, double von_mises, int frame,
                       FrameAdaptHistory& history) {
  const int first = forest.cell(handle).first_child;
  for (int child = first; child < first + forest.cell(handle).refinement.child_count(); ++child) {
    if (forest.is_leaf(child)) {
      set_entry(history, child, von_mises, frame, false);
    } else {
      clear_entry(history, child);
      enter_descendants(forest, child, von_mises, frame, history);
    }
  }
}

}  // namespace

void check(const FrameAdaptRules& rules) {
  const auto not_negative = [](double x) { return x >= 0.0 && std::isfinite(x); };
  check_range("refine_above", rules.refine_above, rules.refine_above > 0.0 && rules.refine_above <= 1.0,
              "0 < refine_above <= 1");
  check_range("coarsen_below", rules.coarsen_below,
              rules.coarsen_below >= 0.0 && rules.coarsen_below <= rules.refine_above,
              "0 <= coarsen_below <= refine_above");
  check_range("tolerance", rules.tolerance, not_negative(rules.tolerance), ">= 0");
  check_range("local_tolerance", rules.local_tolerance, not_negative(rules.local_tolerance), ">= 0");
  check_range("refine_at", rules.refine_at, rules.refine_at > 0.0 && rules.refine_at <= 1.0, "0 < refine_at <= 1");
  check_range("coarsen_at", rules.coarsen_at, rules.coarsen_at >= 0.0 && rules.coarsen_at < rules.refine_at,
              "0 <= coarsen_at < refine_at");
  check_range("energy_floor", rules.energy_floor, not_negative(rules.energy_floor), ">= 0");
  check_range("dwell", rules.dwell, rules.dwell >= 0, ">= 0");
  check_range("every", rules.every, rules.every >= 1, ">= 1");
  check_range("release", rules.release, rules.release >= 0, ">= 0");
  check_range("max_depth", rules.max_depth, rules.max_depth >= 0, ">= 0");
  check_range("max_dofs", rules.max_dofs, rules.max_dofs >= 0, ">= 0");
  for (const int n : rules.refinement.divisions)
    check_range("refinement", n, n >= 1 && n <= max_divisions, "divisions 1 to 4");
  check_range("refinement", rules.refinement.child_count(), rules.refinement.child_count() > 1, "two children or more");
  if (!rules.directional && divides_by_four(rules.refinement))
    check_range("max_depth", rules.max_depth, rules.max_depth != 1, "0, or >= 2 for a division by 4");
}

double tolerance_ratio(const ErrorEstimate& estimate, const FrameAdaptRules& rules) {
  const auto ratio = [&](double error, double tolerance) {
    if (!(tolerance > 0.0) || !(error > 0.0)) return 0.0;
    return error / (tolerance * estimate.energy_norm);
  };
  const double largest = estimate.eta.size() > 0 ? estimate.eta.maxCoeff() : 0.0;
  return std::max(ratio(estimate.total, rules.tolerance), ratio(largest, rules.local_tolerance));
}

Eigen::VectorXd cell_von_mises(const Discretization& d, const Eigen::Matrix3Xd& u) {
  const Mesh& mesh = d.mesh;
  const Material& material = d.shapes.material();
  Eigen::VectorXd stress(mesh.cell_count());
  CellGeometry scratch;
  for (int cell = 0; cell < mesh.cell_count(); ++cell) {
    const CellGeometry& geometry = d.shapes.geometry(mesh, cell, scratch);
    CellVectors local = corner_values(mesh, cell, u);
    if (material.kinematics == Kinematics::corotational) {
      // Measured from a corner: a cell far from the origin keeps its digits.
      CellVectors X = corner_values(mesh, cell, mesh.nodes);
      for (int c = corner_count(mesh.shape) - 1; c >= 0; --c) X.col(c) -= X.col(0);
      const CellVectors x = X + local;
      local = cell_rotation(geometry, material, x).transpose().lazyProduct(x) - X;
    }
    // In the cell's own frame: von Mises stress does not turn.
    stress[cell] = von_mises(centre_stress(mesh.shape, geometry, material, Eigen::Matrix3d::Identity(), local));
  }
  return stress;
}

FrameMarks mark_frame(const RefinementForest& forest, const Mesh& mesh, const ErrorEstimate& estimate,
                      const Eigen::VectorXd& von_mises, int frame, int dofs, const FrameAdaptRules& rules,
                      FrameAdaptHistory& history) {
  check(rules);
  FrameMarks marks;
  if (!marks_in_frame(frame, rules)) return marks;
  assert(estimate.eta.size() == mesh.cell_count() && von_mises.size() == mesh.cell_count());
  assert(mesh.cell_count() == forest.leaf_count());
  const double largest = largest_square(estimate.eta, von_mises);
  resize(history, forest.handle_count());
  const FrameErrors errors{estimate, largest, rising_cells(mesh, von_mises, history),
                           square(estimate.energy_norm) < rules.energy_floor};

  if (asks_for_tolerance(rules) && !errors.at_rest)
    mark_by_tolerance(forest, mesh, estimate, frame, dofs, rules, history, marks);
  else
    mark_by_rate(forest, mesh, errors, frame, dofs, rules, history, marks);
  for (int cell = 0; cell < mesh.cell_count(); ++cell) history.von_mises[mesh.forest_cell[cell]] = von_mises[cell];
  return marks;
}

FrameChange adapt_forest(const Mesh& mesh, const FrameMarks& marks, int frame, RefinementForest& forest,
                         FrameAdaptHistory& history) {
  resize(history, forest.handle_count());
  FrameChange change;
  for (const int parent : marks.coarsen) {
    assert(forest.can_coarsen(parent));
    coarsen_family(parent, frame, forest, history);
    ++change.coarsened;
  }
  change.refined = apply_refinements(forest, mesh, marks.refine);
  resize(history, forest.handle_count());
  for (const Refinement& r : marks.refine) {
    const int handle = mesh.forest_cell[r.cell];
    if (forest.is_leaf(handle)) continue;  // the lattice forbade it
    history.toggles += history.coarsened[handle] && frame - history.changed[handle] < history.toggle_window;
    enter_descendants(forest, handle, history.von_mises[handle], frame, history);
    clear_entry(history, handle);
  }
  return change;
}

}  // namespace finegauge
