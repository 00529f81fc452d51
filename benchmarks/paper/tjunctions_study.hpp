#pragma once

#include "benchmarks/program/study.hpp"

namespace finegauge {

/// What hanging nodes are and cost: counts and times over pattern, refined share, template, mesh size and nested
/// levels; three handlings that must give one displacement; the frames of phantom.toml; and against conforming meshes,
/// refined throughout and of equal true error on the L-shape.
StudyResult tjunctions_study(const StudyContext& context);

}  // namespace finegauge
