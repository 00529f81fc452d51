#include "benchmarks/program/mesh_picture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "benchmarks/program/svg_colors.hpp"

namespace finegauge {
namespace {

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

ColorRange range_of_patches(const std::vector<FacePatch>& patches, double upper_quantile) {
  std::vector<std::pair<double, double>> value_and_area;
  double low = 0.0, largest = 0.0;
  for (const FacePatch& patch : patches) {
    const double middle = patch.interpolate(patch.value, 0.5, 0.5);
    if (!std::isfinite(middle)) continue;
    if (value_and_area.empty()) low = largest = patch.value[0];
    for (const double value : patch.value) low = std::min(low, value), largest = std::max(largest, value);
    value_and_area.emplace_back(middle, patch.area);
  }
  return color_range(std::move(value_and_area), low, largest, upper_quantile);
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
         svg_number(line_width, "%.2f") + "\">\n";
  for (const Primitive& p : primitives) {
    std::string path = "M";
    for (int c = 0; c < p.corners; ++c)
      path += (c ? "L" : "") + svg_number(p.at[c].x()) + " " + svg_number(p.at[c].y());
    if (p.color == -2)
      svg += "<path d=\"" + path + "\"/>\n";
    else
      svg += "<path stroke=\"none\" shape-rendering=\"crispEdges\" fill=\"" +
             (p.color < 0 ? std::string(no_value_color)
              : uniform   ? std::string(one_value_color)
                          : viridis_text(p.color / 255.0)) +
             "\" d=\"" + path + "Z\"/>\n";
  }
  svg += "</g>\n";
}

/// Half transparent, so that a needle is told from an edge and what it lies in shows through.
void draw_curve(const Eigen::Matrix3Xd& curve, const Projection& project, std::string& svg) {
  if (curve.cols() < 2) return;
  std::string path = "M";
  for (Eigen::Index i = 0; i < curve.cols(); ++i) {
    const Eigen::Vector3d p = project(curve.col(i));
    path += (i ? "L" : "") + svg_number(p.x()) + " " + svg_number(p.y());
  }
  svg +=
      "<path fill=\"none\" stroke=\"#d62728\" stroke-opacity=\"0.7\" stroke-width=\"4\" stroke-linecap=\"round\" d=\"" +
      path + "\"/>\n";
}

}  // namespace

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

  const ColorRange range = range_of_patches(patches, options.upper_quantile);
  // About 12,000 pieces whatever the size of the picture, but not below a few pixels each.
  const double piece_size = std::max(3.0, std::sqrt(area / 12000.0));
  std::vector<Primitive> primitives;
  for (const FacePatch& patch : patches) add_primitives(patch, range, piece_size, primitives);
  const double face_size = patches.empty() ? 1.0 : std::sqrt(area / static_cast<double>(patches.size()));

  std::string svg = svg_begin(options.width, options.height);
  // Fine meshes get finer lines, or they would be black.
  draw_primitives(primitives, range.uniform, std::clamp(face_size / 18.0, 0.25, 1.1), svg);
  draw_curve(options.curve, project, svg);
  std::string note = std::to_string(mesh.cell_count()) + " cells, " + std::to_string(mesh.node_count()) + " nodes";
  if (displacement.cols() > 0 && options.deformation_scale != 0.0)
    note += ", displacements × " + svg_number(options.deformation_scale, "%.3g");
  svg += svg_heading(options.title, note);
  svg += color_bar_svg({options.quantity, options.unit, options.width - 150.0, 130.0, options.height - 90.0}, range);
  return svg + "</svg>\n";
}

}  // namespace finegauge
