#pragma once

#include <span>

#include "verification/support/atlas.hpp"
#include "verification/support/evidence.hpp"

namespace finegauge {

/// All axes of the atlas: material, mesh, kinematics, dynamics, contact.
std::span<const AtlasAxis> atlas_axes();

/// A table of the limits found, and for each axis the claim that none of them is narrower than it was.
Evidence atlas_evidence(const EvidenceOptions& options);

}  // namespace finegauge
