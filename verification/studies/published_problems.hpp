#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "core/elasticity/material.hpp"

namespace finegauge {

/// What the studies of published problems share.

inline const Eigen::Vector3d x_axis = Eigen::Vector3d::UnitX(), y_axis = Eigen::Vector3d::UnitY(),
                             z_axis = Eigen::Vector3d::UnitZ();

inline constexpr std::array<Dilatation, 2> dilatations = {Dilatation::standard, Dilatation::mean};
inline std::string name_of(Dilatation dilatation) { return dilatation == Dilatation::mean ? "mean" : "standard"; }

}  // namespace finegauge
