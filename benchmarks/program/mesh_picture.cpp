#include "benchmarks/program/mesh_picture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace finegauge {
namespace {

// Nine equidistant samples of matplotlib's viridis (Stéfan van der Walt and Nathaniel Smith 2015, public domain CC0).
// Between them the map is so smooth that linear interpolation is within a few of 256 levels.
constexpr std::array<std::uint32_t, 9> viridis_table = {0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c,
                                                        0x28ae80, 0x5ec962, 0xaadc32, 0xfde725};
constexpr const char* font = "font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\"";
constexpr const char* grey = "#bbbbbb";   // where there is no value
constexpr const char* light = "#cfe3ec";  // where all values are the same: outlines show well on it

std::string number(double value, const char* format = "%.1f") {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string color_text(double t) {
  const std::array<double, 3> rgb = viridis(t);
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", static_cast<int>(std::lround(255 * rgb[0])),
                static_cast<int>(std::lround(255 * rgb[1])), static_cast<int>(std::lround(255 * rgb[2])));
  return text;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

/// Screen axes of a parallel projection: x right, y up, z towards the viewer.
struct Projection {
  Eigen::Matrix3d axes;  // rows
  double scale = 1.0;    // [px/m]
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();

  Projection(const Eigen::Vector3d& view, const Eigen::Vector3d& up) {
    axes.row(2) = view.normalized();
    axes.row(0) = up.cross(view).normalized();
    axes.row(1) = axes.row(2).cross(axes.row(0));
  }
  /// Pixel position, downwards as SVG counts, and depth towards the viewer in pixels.
  Eigen::Vector3d operator()(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d p = axes * x;
    return {shift.x() + scale * p.x(), shift.y() - scale * p.y(), scale * p.z()};
  }
  /// Fits points, 3 × n, into a rectangle.
  void fit(const Eigen::Matrix3Xd& points, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
    const Eigen::Matrix3Xd seen = axes * points;
    const Eigen::Vector2d least = seen.topRows<2>().rowwise().minCoeff(), most = seen.topRows<2>().rowwise().maxCoeff();
    const Eigen::Vector2d room = (high - low).cwiseQuotient((most - least).cwiseMax(1e-300));
    scale = room.minCoeff();
    const Eigen::Vector2d middle = 0.5 * (least + most), target = 0.5 * (low + high);
    shift = {target.x() - scale * middle.x(), target.y() + scale * middle.y()};
  }
};

/// A thing to draw: a patch of one colour, or a piece of a cell's outline.
struct Primitive {
  double depth;
  std::int16_t color;  // of 256, -1 grey, -2 outline
  std::array<Eigen::Vector2f, 4> at;
  int corners;
};

/// A boundary face as a patch of the unit square; a triangle's upper corners coincide.
struct FacePatch {
  std::array<Eigen::Vector3d, 4> at;  // screen; (0,0) (1,0) (0,1) (1,1)
  std::array<double, 4> value;
  bool triangle;
  double area;  // on the screen

  template <class T>
  T interpolate(const std::array<T, 4>& corners, double s, double t) const {
    const T low = (1.0 - s) * corners[0] + s * corners[1], high = (1.0 - s) * corners[2] + s * corners[3];
    return (1.0 - t) * low + t * high;
  }
  double longest_edge() const {
    double longest = 0.0;
    for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}})
      longest = std::max(longest, (at[a] - at[b]).head<2>().norm());
    return longest;
  }
};

struct ColorRange {
  double low = 0.0, high = 1.0, largest = 1.0;
  bool uniform = false;  ///< one value everywhere, as far as four digits tell
  double share(double value) const { return std::clamp((value - low) / (high - low), 0.0, 1.0); }
};

/// Quantile by area, not by nodes, of which refinement puts most where the values are largest.
ColorRange color_range(const std::vector<FacePatch>& patches, double upper_quantile) {
  std::vector<std::pair<double, double>> value_and_area;
  double area = 0.0, low = 0.0, largest = 0.0;
  bool first = true;
  for (const FacePatch& patch : patches) {
    const double middle = patch.interpolate(patch.value, 0.5, 0.5);
    if (!std::isfinite(middle)) continue;
    value_and_area.emplace_back(middle, patch.area);
    area += patch.area;
    for (const double value : patch.value) {
      low = first ? value : std::min(low, value), largest = first ? value : std::max(largest, value);
      first = false;
    }
  }
  if (value_and_area.empty()) return {};
  std::sort(value_and_area.begin(), value_and_area.end());
  ColorRange range{low, largest, largest};
  double below = 0.0;
  for (const auto& [value, part] : value_and_area)
    if ((below += part) >= upper_quantile * area) {
      range.high = upper_quantile < 1.0 ? value : largest;
      break;
    }
  // Rounding and the solver's tolerance alone must not fill a field of one value with colours.
  const double least = std::max(1e-12, 1e-4 * std::max(std::abs(low), std::abs(largest)));
  range.uniform = !(largest - low > least);
  // Where most of the body has one value the colours go on to the largest.
  if (!(range.high - range.low > least)) range.high = largest;
  return range;
}

/// Pieces of a patch small enough to be flat in colour and in depth, and its outline cut into the same pieces.
void add_primitives(const FacePatch& patch, const ColorRange& range, double piece_size, std::vector<Primitive>& out) {
  const int pieces = std::clamp(static_cast<int>(std::ceil(patch.longest_edge() / piece_size)), 1, 64);
  const auto at = [&](int i, int j) { return patch.interpolate(patch.at, double(i) / pieces, double(j) / pieces); };
  for (int i = 0; i < pieces; ++i)
    for (int j = 0; j < pieces; ++j) {
      const std::array<Eigen::Vector3d, 4> p = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
      const double value = patch.interpolate(patch.value, (i + 0.5) / pieces, (j + 0.5) / pieces);
      Primitive piece{0.25 * (p[0] + p[1] + p[2] + p[3]).z(), -1, {}, 4};
      if (std::isfinite(value)) piece.color = static_cast<std::int16_t>(std::lround(255.0 * range.share(value)));
      for (int c = 0; c < 4; ++c) piece.at[c] = p[c].head<2>().cast<float>();
      out.push_back(piece);
    }
  const auto add_line = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    // In front of the patches beside it, which would cover half of its width.
    out.push_back(
        {0.5 * (a.z() + b.z()) + 1.5 * piece_size, -2, {a.head<2>().cast<float>(), b.head<2>().cast<float>()}, 2});
  };
  for (int i = 0; i < pieces; ++i) {
    add_line(at(i, 0), at(i + 1, 0));
    add_line(at(0, i), at(0, i + 1));
    add_line(at(pieces, i), at(pieces, i + 1));
    if (!patch.triangle) add_line(at(i, pieces), at(i + 1, pieces));
  }
}

void draw_primitives(std::vector<Primitive>& primitives, bool uniform, double line_width, std::string& svg) {
  std::stable_sort(primitives.begin(), primitives.end(),
                   [](const Primitive& a, const Primitive& b) { return a.depth < b.depth; });
  // Without crispEdges neighbouring patches are blended with the background and a light net shows between them.
  svg += "<g stroke=\"#1a1a1a\" stroke-opacity=\"0.75\" stroke-linecap=\"round\" stroke-width=\"" +
         number(line_width, "%.2f") + "\">\n";
  for (const Primitive& p : primitives) {
    std::string path = "M";
    for (int c = 0; c < p.corners; ++c) path += (c ? "L" : "") + number(p.at[c].x()) + " " + number(p.at[c].y());
    if (p.color == -2)
      svg += "<path d=\"" + path + "\"/>\n";
    else
      svg += "<path stroke=\"none\" shape-rendering=\"crispEdges\" fill=\"" +
             (p.color < 0 ? std::string(grey)
              : uniform   ? std::string(light)
                          : color_text(p.color / 255.0)) +
             "\" d=\"" + path + "Z\"/>\n";
  }
  svg += "</g>\n";
}

void draw_color_bar(const MeshPictureOptions& options, const ColorRange& range, std::string& svg) {
  const double x = options.width - 150.0, top = 130.0, bottom = options.height - 90.0, width = 22.0;
  const auto text = [&](double tx, double ty, const std::string& words, const char* more = "") {
    svg += "<text x=\"" + number(tx) + "\" y=\"" + number(ty) + "\" " + font + " fill=\"#222222\" " + more + ">" +
           escaped(words) + "</text>\n";
  };
  text(x + width, top - 42.0, options.quantity, "font-size=\"15\" text-anchor=\"middle\"");
  text(x + width, top - 22.0, options.unit.empty() ? "(dimensionless)" : "[" + options.unit + "]",
       "font-size=\"14\" text-anchor=\"middle\"");
  if (range.uniform) {
    text(x + width, top + 6.0, "uniform: " + number(range.low, "%.4g"), "font-size=\"14\" text-anchor=\"middle\"");
    return;
  }
  constexpr int bands = 96;
  for (int k = 0; k < bands; ++k) {
    const double y = bottom - (bottom - top) * (k + 1) / bands;
    svg += "<rect shape-rendering=\"crispEdges\" x=\"" + number(x) + "\" y=\"" + number(y, "%.2f") + "\" width=\"" +
           number(width) + "\" height=\"" + number((bottom - top) / bands + 0.5, "%.2f") + "\" fill=\"" +
           color_text((k + 0.5) / bands) + "\"/>\n";
  }
  constexpr int ticks = 5;
  for (int k = 0; k < ticks; ++k) {
    const double share = double(k) / (ticks - 1), y = bottom - (bottom - top) * share;
    svg += "<path d=\"M" + number(x + width) + " " + number(y) + "h6\" stroke=\"#444444\"/>\n";
    const bool clipped = k == ticks - 1 && range.largest > range.high;
    text(x + width + 10.0, y + 5.0,
         (clipped ? "≥ " : "") + number(range.low + share * (range.high - range.low), "%.3g"), "font-size=\"14\"");
  }
  if (range.largest > range.high)
    text(x + width, bottom + 32.0, "largest " + number(range.largest, "%.3g"),
         "font-size=\"13\" text-anchor=\"middle\"");
}

/// Half transparent, so that a needle is told from an edge and what it lies in shows through.
void draw_curve(const Eigen::Matrix3Xd& curve, const Projection& project, std::string& svg) {
  if (curve.cols() < 2) return;
  std::string path = "M";
  for (Eigen::Index i = 0; i < curve.cols(); ++i) {
    const Eigen::Vector3d p = project(curve.col(i));
    path += (i ? "L" : "") + number(p.x()) + " " + number(p.y());
  }
  svg +=
      "<path fill=\"none\" stroke=\"#d62728\" stroke-opacity=\"0.7\" stroke-width=\"4\" stroke-linecap=\"round\" d=\"" +
      path + "\"/>\n";
}

}  // namespace

std::array<double, 3> viridis(double t) {
  const double at = std::clamp(t, 0.0, 1.0) * (viridis_table.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), viridis_table.size() - 2);
  const double share = at - static_cast<double>(low);
  std::array<double, 3> rgb;
  for (int c = 0; c < 3; ++c) {
    const int shift = 16 - 8 * c;
    rgb[c] =
        ((1.0 - share) * (viridis_table[low] >> shift & 255) + share * (viridis_table[low + 1] >> shift & 255)) / 255;
  }
  return rgb;
}

double suggested_deformation_scale(const Mesh& mesh, const Eigen::Ref<const Eigen::Matrix3Xd>& displacement,
                                   double share) {
  if (displacement.cols() == 0) return 1.0;
  const double diagonal = (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).norm();
  const double largest = displacement.colwise().norm().maxCoeff();
  if (!(largest > 0.0) || !std::isfinite(diagonal / largest)) return 1.0;
  const double factor = share * diagonal / largest, digit = std::pow(10.0, std::floor(std::log10(factor)));
  return std::max(1.0, std::floor(factor / digit) * digit);
}

std::string mesh_picture_svg(const Mesh& mesh, const Eigen::Ref<const Eigen::VectorXd>& nodal,
                             const Eigen::Ref<const Eigen::Matrix3Xd>& displacement,
                             const MeshPictureOptions& options) {
  Eigen::Matrix3Xd positions = mesh.nodes;
  if (displacement.cols() > 0) positions += options.deformation_scale * displacement;
  Projection project(options.view, options.up);
  Eigen::Matrix3Xd shown(3, positions.cols() + options.curve.cols());
  shown << positions, options.curve;
  project.fit(shown, {40.0, 80.0}, {options.width - 200.0, options.height - 50.0});

  std::vector<FacePatch> patches;
  double area = 0.0;
  const int corners = corner_count(mesh.shape);
  for (const BoundaryFace& face : mesh.boundary) {
    const auto& cell = mesh.cells[face.cell];
    const auto& local = face_corners(mesh.shape, face.face);
    FacePatch patch;
    patch.triangle = mesh.shape == CellShape::tetrahedron;
    for (int k = 0; k < 4; ++k) {
      const int node = cell[local[patch.triangle && k == 3 ? 2 : k]];
      patch.at[k] = project(positions.col(node));
      patch.value[k] = nodal[node];
    }
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int c = 0; c < corners; ++c) centre += positions.col(cell[c]) / corners;
    // The outward side is the one away from the cell's centre, whatever the order of the corners.
    const Eigen::Vector3d middle = patch.interpolate(patch.at, 0.5, 0.5);
    Eigen::Vector3d normal = (patch.at[1] - patch.at[0]).cross(patch.at[2] - patch.at[0]);
    if (normal.dot(middle - project(centre)) < 0.0) normal = -normal;
    if (!(normal.z() > 0.0)) continue;
    patch.area = (patch.triangle ? 0.5 : 1.0) * normal.z();
    area += patch.area;
    patches.push_back(patch);
  }

  const ColorRange range = color_range(patches, options.upper_quantile);
  // About 12,000 pieces whatever the size of the picture, but not below a few pixels each.
  const double piece_size = std::max(3.0, std::sqrt(area / 12000.0));
  std::vector<Primitive> primitives;
  for (const FacePatch& patch : patches) add_primitives(patch, range, piece_size, primitives);
  const double face_size = patches.empty() ? 1.0 : std::sqrt(area / static_cast<double>(patches.size()));

  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + std::to_string(options.width) + " " +
                    std::to_string(options.height) + "\" width=\"" + std::to_string(options.width) + "\" height=\"" +
                    std::to_string(options.height) + "\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  // Fine meshes get finer lines, or they would be black.
  draw_primitives(primitives, range.uniform, std::clamp(face_size / 18.0, 0.25, 1.1), svg);
  draw_curve(options.curve, project, svg);
  svg += std::string("<text x=\"40\" y=\"42\" ") + font + " font-size=\"20\" fill=\"#111111\">" +
         escaped(options.title) + "</text>\n";
  std::string note = std::to_string(mesh.cell_count()) + " cells, " + std::to_string(mesh.node_count()) + " nodes";
  if (displacement.cols() > 0 && options.deformation_scale != 0.0)
    note += ", displacements × " + number(options.deformation_scale, "%.3g");
  svg += std::string("<text x=\"40\" y=\"66\" ") + font + " font-size=\"14\" fill=\"#555555\">" + note + "</text>\n";
  draw_color_bar(options, range, svg);
  return svg + "</svg>\n";
}

}  // namespace finegauge
