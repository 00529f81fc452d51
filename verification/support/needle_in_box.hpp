#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "core/needle/interaction.hpp"
#include "core/space/discretization.hpp"

namespace finegauge {

/// A box of tissue, clamped on x_min, with a straight needle in it that enters through x_max: the two systems of one
/// step and the points that couple them, made without the modules that find them in a frame. The needle's matrix is
/// the textbook's (Euler and Bernoulli), not that of core/needle.
struct NeedleInBoxOptions {
  std::array<int, 3> cells = {4, 3, 2};        ///< two along z: points reach nodes that z_max holds
  bool refine = false;                         ///< the cells around the axis, so that points have hanging masters
  double tissue_modulus = 1e4;                 ///< [Pa]
  double needle_modulus = 1e9;                 ///< [Pa]
  double bend = 0.0;                           ///< rotation of the tissue's cells at x_max [rad], 0 at x_min
  int elements = 6;                            ///< of the needle
  int points = 5;                              ///< along the needle, the last one at the tip
  double tau = 0.01;                           ///< [s]
  AxialLaw axial = AxialLaw::bilateral;        ///< of all points
  LateralLaw lateral = LateralLaw::bilateral;  ///< of all points
  double advance = 0.02;                       ///< speed of the needle along itself [m/s]
  Eigen::Vector2d sideways = {0.01, -0.005};   ///< speed of the needle's base across itself [m/s]
  bool base_held = true;                       ///< the base follows its prescribed velocity
};

/// What InteractionSystem borrows.
struct NeedleInBox {
  std::shared_ptr<const Discretization> d;  ///< A borrows its pattern, also after a move
  BlockMatrix<double> A;
  Eigen::VectorXd b, velocity;
  ChainMatrix needle_A;
  Eigen::VectorXd needle_b, needle_velocity;
  HeldDofs held;
  std::vector<ContactRows> points;
  double tau = 0.0, reference_speed = 0.0;

  InteractionSystem system() const;
};
NeedleInBox needle_in_box(const NeedleInBoxOptions& options);

/// The same step in other units: masses, lengths and times multiplied by the factors.
void change_units(double mass, double length, double time, NeedleInBox& box);

}  // namespace finegauge
