#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <set>

#include "verification/studies/reversibility.hpp"
#include "verification/support/refinement_history.hpp"

namespace finegauge {
namespace {

EvidenceTable table_of(const std::vector<HistoryRow>& rows) {
  EvidenceTable table{"Random histories of refinements and coarsenings",
                      {"body", "histories", "operations", "coarsenings", "templates", "leaves", "depth", "hanging",
                       "chain", "row sum", "linear", "jump"},
                      {}};
  for (const HistoryRow& row : rows)
    table.rows.push_back({row.body, 1.0 * row.histories, 1.0 * row.operations, 1.0 * row.coarsenings,
                          1.0 * static_cast<double>(row.templates.size()), 1.0 * row.most_leaves, 1.0 * row.deepest,
                          1.0 * row.worst.hanging, 1.0 * row.worst.longest_chain, row.worst.row_sum, row.worst.linear,
                          row.worst.conformity});
  return table;
}

EvidenceTable table_of(const std::vector<NullSpaceRow>& rows) {
  EvidenceTable table{
      "Tᵀ K T without supports: eigenvalues over the largest",
      {"body", "meshes", "dofs", "hanging", "modes", "sixth", "seventh", "rigid force", "against assembly"},
      {}};
  for (const NullSpaceRow& row : rows) {
    const std::string modes = std::to_string(row.fewest_modes) + " to " + std::to_string(row.most_modes);
    table.rows.push_back({row.body, 1.0 * row.meshes, 1.0 * row.most_dofs, 1.0 * row.most_hanging, modes,
                          row.largest_zero, row.smallest_stiff, row.rigid_force, row.assembly_error});
  }
  return table;
}

EvidenceTable table_of(const std::vector<RoundTripRow>& rows) {
  EvidenceTable table{"A state carried to finer meshes and back",
                      {"body", "templates", "cases", "trips", "values of u", "came to hang", "changed",
                       "after one trip", "after all", "momentum", "kinetic growth", "change of v"},
                      {}};
  for (const RoundTripRow& row : rows)
    table.rows.push_back({row.body, row.what, 1.0 * row.cases, 1.0 * row.trips, 1.0 * row.values,
                          1.0 * row.came_to_hang, 1.0 * row.changed, row.largest_change, row.drift, row.momentum,
                          row.kinetic_growth, row.velocity_change});
  return table;
}

EvidenceTable table_of(const std::vector<StorageRow>& rows) {
  EvidenceTable table{
      "Storage of the forest after cycles of refining and coarsening everything",
      {"body", "cycles", "bytes after 1", "after all", "handles in 1", "in the last", "left", "fragmentation"},
      {}};
  for (const StorageRow& row : rows)
    table.rows.push_back({row.body, 1.0 * row.cycles, row.first_bytes, row.last_bytes, 1.0 * row.first_peak,
                          1.0 * row.last_peak, 1.0 * row.left, row.fragmentation});
  return table;
}

EvidenceTable table_of(const std::vector<ShrinkRow>& rows) {
  EvidenceTable table{
      "Statements that are false on purpose", {"statement", "operations", "shrunk to", "runs", "what is left"}, {}};
  for (const ShrinkRow& row : rows)
    table.rows.push_back({row.statement, 1.0 * row.drawn, 1.0 * row.shrunk, 1.0 * row.runs, row.history});
  return table;
}

template <class Row, class Value>
double largest_of(const std::vector<Row>& rows, const Value& value) {
  double largest = -std::numeric_limits<double>::infinity();
  for (const Row& row : rows) largest = larger_error(largest, static_cast<double>(value(row)));
  return largest;
}
template <class Row, class Value>
double smallest_of(const std::vector<Row>& rows, const Value& value) {
  return -largest_of(rows, [&](const Row& row) { return -static_cast<double>(value(row)); });
}

void claim_histories(const std::vector<HistoryRow>& rows, Evidence& evidence) {
  EvidenceTable counterexamples{"Histories that break a statement, shrunk", {"counterexample"}, {}};
  int returns = 0, orders = 0, interpolations = 0;
  std::set<RefinementTemplate> templates;
  for (const HistoryRow& row : rows) {
    returns += row.broken_returns;
    orders += row.broken_orders;
    interpolations += row.broken_interpolations;
    templates.insert(row.templates.begin(), row.templates.end());
    for (const std::string& text : row.counterexamples) counterexamples.rows.push_back({text});
  }
  if (!counterexamples.rows.empty()) evidence.tables.push_back(counterexamples);
  const auto all = static_cast<double>(all_templates().size());
  evidence.claim("templates_tried", static_cast<double>(templates.size()), all, all, "every one that there is");
  evidence.claim("least_of_the_greatest_depths", smallest_of(rows, [](const HistoryRow& row) { return row.deepest; }),
                 4, 4, "as deep as histories are drawn, on every body");
  evidence.claim("least_of_the_longest_chains",
                 smallest_of(rows, [](const HistoryRow& row) { return row.worst.longest_chain; }), 2, 15,
                 "hanging nodes whose masters hang, on every body; 15 is what five nested levels have");
  const std::string exact = "nodes are found by whole numbers, and all is computed in the mesh's order";
  evidence.claim("bodies_that_do_not_return_bit_by_bit", returns, 0, 0, exact);
  evidence.claim("bodies_that_remember_the_order", orders, 0, 0, exact);
  evidence.claim("bodies_where_T_breaks_a_promise", interpolations, 0, 0, "no error beyond those that follow");
  const std::string some_terms = "some dozens of terms no larger than one, through chains of up to nine levels";
  const auto bounded = [&](const std::string& name, const auto& value) {
    evidence.claim(name, largest_of(rows, value), 0.0, interpolation_round_off, some_terms);
  };
  bounded("error_of_row_sums", [](const HistoryRow& row) { return row.worst.row_sum; });
  bounded("error_of_linear_fields", [](const HistoryRow& row) { return row.worst.linear; });
  bounded("jump_of_conforming_fields", [](const HistoryRow& row) { return row.worst.conformity; });
  evidence.claim("rows_with_chains", largest_of(rows, [](const HistoryRow& row) { return row.worst.chains; }), 0, 0,
                 "chains are resolved when T is built");
  evidence.claim("values_lost_in_gather_expand", largest_of(rows, [](const HistoryRow& row) { return row.worst.lost; }),
                 0, 0, "the row of a node that does not hang is the node itself, its weight one");
}

void claim_null_spaces(const std::vector<NullSpaceRow>& rows, Evidence& evidence) {
  constexpr double round_off = std::numeric_limits<double>::epsilon();
  const double dofs = largest_of(rows, [](const NullSpaceRow& row) { return row.most_dofs; });
  const std::string rigid = "T reproduces linear fields, so rigid motions and, of cells joined by faces, nothing else";
  evidence.claim("fewest_modes", smallest_of(rows, [](const NullSpaceRow& row) { return row.fewest_modes; }), 6, 6,
                 rigid);
  evidence.claim("most_modes", largest_of(rows, [](const NullSpaceRow& row) { return row.most_modes; }), 6, 6, rigid);
  evidence.claim("sixth_eigenvalue", largest_of(rows, [](const NullSpaceRow& row) { return row.largest_zero; }), 0.0,
                 dofs * round_off, "dofs times round-off: the eigenvalue solver is backward stable");
  evidence.claim("seventh_eigenvalue", smallest_of(rows, [](const NullSpaceRow& row) { return row.smallest_stiff; }),
                 1e-5, 0.5, "(cell/body)² for cells of a sixteenth, times the hundredth that cut cells keep");
  evidence.claim("force_of_rigid_motions", largest_of(rows, [](const NullSpaceRow& row) { return row.rigid_force; }),
                 0.0, 100 * round_off, "sums of some hundred terms");
  evidence.claim("explicit_product_against_assembly",
                 largest_of(rows, [](const NullSpaceRow& row) { return row.assembly_error; }), 0.0, 100 * round_off,
                 "the same sums of some dozen terms in another order");
}

void claim_round_trips(const std::vector<RoundTripRow>& rows, Evidence& evidence) {
  constexpr double round_off = std::numeric_limits<double>::epsilon();
  int changed = 0, rounded = 0, most_trips = 0;
  double momentum = 0.0, growth = -1.0;
  for (const RoundTripRow& row : rows) {
    (row.came_to_hang == 0 ? changed : rounded) += row.changed;
    most_trips = std::max(most_trips, row.trips);
    momentum = larger_error(momentum, row.momentum);
    if (row.body == "cut" || row.what != "2x2x2") continue;
    growth = larger_error(growth, row.kinetic_growth);
  }
  evidence.claim("displacements_changed_where_no_node_comes_to_hang", changed, 0, 0, "copied both ways");
  evidence.claim(
      "displacements_changed_where_one_does", rounded, 0, 100,
      "round-off, where there are any; with the largest coefficient as pivot the two cases made for it have none");
  evidence.claim("change_of_displacements_after_a_trip",
                 largest_of(rows, [](const RoundTripRow& row) { return row.largest_change; }), 0.0, 100 * round_off,
                 "a row of T, and an interpolation, of some dozens of terms of order one");
  evidence.claim("drift_of_displacements", largest_of(rows, [](const RoundTripRow& row) { return row.drift; }), 0.0,
                 (100 + most_trips) * round_off, "the same once, and a unit of round-off more on every trip");
  evidence.claim(
      "change_of_momentum", momentum, 0.0, 100 * round_off,
      "shared where the coarse mass is not the adjoint interpolation of the fine one; sums of some hundred terms");
  evidence.claim("growth_of_kinetic_energy", growth, -1.0, 100 * round_off,
                 "2x2x2 on full cells: velocities become means of what they were (Jensen)");
}

void claim_storage(const std::vector<StorageRow>& rows, Evidence& evidence) {
  const std::string again = "the same cycle finds the same holes";
  evidence.claim("growth_of_storage",
                 largest_of(rows, [](const StorageRow& row) { return row.last_bytes / row.first_bytes; }), 1, 1, again);
  evidence.claim("growth_of_handles",
                 largest_of(rows, [](const StorageRow& row) { return 1.0 * row.last_peak / row.first_peak; }), 1, 1,
                 again);
  evidence.claim("handles_left", largest_of(rows, [](const StorageRow& row) { return row.left; }), 0, 0,
                 "what ends the storage is given back");
  evidence.claim("fragmentation", largest_of(rows, [](const StorageRow& row) { return row.fragmentation; }), 1, 6,
                 "first fit needs log2 of the largest block times what is in use (Robson 1977), 6 for blocks of 64");
}

void claim_shrinking(const std::vector<ShrinkRow>& rows, Evidence& evidence) {
  int beside = 0, spare = 0, wrong = 0;
  const auto statements =
      static_cast<double>(std::ranges::count_if(rows, [](const ShrinkRow& row) { return row.expected > 0; }));
  for (const ShrinkRow& row : rows) {
    if (row.expected > 0) beside += std::abs(row.shrunk - row.expected);
    spare += row.spare;
    wrong += !row.replays || !row.is_right;
  }
  evidence.claim("histories_shrunk_to_what_is_known", statements, 4, 1000,
                 "three to thirty of each kind, as they show it");
  evidence.claim("operations_beside_those_that_break_a_statement", beside, 0, 0, "two given ones, three nested levels");
  evidence.claim("operations_that_could_be_left_out", spare, 0, 0, "shrinking ends when each one is needed");
  evidence.claim("shrunk_histories_that_are_others_or_do_not_replay", wrong, 0, 0,
                 "the two that were put in; text is read back");
}

}  // namespace

Evidence reversibility_evidence(const EvidenceOptions& options) {
  Evidence evidence;
  const std::vector<HistoryBody> bodies = history_bodies();
  std::vector<std::uint32_t> numbers(options.full ? 100 : 8);
  std::iota(numbers.begin(), numbers.end(), 1u);
  const std::vector<std::uint32_t> few(numbers.begin(), numbers.begin() + (options.full ? 30 : 3));
  std::vector<HistoryRow> histories;
  std::vector<NullSpaceRow> spaces;
  std::vector<RoundTripRow> trips;
  std::vector<StorageRow> storages;
  for (std::size_t k = 0; k < bodies.size() && !options.interrupted(); ++k) {
    const HistoryBody& body = bodies[k];
    options.progress(static_cast<double>(k) / static_cast<double>(bodies.size()), body.name);
    histories.push_back(try_histories(body, numbers));
    if (histories.back().worst.chains > 0) break;
    spaces.push_back(null_space(body, few));
    const auto make_trips = [&](const std::string& what, const std::vector<RefinementTemplate>& templates) {
      std::vector<RoundTrip> cases;
      for (const std::uint32_t seed : few) cases.push_back(drawn_round_trip(body, templates, seed));
      trips.push_back(make_round_trips(body, what, cases, 5));
    };
    make_trips("2x2x2", {{{2, 2, 2}}});
    if (body.base.shape == CellShape::hexahedron) make_trips("all", all_templates());
    // With many fields each: a rounding may happen to hit the number itself.
    if (body.name == "box")
      trips.push_back(make_round_trips(body, "exception", std::vector(20, box_with_a_node_that_comes_to_hang()), 50));
    if (body.name == "patch")
      trips.push_back(make_round_trips(body, "exception", std::vector(5, patch_with_a_node_that_comes_to_hang()), 50));
    storages.push_back(storage(body, options.full ? 1000 : 100));
  }
  evidence.tables = {table_of(histories), table_of(spaces), table_of(trips), table_of(storages)};
  if (options.interrupted()) return evidence;
  claim_histories(histories, evidence);
  if (storages.size() < bodies.size()) return evidence;
  claim_null_spaces(spaces, evidence);
  claim_round_trips(trips, evidence);
  claim_storage(storages, evidence);
  const std::vector<ShrinkRow> shrunk = shrink_broken_statements(bodies.front(), few);
  evidence.tables.push_back(table_of(shrunk));
  claim_shrinking(shrunk, evidence);
  return evidence;
}

}  // namespace finegauge
