#pragma once

#include <Eigen/Core>
#include <string>

#include "core/mesh/mesh.hpp"

namespace finegauge {

struct MeshPictureOptions {
  std::string title;
  std::string quantity = "von Mises stress";
  std::string unit = "Pa";                   ///< empty for a dimensionless scene
  Eigen::Vector3d view = {-1.0, -1.7, 1.1};  ///< from the body towards the viewer, any length
  Eigen::Vector3d up = {0.0, 0.0, 1.0};      ///< not along `view`
  double deformation_scale = 0.0;            ///< displacements are drawn this many times as large
  /// The colours end at the value that this share of the visible area does not exceed: a notch's stress has no bound,
  /// and would leave the rest of the body in one colour. The colour bar says so.
  double upper_quantile = 0.98;
  Eigen::Matrix3Xd curve;         ///< drawn over the body, through whatever is before it: a needle; may have no columns
  int width = 960, height = 720;  ///< [px]
};

/// An SVG picture of the boundary of the leaves, deformed, coloured by a nodal scalar, with the cells' outlines and a
/// colour bar. Parallel projection; faces that look away are left out and the rest is drawn from back to front, in
/// pieces, so that overhangs (a notch) hide what is behind them. Nodal values that are not finite are drawn grey; a
/// field of one value is drawn in one light colour with the value in the bar's place. `displacement` may have no
/// columns.
std::string mesh_picture_svg(const Mesh& mesh, const Eigen::Ref<const Eigen::VectorXd>& nodal,
                             const Eigen::Ref<const Eigen::Matrix3Xd>& displacement,
                             const MeshPictureOptions& options = {});

/// A factor that draws the largest displacement at `share` of the body's diagonal, cut to one digit, but never below 1:
/// a large displacement is drawn as it is. 1 for a body that does not move.
double suggested_deformation_scale(const Mesh& mesh, const Eigen::Ref<const Eigen::Matrix3Xd>& displacement,
                                   double share = 0.05);

}  // namespace finegauge
