#include "verification/studies/reversibility.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "core/mesh/immersed_body.hpp"
#include "core/space/assembly.hpp"
#include "core/space/lumped_mass.hpp"
#include "core/tissue_step.hpp"
#include "verification/support/closed_surfaces.hpp"
#include "verification/support/conformity.hpp"
#include "verification/support/refinement_history.hpp"
#include "verification/support/sample_cells.hpp"
#include "verification/support/scrambled_mesh.hpp"

namespace finegauge {
namespace {

/// Bends and turns the body by some tenths, so that rotations of cells differ.
Eigen::Vector3d displacement_at(const Eigen::Vector3d& X) {
  return {0.3 * X.y() - 0.1 * X.z() * X.x(), -0.2 * X.x() + 0.1 * X.y() * X.y(), 0.25 * X.x() * X.y() - 0.1 * X.z()};
}

/// [N/m³]
Eigen::Vector3d force_at(const Eigen::Vector3d& X) { return {1.0 + X.y(), X.z() * X.x(), -2.0}; }

template <class Function>
Eigen::Matrix3Xd at_nodes(const Mesh& mesh, const Function& function) {
  Eigen::Matrix3Xd values(3, mesh.node_count());
  for (int node = 0; node < mesh.node_count(); ++node) values.col(node) = function(mesh.nodes.col(node));
  return values;
}

double diameter(const BaseMesh& base) {
  return (base.nodes.rowwise().maxCoeff() - base.nodes.rowwise().minCoeff()).norm();
}

/// Cells of the forest, inner ones too, that are in use.
int cells_in_use(const RefinementForest& forest) {
  int cells = static_cast<int>(forest.base().cells.size());
  for (const RecipeStep& step : recipe_of(forest)) cells += step.refinement.child_count();
  return cells;
}

bool same_rows(const HangingNodes& a, const HangingNodes& b) {
  return a.row_start == b.row_start && a.master == b.master && a.weight == b.weight && a.reduced_of == b.reduced_of &&
         a.node_of == b.node_of && a.longest_chain == b.longest_chain;
}

/// Nodes of the coarse mesh that do not hang there, and do on the finer one.
int came_to_hang(const Discretization& coarse, const Discretization& fine) {
  std::map<std::pair<std::uint64_t, LatticePoint>, int> number;
  for (int node = 0; node < fine.mesh.node_count(); ++node)
    number[{fine.mesh.identities[node].entity, fine.mesh.identities[node].at}] = node;
  int count = 0;
  for (const int node : coarse.hanging.node_of)
    count += fine.hanging.hangs(number.at({coarse.mesh.identities[node].entity, coarse.mesh.identities[node].at}));
  return count;
}

std::string numbered(const std::string& what, std::size_t operation) {
  return what + " after operation " + std::to_string(operation);
}

/// In one line.
std::string replayable(const std::string& statement, const HistoryBody& body,
                       const Counterexample<ForestOperation>& found) {
  std::string text = statement + ", " + body.name + ", history " + std::to_string(found.seed) + ": " + found.fault +
                     "; " + std::to_string(found.drawn.size()) + " operations shrunk to:";
  for (const ForestOperation& operation : found.history) text += ' ' + to_text(operation) + ';';
  return text;
}

Material turning_material() {
  Material material;
  material.dilatation = Dilatation::mean;
  material.kinematics = Kinematics::corotational;
  return material;
}

void widen(InterpolationErrors& worst, const InterpolationErrors& next) {
  worst.row_sum = larger_error(worst.row_sum, next.row_sum);
  worst.linear = larger_error(worst.linear, next.linear);
  worst.conformity = larger_error(worst.conformity, next.conformity);
  worst.chains += next.chains;
  worst.lost += next.lost;
  worst.hanging = std::max(worst.hanging, next.hanging);
  worst.longest_chain = std::max(worst.longest_chain, next.longest_chain);
}

std::string fault_of(const InterpolationErrors& errors) {
  const auto beyond = [](double error) { return !(error <= interpolation_round_off); };
  if (errors.chains > 0) return "a row of T names a node that hangs, or is not the node itself";
  if (errors.lost > 0) return "gather does not bring back what was expanded";
  if (beyond(errors.row_sum)) return "a row of T does not sum to one";
  if (beyond(errors.linear)) return "T does not reproduce a linear field";
  if (beyond(errors.conformity)) return "a field of T jumps between leaves";
  return {};
}

}  // namespace

std::vector<HistoryBody> history_bodies() {
  std::mt19937 generator(2024);
  const SurfaceLoad pull{"x_max", LoadKind::total_by_area, {0.5, 1.0, -2.0}};
  const SupportCondition held{"x_min", std::nullopt, {}, {}};
  BoxMeshOptions box;
  box.cells = {2, 2, 1};
  box.size = {1.5, 1.0, 0.8};
  std::vector<HistoryBody> bodies;
  bodies.push_back({"box", 1000, box_mesh(box), {held}, {pull}});
  bodies.push_back({"scrambled", 2000, scrambled(distorted_box(box, 0.2, generator), generator), {held}, {pull}});
  bodies.push_back({"patch", 3000, macneal_harder_patch(), {{"outside", Eigen::Vector3d(1.0, 2.0, 2.0), {}, {}}}, {}});
  box.cells = {1, 1, 1};
  box.shape = CellShape::tetrahedron;
  bodies.push_back({"tetrahedra", 4000, scrambled(distorted_box(box, 0.2, generator), generator), {held}, {pull}});
  HistoryBody cut{"cut", 5000, {}, {{"left", std::nullopt, {}, {}}}, {}};
  cut.base = immersed_mesh(closed_torus(0.3, 0.11, 24, 12, {0.01, 0.02, 0.03}), {{0.21, 0.22, 0.25}, {}});
  for (int node = 0; node < cut.base.nodes.cols(); ++node)
    if (cut.base.nodes(0, node) < -0.1) cut.base.regions["left"].push_back(node);
  bodies.push_back(std::move(cut));
  return bodies;
}

ForestHistory drawn_history(const HistoryBody& body, std::uint32_t number) {
  const std::vector<RefinementTemplate> templates = all_templates(body.base.shape);
  return random_history(body.base, {templates, 24, 0.3, 4, 220}, body.seed + number);
}

MeshImprint imprint(const RefinementForest& forest, const HistoryBody& body) {
  Discretization d = discretize(forest, turning_material(), body.supports);
  MeshImprint result;
  const BlockMatrix<double> K = assemble_stiffness(d, at_nodes(d.mesh, displacement_at));
  result.stiffness = Eigen::Map<const Eigen::VectorXd>(K.values.data(), static_cast<Eigen::Index>(K.values.size()));
  result.loads = nodal_loads(forest.base(), d.mesh, body.loads, force_at);
  result.mass = lumped_mass(d, 1000.0);
  result.pattern = std::move(d.pattern.column);
  result.held = std::move(d.supports.reduced);
  result.T = std::move(d.hanging);
  result.mesh = std::move(d.mesh);
  return result;
}

std::string difference(const MeshImprint& a, const MeshImprint& b, bool handles) {
  if (!same_bits(a.mesh, b.mesh)) return "the mesh differs";
  if (handles && a.mesh.forest_cell != b.mesh.forest_cell) return "the handles differ";
  if (!same_rows(a.T, b.T)) return "T differs";
  if (a.pattern != b.pattern || a.held != b.held) return "the matrix's pattern or the supports differ";
  if (!same_bits(a.stiffness, b.stiffness)) return "the stiffness differs";
  if (!same_bits(a.loads, b.loads)) return "the loads differ";
  if (!same_bits(a.mass, b.mass)) return "the masses differ";
  return {};
}

std::string fault_in_return(const HistoryBody& body, const ForestHistory& history) {
  RefinementForest forest(body.base);
  const MeshImprint start = imprint(forest, body);
  MeshImprint middle;
  std::vector<Mesh> before;
  ForestHistory undo;
  for (std::size_t k = 0; k < history.size(); ++k) {
    const ForestOperation back = inverse(history[k], forest);
    Mesh mesh = forest.leaf_mesh();
    if (!perform(history[k], forest)) continue;
    before.push_back(std::move(mesh));
    undo.push_back(back);
    if (undo.size() == (history.size() + 1) / 2) middle = imprint(forest, body);
  }
  if (const std::string fault = validate(forest); !fault.empty()) return fault;
  for (std::size_t k = undo.size(); k > 0; --k) {
    if (k == (history.size() + 1) / 2)
      if (const std::string fault = difference(middle, imprint(forest, body)); !fault.empty())
        return numbered(fault, k) + ", come back to";
    if (!perform(undo[k - 1], forest)) return numbered("what was done cannot be undone", k);
    if (!same_bits(forest.leaf_mesh(), before[k - 1])) return numbered("another mesh came back", k - 1);
  }
  if (const std::string fault = difference(start, imprint(forest, body), true); !fault.empty())
    return fault + " at the start, undone one by one";
  std::mt19937 generator(7);
  for (int order = 0; order < 2; ++order) {
    perform(history, forest);
    coarsen_randomly(forest, {}, generator);
    if (const std::string fault = validate(forest); !fault.empty()) return fault;
    if (const std::string fault = difference(start, imprint(forest, body), true); !fault.empty())
      return fault + " at the start, all coarsened";
  }
  return {};
}

std::string fault_in_order(const HistoryBody& body, const ForestHistory& history) {
  RefinementForest forest(body.base), straight(body.base);
  perform(history, forest);
  const std::vector<RecipeStep> recipe = recipe_of(forest);
  for (const RecipeStep& step : recipe)
    if (!perform({step.path, step.refinement}, straight)) return "what a history left cannot be refined afresh";
  const MeshImprint expected = imprint(straight, body);
  if (const std::string fault = difference(expected, imprint(forest, body)); !fault.empty())
    return fault + " from that of the refinements alone";
  std::mt19937 generator(11);
  for (int order = 0; order < 2; ++order) {
    const RefinementForest other = replay(body.base, recipe, generator);
    if (const std::string fault = difference(expected, imprint(other, body)); !fault.empty())
      return fault + " in another order";
  }
  return {};
}

InterpolationErrors interpolation_errors(const RefinementForest& forest, const Mesh& mesh, bool conformity) {
  const HangingNodes T = find_hanging_nodes(forest, mesh);
  InterpolationErrors errors;
  errors.hanging = T.hanging_count();
  errors.longest_chain = T.longest_chain;
  const double size = diameter(forest.base());
  for (int node = 0; node < mesh.node_count(); ++node) {
    const int first = T.row_start[node], last = T.row_start[node + 1];
    double sum = -1.0;
    Eigen::Vector3d linear = -mesh.nodes.col(node);
    for (int k = first; k < last; ++k) {
      if (T.master[k] < 0) {  // the number of a node that hangs
        ++errors.chains;
        continue;
      }
      const int master = T.node_of[T.master[k]];
      sum += T.weight[k];
      linear += T.weight[k] * mesh.nodes.col(master);
    }
    errors.chains += !T.hangs(node) && (last != first + 1 || T.master[first] != T.reduced_of[node]);
    errors.row_sum = larger_error(errors.row_sum, std::abs(sum));
    errors.linear = larger_error(errors.linear, linear.norm() / size);
  }
  if (errors.chains > 0) return errors;  // nothing can be expanded
  std::mt19937 generator(17);
  Eigen::VectorXd reduced(3 * T.reduced_count());
  for (double& value : reduced) value = random_number(generator);
  const Eigen::Matrix3Xd nodal = expand(T, reduced);
  errors.lost = static_cast<int>((gather(T, nodal).array() != reduced.array()).count());
  if (conformity) errors.conformity = largest_jump(forest, mesh, nodal, 4, 23);
  return errors;
}

std::string fault_in_interpolation(const HistoryBody& body, const ForestHistory& history) {
  RefinementForest forest(body.base);
  for (std::size_t k = 0; k < history.size(); ++k) {
    if (!perform(history[k], forest)) continue;
    const InterpolationErrors errors = interpolation_errors(forest, forest.leaf_mesh(), k + 1 == history.size());
    if (const std::string fault = fault_of(errors); !fault.empty()) return numbered(fault, k + 1);
  }
  return {};
}

HistoryRow try_histories(const HistoryBody& body, std::span<const std::uint32_t> numbers) {
  HistoryRow row;
  row.body = body.name;
  std::set<RefinementTemplate> templates;
  for (const std::uint32_t number : numbers) {
    const ForestHistory history = drawn_history(body, number);
    ++row.histories;
    row.operations += static_cast<int>(history.size());
    RefinementForest forest(body.base);
    for (std::size_t k = 0; k < history.size(); ++k) {
      row.coarsenings += !history[k].refinement;
      if (history[k].refinement) templates.insert(*history[k].refinement);
      perform(history[k], forest);
      const Mesh mesh = forest.leaf_mesh();
      for (const LeafFrame& frame : mesh.frames) row.deepest = std::max(row.deepest, frame.depth);
      row.most_leaves = std::max(row.most_leaves, mesh.cell_count());
      widen(row.worst, interpolation_errors(forest, mesh, k + 1 == history.size()));
    }
  }
  row.templates.assign(templates.begin(), templates.end());
  const auto broken = [&](const std::string& statement,
                          std::string (*fault)(const HistoryBody&, const ForestHistory&)) {
    const auto check = check_property<ForestOperation>(
        numbers, [&](std::uint32_t number) { return drawn_history(body, number); },
        [&](const ForestHistory& history) { return fault(body, history); });
    if (!check.counterexample) return 0;
    row.counterexamples.push_back(replayable(statement, body, *check.counterexample));
    return 1;
  };
  row.broken_interpolations = broken("interpolation", fault_in_interpolation);
  if (row.worst.chains > 0) return row;  // nothing can be built on such a T
  row.broken_returns = broken("return", fault_in_return);
  row.broken_orders = broken("order", fault_in_order);
  return row;
}

NullSpaceRow null_space(const HistoryBody& body, std::span<const std::uint32_t> seeds) {
  constexpr double rigid_share = 1e-11;
  NullSpaceRow row;
  row.body = body.name;
  row.fewest_modes = 1 << 20;
  const std::vector<RefinementTemplate> templates = all_templates(body.base.shape);
  for (const std::uint32_t seed : seeds) {
    RefinementForest forest(body.base);
    const int few = static_cast<int>(body.base.cells.size()) + 24;
    perform(random_history(body.base, {templates, 5, 0.2, 2, few}, body.seed + seed), forest);
    const Discretization d = discretize(forest, Material{}, {});
    const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
    const Eigen::SparseMatrix<double> T = interpolation_matrix(d.hanging);
    const Eigen::MatrixXd A = (T.transpose() * nodal_stiffness(d, rest) * T).toDense();
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
    const double largest = values.maxCoeff();
    const int modes = static_cast<int>((values.array() < rigid_share * largest).count());
    ++row.meshes;
    row.most_dofs = std::max(row.most_dofs, d.dof_count());
    row.most_hanging = std::max(row.most_hanging, d.hanging.hanging_count());
    row.fewest_modes = std::min(row.fewest_modes, modes);
    row.most_modes = std::max(row.most_modes, modes);
    row.largest_zero = larger_error(row.largest_zero, std::abs(values[5]) / largest);
    row.smallest_stiff = -larger_error(-row.smallest_stiff, -values[6] / largest);
    for (int motion = 0; motion < 6; ++motion) {
      const Eigen::Vector3d axis = Eigen::Vector3d::Unit(motion % 3);
      const Eigen::VectorXd r = gather(d.hanging, at_nodes(d.mesh, [&](const Eigen::Vector3d& X) -> Eigen::Vector3d {
                                         return motion < 3 ? axis : axis.cross(X);
                                       }));
      row.rigid_force = larger_error(row.rigid_force, (A * r).norm() / (largest * r.norm()));
    }
    const Eigen::MatrixXd assembled = to_sparse(assemble_stiffness(d, rest)).toDense();
    row.assembly_error =
        larger_error(row.assembly_error, (assembled - A).cwiseAbs().maxCoeff() / A.cwiseAbs().maxCoeff());
  }
  return row;
}

RoundTrip drawn_round_trip(const HistoryBody& body, std::span<const RefinementTemplate> templates, std::uint32_t seed) {
  RoundTrip trip{random_history(body.base, {templates, 12, 0.2, 3, 160}, body.seed + seed), {}};
  BaseMesh lattice = body.base;
  lattice.body.reset();
  RefinementForest ahead(std::move(lattice));
  perform(trip.start, ahead);
  std::mt19937 generator(seed);
  while (trip.there.size() < 10) {
    const std::vector<int> all = leaves(ahead);
    int leaf = all[generator() % all.size()];
    if (const int other = all[generator() % all.size()]; ahead.cell(other).depth > ahead.cell(leaf).depth) leaf = other;
    const ForestOperation next{path_of(ahead, leaf), templates[generator() % templates.size()]};
    if (perform(next, ahead)) trip.there.push_back(next);
  }
  return trip;
}

RoundTrip box_with_a_node_that_comes_to_hang() {
  return {parse_history("refine 0 2x4x3\nrefine 0/22 4x2x3\nrefine 0/14 4x4x1"), parse_history("refine 0/14/2 3x3x3")};
}

RoundTrip patch_with_a_node_that_comes_to_hang() {
  return {parse_history("refine 4 4x3x3\nrefine 4/10 2x2x4\nrefine 4/10/0 2x4x1\nrefine 4/10/4 4x2x4\n"
                        "refine 4/10/0/4 2x3x4\nrefine 4/10/9 4x3x2"),
          parse_history("refine 4/10/0/0 2x2x2")};
}

RoundTripRow make_round_trips(const HistoryBody& body, const std::string& what, const std::vector<RoundTrip>& cases,
                              int trips) {
  RoundTripRow row;
  row.body = body.name;
  row.what = what;
  row.cases = static_cast<int>(cases.size());
  row.trips = trips;
  const TissueProblem problem;
  std::mt19937 generator(5);
  double change_of_v = 0.0, size_of_v = 0.0;
  for (const RoundTrip& the_case : cases) {
    RefinementForest forest(body.base);
    perform(the_case.start, forest);
    TissueMesh mesh = build_tissue_mesh(forest, problem);
    const TissueMesh start = mesh;
    const auto random_field = [&] {
      Eigen::VectorXd reduced(start.d.dof_count());
      for (double& value : reduced) value = random_number(generator);
      return expand(start.d.hanging, reduced);
    };
    const Eigen::Matrix3Xd u = random_field(), v = random_field();
    TissueState state{u, v};
    const auto carry = [&](const ForestOperation& operation) {
      perform(operation, forest);
      TissueMesh next = build_tissue_mesh(forest, problem);
      TransferLedger ledger;
      state = transfer_state(mesh, state, next, &ledger);
      mesh = std::move(next);
      row.momentum = larger_error(row.momentum, ledger.momentum_change);
    };
    const double kinetic = tissue_energy(mesh, state).kinetic;
    for (int trip = 0; trip < trips; ++trip) {
      for (const ForestOperation& operation : the_case.there) carry(operation);
      if (trip == 0) row.came_to_hang += came_to_hang(start.d, mesh.d);
      for (auto done = the_case.there.rbegin(); done != the_case.there.rend(); ++done) carry({done->path, {}});
      row.drift =
          larger_error(row.drift, (state.u - u).cwiseAbs().maxCoeff<Eigen::PropagateNaN>() / u.cwiseAbs().maxCoeff());
      if (trip > 0) continue;
      row.largest_change = row.drift;
      row.kinetic_growth = larger_error(row.kinetic_growth, tissue_energy(mesh, state).kinetic / kinetic - 1.0);
      change_of_v += (state.v - v).squaredNorm();
      size_of_v += v.squaredNorm();
    }
    row.values += static_cast<int>(u.size());
    row.changed += static_cast<int>((state.u.array() != u.array()).count());
  }
  row.velocity_change = std::sqrt(change_of_v / size_of_v);
  return row;
}

StorageRow storage(const HistoryBody& body, int cycles) {
  StorageRow row;
  row.body = body.name;
  row.cycles = cycles;
  BaseMesh lattice = body.base;
  lattice.body.reset();  // what fills the cells takes no storage, but an integral a child
  const int base_cells = static_cast<int>(lattice.cells.size());
  std::mt19937 generator(3);
  int peak = 0, peak_in_use = 0;
  const auto cycle = [&](RefinementForest& forest, const ForestHistory& history) {
    peak = 0;
    for (const ForestOperation& operation : history) {
      perform(operation, forest);
      peak = std::max(peak, forest.handle_count());
      peak_in_use = std::max(peak_in_use, cells_in_use(forest));
    }
    coarsen_randomly(forest, {}, generator);
  };
  const ForestHistory same = drawn_history(body, 1);
  RefinementForest forest(lattice);
  for (int k = 0; k < cycles; ++k) {
    cycle(forest, same);
    if (k == 0) row.first_bytes = static_cast<double>(forest.storage_bytes());
    if (k == 0) row.first_peak = peak;
  }
  row.last_bytes = static_cast<double>(forest.storage_bytes());
  row.last_peak = peak;
  row.left = forest.handle_count() - base_cells;
  // A refined place that wanders through the body, as that of a needle does: of other templates in each cell, and never
  // is all of it coarsened, so that what ends the storage cannot be given back.
  RefinementForest wandered(lattice);
  const std::vector<RefinementTemplate> templates = all_templates(lattice.shape);
  const auto draw = [&] { return templates[generator() % templates.size()]; };
  int highest = 0;
  peak_in_use = 0;
  for (int step = 0; step < 10 * cycles; ++step) {
    const int cell = step % base_cells, last = (step + base_cells - 1) % base_cells;
    wandered.refine(cell, draw());
    wandered.refine(wandered.cell(cell).first_child, draw());
    highest = std::max(highest, wandered.handle_count());
    peak_in_use = std::max(peak_in_use, cells_in_use(wandered));
    if (wandered.is_leaf(last)) continue;
    wandered.coarsen(wandered.cell(last).first_child);
    wandered.coarsen(last);
  }
  row.fragmentation = static_cast<double>(highest) / peak_in_use;
  return row;
}

std::vector<ShrinkRow> shrink_broken_statements(const HistoryBody& body, std::span<const std::uint32_t> numbers) {
  std::vector<ShrinkRow> rows;
  const auto shrunk = [&](const std::string& statement, const ForestHistory& history, int expected,
                          const Property<ForestOperation>& property) -> ForestHistory {
    if (property(history).empty()) return {};  // a history that does not show it
    const Counterexample<ForestOperation> found = shrink(history, property);
    ShrinkRow row{.statement = statement, .expected = expected, .history = to_text(found.history)};
    row.drawn = static_cast<int>(history.size());
    row.shrunk = static_cast<int>(found.history.size());
    row.runs = found.runs;
    for (std::size_t k = 0; k < found.history.size(); ++k) {
      ForestHistory shorter = found.history;
      shorter.erase(shorter.begin() + static_cast<std::ptrdiff_t>(k));
      row.spare += !property(shorter).empty();
    }
    row.replays = property(parse_history(row.history)) == found.fault;
    std::ranges::replace(row.history, '\n', ';');
    rows.push_back(row);
    return found.history;
  };
  for (const std::uint32_t number : numbers) {
    const ForestHistory history = drawn_history(body, number);
    // Two given operations, one before the other.
    const ForestHistory given = {history[history.size() / 4], history[3 * history.size() / 4]};
    const ForestHistory left = shrunk("no history does these two", history, 2, [&](const ForestHistory& some) {
      const auto first = std::ranges::find(some, given[0]);
      return first != some.end() && std::find(first + 1, some.end(), given[1]) != some.end() ? "both are there" : "";
    });
    rows.back().is_right = left == given;  // every history has its own operations
    // The forest itself decides: each level rests on the one before.
    shrunk("no leaf is three levels deep", history, 3, [&](const ForestHistory& some) -> std::string {
      RefinementForest forest(body.base);
      perform(some, forest);
      for (const int leaf : leaves(forest))
        if (forest.cell(leaf).depth >= 3) return "one is";
      return {};
    });
    // What RefinementForest does not promise of itself.
    shrunk("handles do not depend on the order", history, 0, [&](const ForestHistory& some) -> std::string {
      RefinementForest forest(body.base), straight(body.base);
      perform(some, forest);
      for (const RecipeStep& step : recipe_of(forest)) perform({step.path, step.refinement}, straight);
      return forest.leaf_mesh().forest_cell == straight.leaf_mesh().forest_cell ? "" : "they do";
    });
  }
  return rows;
}

}  // namespace finegauge
