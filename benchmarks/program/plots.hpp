#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace finegauge {

enum class PlotLine {
  joined,             ///< a line through the points
  joined_with_slope,  ///< the same; on double logarithmic plots the legend adds the least squares slope, unsigned
  steps,              ///< keeps a point's value up to the next point
  none                ///< marks alone: a cloud, which has no end to label
};

/// One curve. Points that are not finite, or not positive on a logarithmic axis, are left out.
struct PlotSeries {
  std::string label;  ///< short: it stands in the legend and at the curve's end
  std::vector<double> x, y;
  PlotLine line = PlotLine::joined;
};

/// A line plot; with both axes logarithmic, a convergence plot.
struct Plot {
  std::string file;  ///< name in the output directory, ending in .svg
  std::string title;
  std::string x_label, y_label;  ///< with units in brackets
  bool log_x = true, log_y = true;
  std::vector<PlotSeries> series;
};

/// Slope of log y over log x by least squares over the points that can be drawn; NaN below two points.
double logarithmic_slope(const PlotSeries& series);

/// The gnuplot program that draws the plot into `svg`, data included.
std::string gnuplot_script(const Plot& plot, const std::filesystem::path& svg);

/// What came of drawing: a plot is an extra, so its failure is a note in the result and never ends the program.
struct [[nodiscard]] PlotReport {
  bool written = false;
  std::string why_not;  ///< empty when written
};
/// Runs gnuplot (found by PATH); writes DIRECTORY/plot.file, whole or not at all.
PlotReport draw_plot(const Plot& plot, const std::filesystem::path& directory);

}  // namespace finegauge
