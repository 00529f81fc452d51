#include "benchmarks/profile/profile_tjunctions.hpp"

#include <algorithm>
#include <utility>

#include "benchmarks/program/optional_field.hpp"
#include "core/space/springs.hpp"

namespace finegauge {
namespace {

constexpr double most_conforming_dofs = 60000;  // a factor of seconds and a gigabyte

/// Of any size and direction: the handlings are compared by what they do to it.
Eigen::Matrix3Xd unit_loads(const Mesh& mesh) {
  Eigen::Matrix3Xd loads(3, mesh.node_count());
  loads.colwise() = Eigen::Vector3d(1.0, 0.5, -1.0);
  return loads;
}

bool is_held(const RefinementForest& forest, const Discretization& d) {
  const std::vector<BodyFreedom> bodies =
      free_rigid_motions(forest.topology(), d.mesh, d.hanging, d.supports, d.springs);
  return std::ranges::all_of(bodies, [](const BodyFreedom& body) { return body.free_motions == 0; });
}

/// Supports and springs of a moment, carried to another mesh of the same base, are not known here: the conforming mesh
/// is held where its nodes are nodes that were held, which for the cost is as good.
Supports supports_like(const MeshMoment& moment, const Mesh& mesh) {
  Supports supports;
  const Supports& held = moment.d.supports;
  for (int node = 0; node < mesh.node_count(); ++node)
    for (std::size_t s = 0; s < held.reduced.size(); ++s)
      if (moment.d.mesh.identities[moment.d.hanging.node_of[held.reduced[s]]] == mesh.identities[node]) {
        supports.reduced.push_back(node);
        supports.held.push_back(held.held[s]);
        supports.displacement.push_back(held.displacement[s]);
        break;
      }
  return supports;
}

Json conforming(const MeshMoment& moment, int repetitions) {
  const RefinementForest forest = uniformly_refined_like(moment.forest);
  // Cells times three bounds the dofs of large meshes well.
  const double dofs = 3.0 * forest.leaf_count();
  Json json;
  if (dofs > most_conforming_dofs) {
    json["unknowns"] = nullptr;
    json["unknowns_reason"] =
        "about " + std::to_string(static_cast<long>(dofs)) + ", more than this comparison factors";
    return json;
  }
  Discretization d = discretize(forest, moment.d.shapes.material(), {});
  d.supports = supports_like(moment, d.mesh);
  const Eigen::Matrix3Xd rest = Eigen::Matrix3Xd::Zero(3, d.mesh.node_count());
  if (!is_held(forest, d)) {
    json["unknowns"] = nullptr;
    json["unknowns_reason"] = "held by springs alone: not compared";
    return json;
  }
  HandlingOptions options;
  options.repetitions = repetitions;
  return to_json(compare_handlings(d, rest, unit_loads(d.mesh), {TjunctionHandling::elementwise}, options).front());
}

}  // namespace

RefinementForest uniformly_refined_like(const RefinementForest& forest) {
  RefinementForest uniform{BaseMesh(forest.base())};
  for (int depth = 0;; ++depth) {
    int like = -1;
    std::vector<int> open(forest.base().cells.size());
    for (std::size_t cell = 0; cell < open.size(); ++cell) open[cell] = static_cast<int>(cell);
    while (!open.empty() && like < 0) {
      const int handle = open.back();
      open.pop_back();
      const auto& cell = forest.cell(handle);
      if (cell.first_child < 0) continue;
      if (cell.depth == depth) like = handle;
      for (int k = 0; k < cell.refinement.child_count(); ++k) open.push_back(cell.first_child + k);
    }
    if (like < 0) return uniform;
    const Mesh mesh = uniform.leaf_mesh();
    for (const int leaf : mesh.forest_cell)
      if (uniform.can_refine(leaf, forest.cell(like).refinement)) uniform.refine(leaf, forest.cell(like).refinement);
  }
}

Json tjunction_summary(const std::optional<MeshMoment>& most, const TjunctionOverhead* overhead, int repetitions) {
  Json summary;
  if (!most) {
    summary["hanging_nodes"] = 0;
    for (const char* key : {"elementwise", "explicit", "multiplier", "ignored", "conforming"}) {
      summary[key] = nullptr;
      summary[std::string(key) + "_reason"] = "no node of the run hung";
    }
    return summary;
  }
  summary = to_json(count_tjunctions(most->forest, most->d));
  const TjunctionTimes times = time_tjunctions(most->forest, most->d, most->u, repetitions);
  summary["build_ms"] = times.build_ms, summary["reduce_ms"] = times.reduce_ms;
  summary["expand_ms"] = times.expand_ms, summary["gather_ms"] = times.gather_ms;
  if (overhead) summary["of_frames"] = overhead_summary(*overhead);
  if (!is_held(most->forest, most->d)) {
    for (const char* key : {"elementwise", "explicit", "multiplier", "ignored", "conforming"}) {
      summary[key] = nullptr;
      summary[std::string(key) + "_reason"] = "the stiffness alone is singular: the body is not held";
    }
    return summary;
  }
  HandlingOptions options;
  options.repetitions = repetitions;
  for (const HandlingCost& cost :
       compare_handlings(most->d, most->u, unit_loads(most->d.mesh),
                         {std::begin(tjunction_handlings), std::end(tjunction_handlings)}, options))
    summary[to_string(cost.handling)] = to_json(cost);
  summary["conforming"] = conforming(*most, repetitions);
  return summary;
}

std::optional<double> handling_difference(const Json& summary) {
  std::optional<double> largest;
  for (const char* key : {"explicit", "multiplier"}) {
    if (!summary.contains(key) || !summary.at(key).is_object()) continue;
    const double difference = summary.at(key).at("difference").get<double>();
    largest = std::max(largest.value_or(0.0), difference);
  }
  return largest;
}

}  // namespace finegauge
