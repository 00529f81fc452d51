#pragma once

#include <string>

#include "benchmarks/program/section.hpp"

namespace finegauge {

struct SectionPictureOptions {
  std::string title, note;  ///< note: after the counts of cells, below the title; may be empty
  std::string quantity = "von Mises stress";
  std::string unit = "Pa";     ///< of the values; empty: dimensionless
  bool dimensionless = false;  ///< lengths of the scale bar, too
  /// The colours end at the value that this share of the visible area does not exceed (mesh_picture.hpp).
  double upper_quantile = 0.98;
  double resolution = 0.0;  ///< values that differ by no more are one value: what is left of a motion is no picture
  SectionPlane plane;
  /// Closed polygons in the plane [m] around what of the cells is material, by the even-odd rule: cells are drawn
  /// inside of them only. None: all of every cell is.
  std::vector<std::vector<Eigen::Vector2d>> outline;
  Eigen::Matrix3Xd needle;     ///< centreline from base to tip [m], seen along the plane's normal; may have no columns
  double needle_radius = 0.0;  ///< [m]; drawn no thinner than four pixels
  int width = 960, height = 720;  ///< [px]
};

/// An SVG picture of a body cut open: sections of the deformed leaves, each in the colour of its value, their edges,
/// the outline, the needle, a colour bar and a scale bar. All of the section is shown, and the needle as far as it is
/// near: its tip always, else what lies in the picture. Values that are not finite are grey; one value everywhere is
/// drawn in one light colour. Numbers are rounded to a tenth of a pixel: the same bits for the same input. `u` may have
/// no columns.
std::string section_picture_svg(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::VectorXd& cell_values,
                                const SectionPictureOptions& options);

}  // namespace finegauge
