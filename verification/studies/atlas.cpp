#include "verification/studies/atlas.hpp"

#include <cstdio>
#include <iterator>
#include <utility>

#include "verification/studies/atlas_contact.hpp"
#include "verification/studies/atlas_dynamics.hpp"
#include "verification/studies/atlas_kinematics.hpp"
#include "verification/studies/atlas_material.hpp"
#include "verification/studies/atlas_mesh.hpp"

namespace finegauge {

std::span<const AtlasAxis> atlas_axes() {
  static const std::vector<AtlasAxis> axes = [] {
    std::vector<AtlasAxis> all;
    for (auto part : {material_axes, mesh_axes, kinematics_axes, dynamics_axes, contact_axes}) {
      std::vector<AtlasAxis> some = part();
      std::move(some.begin(), some.end(), std::back_inserter(all));
    }
    return all;
  }();
  return axes;
}

Evidence atlas_evidence(const EvidenceOptions& options) {
  Evidence evidence;
  EvidenceTable table{"The box in which the simulation is sound",
                      {"axis", "unit", "answered from", "to", "sound from", "to", "fails at"},
                      {}};
  const auto ends = [](const std::optional<AtlasRange>& range, std::vector<TableValue>& row) {
    if (range)
      row.insert(row.end(), {range->low, range->high});
    else
      row.insert(row.end(), {std::string("none"), std::string("none")});
  };
  double done = 0.0;
  for (const AtlasAxis& axis : atlas_axes()) {
    if (options.interrupted()) break;
    AtlasOptions sweeping;
    sweeping.full = options.full;
    sweeping.seconds = options.full ? 1800.0 : 60.0;
    sweeping.interrupted = options.interrupted;
    sweeping.progress = [&](double fraction, const std::string& doing) {
      options.progress((done + fraction) / static_cast<double>(atlas_axes().size()), doing);
    };
    const AtlasSweep found = sweep(axis, sweeping);
    done += 1.0;
    if (options.interrupted()) break;  // not all of the axis was tried
    std::vector<TableValue> row{axis.name, axis.unit};
    ends(found.answered, row);
    ends(found.safe, row);
    std::string failing;
    for (const AtlasPoint& point : found.first_failing) {
      char value[32];
      std::snprintf(value, sizeof value, "%s%g", failing.empty() ? "" : ", ", point.value);
      failing += value;
    }
    row.emplace_back(failing);
    table.rows.push_back(std::move(row));
    evidence.claim(axis.name + "_limits_that_shrank",
                   (covers(found.safe, axis.safe) ? 0.0 : 1.0) + (covers(found.answered, axis.answered) ? 0.0 : 1.0),
                   0.0, 0.0, axis.reason);
  }
  evidence.tables.push_back(std::move(table));
  return evidence;
}

}  // namespace finegauge
