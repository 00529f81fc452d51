#include "benchmarks/program/section_picture.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "benchmarks/program/svg_colors.hpp"

namespace finegauge {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

/// Axis-parallel, in the plane [m] or on the screen [px].
struct Rectangle {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(INFINITY), high = Eigen::Vector2d::Constant(-INFINITY);

  void include(const Eigen::Vector2d& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  Eigen::Vector2d size() const { return high - low; }
};

/// From the plane [m] to the screen [px], whose y goes down.
struct Frame {
  Rectangle screen;
  double scale = 1.0;  // [px/m]
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  Eigen::Vector2d operator()(const Eigen::Vector2d& x) const {
    return {shift.x() + scale * x.x(), shift.y() - scale * x.y()};
  }
};

Frame fit(const Rectangle& shown, const Rectangle& screen) {
  Frame frame;
  frame.screen = screen;
  frame.scale = screen.size().cwiseQuotient(shown.size().cwiseMax(1e-300)).minCoeff();
  const Eigen::Vector2d middle = 0.5 * (shown.low + shown.high), target = 0.5 * (screen.low + screen.high);
  frame.shift = {target.x() - frame.scale * middle.x(), target.y() + frame.scale * middle.y()};
  return frame;
}

std::string path_of(const Polygon& polygon, const Frame& frame, bool closed = true) {
  std::string path;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d at = frame(polygon[k]);
    path += (k ? "L" : "M") + svg_number(at.x()) + " " + svg_number(at.y());
  }
  return path + (closed ? "Z" : "");
}

std::string path_of(const std::vector<Polygon>& polygons, const Frame& frame) {
  std::string path;
  for (const Polygon& polygon : polygons) path += path_of(polygon, frame);
  return path;
}

/// Weighted by the area that the cells have in the section, and by their share of material.
ColorRange range_of(const Mesh& mesh, const std::vector<CellSection>& sections, const Eigen::VectorXd& values,
                    double upper_quantile, double resolution) {
  std::vector<std::pair<double, double>> value_and_area;
  double low = INFINITY, largest = -INFINITY;
  for (const CellSection& section : sections) {
    const double value = values[section.cell];
    const double share = material_share(mesh, section.cell);
    if (!std::isfinite(value) || !(share > 0.0)) continue;
    value_and_area.emplace_back(value, share * std::abs(signed_double_area(section.polygon)));
    low = std::min(low, value), largest = std::max(largest, value);
  }
  return color_range(std::move(value_and_area), low, largest, upper_quantile, resolution);
}

void draw_cells(const std::vector<CellSection>& sections, const Eigen::VectorXd& values, const ColorRange& range,
                const Frame& frame, std::string& svg) {
  for (const CellSection& section : sections)
    svg += "<path class=\"cell\" shape-rendering=\"crispEdges\" fill=\"" + range.color(values[section.cell]) +
           "\" d=\"" + path_of(section.polygon, frame) + "\"/>\n";
  // Fine meshes get finer lines, or they would be black. All lines after all cells, which would cover half of them.
  double area = 0.0;
  for (const CellSection& section : sections) area += 0.5 * std::abs(signed_double_area(section.polygon));
  const double cell_size = frame.scale * std::sqrt(area / std::max<std::size_t>(sections.size(), 1));
  svg +=
      "<path class=\"edges\" fill=\"none\" stroke=\"#1a1a1a\" stroke-opacity=\"0.7\" stroke-linejoin=\"round\" "
      "stroke-width=\"" +
      svg_number(std::clamp(cell_size / 25.0, 0.25, 1.0), "%.2f") + "\" d=\"";
  for (const CellSection& section : sections) svg += path_of(section.polygon, frame);
  svg += "\"/>\n";
}

/// A line has a light rim, to be seen on dark and on light colours. A needle that is wider lets the cells through which
/// it goes be seen, and a fine line along its axis.
void draw_needle(const Polygon& needle, double radius, const Frame& frame, std::string& svg) {
  if (needle.size() < 2) return;
  const double width = std::max(4.0, 2.0 * radius * frame.scale);
  const std::string path = path_of(needle, frame, false);
  const auto draw = [&](const std::string& style, double w) {
    svg += "<path class=\"needle\" fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"butt\" " + style +
           " stroke-width=\"" + svg_number(w) + "\" d=\"" + path + "\"/>\n";
  };
  const bool wide = width > 8.0;
  draw(wide ? "stroke=\"#d62728\"" : "stroke=\"#ffffff\"", wide ? 1.5 : width + 2.0);
  draw(std::string("stroke=\"#d62728\"") + (wide ? " stroke-opacity=\"0.55\"" : ""), width);
}

/// 1, 2 or 5 times a power of ten, about a fifth of the picture.
void draw_scale_bar(const SectionPictureOptions& options, const Frame& frame, std::string& svg) {
  const double most = 0.25 * frame.screen.size().x() / frame.scale,
               power = std::pow(10.0, std::floor(std::log10(most)));
  double length = power;
  for (const double digit : {2.0, 5.0})
    if (digit * power <= most) length = digit * power;
  const double x = frame.screen.low.x(), y = options.height - 34.0;
  svg += "<path class=\"scale\" fill=\"none\" stroke=\"#222222\" stroke-width=\"1.5\" d=\"M" + svg_number(x) + " " +
         svg_number(y - 5.0) + "v10m0 -5h" + svg_number(frame.scale * length) + "m0 -5v10\"/>\n<text x=\"" +
         svg_number(x + frame.scale * length + 8.0) + "\" y=\"" + svg_number(y + 5.0) + "\" " + svg_font +
         " font-size=\"14\" fill=\"#222222\">" +
         (options.dimensionless ? svg_number(length, "%g")
          : length < 1.0        ? svg_number(1e3 * length, "%g") + " mm"
                                : svg_number(length, "%g") + " m") +
         "</text>\n";
}

}  // namespace

std::string section_picture_svg(const Mesh& mesh, const Eigen::Matrix3Xd& u, const Eigen::VectorXd& cell_values,
                                const SectionPictureOptions& options) {
  const Eigen::Matrix3Xd positions = u.cols() > 0 ? Eigen::Matrix3Xd(mesh.nodes + u) : mesh.nodes;
  const std::vector<CellSection> sections = section_of_cells(mesh, positions, options.plane);
  Polygon needle;
  for (Eigen::Index k = 0; k < options.needle.cols(); ++k) needle.push_back(options.plane(options.needle.col(k)));

  Rectangle shown;
  for (const Polygon& polygon : options.outline)
    for (const Eigen::Vector2d& x : polygon) shown.include(x);
  if (options.outline.empty())
    for (const CellSection& section : sections)
      for (const Eigen::Vector2d& x : section.polygon) shown.include(x);
  if (!needle.empty()) shown.include(needle.back());
  if (!(shown.size().maxCoeff() > 0.0)) shown = {{-0.5, -0.5}, {0.5, 0.5}};  // the plane misses the body
  // Room around it, in which the needle's shaft shows.
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.08 * shown.size().maxCoeff());
  shown.low -= margin, shown.high += margin;
  const Rectangle screen{{40.0, 84.0}, {options.width - 200.0, options.height - 60.0}};
  const Frame frame = fit(shown, screen);

  const ColorRange range = range_of(mesh, sections, cell_values, options.upper_quantile, options.resolution);
  std::string svg = svg_begin(options.width, options.height);
  svg += "<defs>\n<clipPath id=\"frame\"><rect x=\"" + svg_number(screen.low.x()) + "\" y=\"" +
         svg_number(screen.low.y()) + "\" width=\"" + svg_number(screen.size().x()) + "\" height=\"" +
         svg_number(screen.size().y()) + "\"/></clipPath>\n";
  const std::string outline = path_of(options.outline, frame);
  if (!outline.empty()) svg += "<clipPath id=\"body\"><path clip-rule=\"evenodd\" d=\"" + outline + "\"/></clipPath>\n";
  svg += std::string("</defs>\n<g clip-path=\"url(#frame)\">\n") +
         (outline.empty() ? "<g>\n" : "<g clip-path=\"url(#body)\">\n");
  draw_cells(sections, cell_values, range, frame, svg);
  svg += "</g>\n";
  if (!outline.empty())
    svg +=
        "<path class=\"outline\" fill=\"none\" stroke=\"#111111\" stroke-width=\"1.8\" stroke-linejoin=\"round\" d=\"" +
        outline + "\"/>\n";
  draw_needle(needle, options.needle_radius, frame, svg);
  svg += "</g>\n";
  const std::string counts =
      std::to_string(mesh.cell_count()) + " cells, " + std::to_string(sections.size()) + " cut by the plane";
  svg += svg_heading(options.title, counts + (options.note.empty() ? "" : ", " + options.note));
  draw_scale_bar(options, frame, svg);
  svg += color_bar_svg({options.quantity, options.unit, options.width - 150.0, 150.0, options.height - 90.0}, range);
  return svg + "</svg>\n";
}

}  // namespace finegauge
