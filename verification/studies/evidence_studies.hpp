#pragma once

#include <span>

#include "verification/support/evidence.hpp"

namespace finegauge {

/// All that `finegauge verify` shows, in the order of the factors that it speaks for. Each study's claims are gated by
/// the test beside it.
std::span<const EvidenceStudy> evidence_studies();

}  // namespace finegauge
