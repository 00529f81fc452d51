// Writes the surface of liver_shape.hpp as OBJ: make_liver FILE.obj
// Meshed by CGAL's surface mesher (Boissonnat & Oudot 2005, Graphical Models 67, 405-451), scaled to 1500 cm³ and moved
// until the centre of its volume is the origin; metres. The same file every time on the same machine and version of
// CGAL: the mesher's random numbers start from a fixed seed.

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <vector>

#include "liver_shape.hpp"

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Kernel = Triangulation::Geom_traits;
using Function = double (*)(Kernel::Point_3);
using Surface = CGAL::Implicit_surface_3<Kernel, Function>;

namespace {

constexpr double volume_wanted = 1.5e-3;       // [m³]
constexpr double smallest_angle = 30.0;        // [degrees]
constexpr double largest_circumradius = 0.58;  // [cm]
constexpr double largest_distance = 0.03;      // [cm] of a triangle's circumcentre from the surface
constexpr unsigned seed = 1;

double at(Kernel::Point_3 p) { return liver::shape({p.x(), p.y(), p.z()}); }

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

Mesh meshed() {
  CGAL::get_default_random() = CGAL::Random(seed);
  Triangulation triangulation;
  Complex complex(triangulation);
  const Surface surface(at, Kernel::Sphere_3(Kernel::Point_3(-2.0, 0.0, 1.0), 400.0), 1e-6);
  const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(smallest_angle, largest_circumradius,
                                                                      largest_distance);
  CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Manifold_tag(), 12);
  CGAL::Surface_mesh<Kernel::Point_3> oriented;
  CGAL::facets_in_complex_2_to_triangle_mesh(complex, oriented);
  Mesh mesh;
  for (const auto v : oriented.vertices()) {
    const auto p = oriented.point(v);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : oriented.faces()) {
    auto& corners = mesh.triangles.emplace_back();
    std::size_t k = 0;
    for (const auto v : oriented.vertices_around_face(oriented.halfedge(face)))
      corners[k++] = static_cast<int>(v.idx());
  }
  return mesh;
}

struct Measures {
  double volume = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

Measures measures(const Mesh& mesh) {
  Measures m;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[i], b = mesh.vertices[j], c = mesh.vertices[k];
    const double sixfold = a.dot(b.cross(c));
    m.volume += sixfold / 6.0;
    m.centre += sixfold / 24.0 * (a + b + c);
  }
  m.centre /= m.volume;
  return m;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_liver FILE.obj\n";
    return 2;
  }
  Mesh mesh = meshed();
  Measures m = measures(mesh);
  if (m.volume < 0.0)
    for (auto& corners : mesh.triangles) std::swap(corners[1], corners[2]);
  m = measures(mesh);
  const double scale = std::cbrt(volume_wanted / m.volume);
  for (auto& x : mesh.vertices) x = scale * (x - m.centre);

  std::ofstream out(argv[1]);
  out << "# A liver-like body, 1500 cm3, in metres; x to the patient's left, y to the back, z upwards.\n"
      << "# Written by make_liver from liver_shape.hpp; BSD 3-clause like the source.\n"
      << "# " << mesh.vertices.size() << " vertices, " << mesh.triangles.size() << " triangles\n";
  char line[100];
  for (const auto& x : mesh.vertices) {
    std::snprintf(line, sizeof line, "v %.7f %.7f %.7f\n", x.x(), x.y(), x.z());
    out << line;
  }
  for (const auto& [a, b, c] : mesh.triangles) out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
  out.close();
  std::cout << mesh.vertices.size() << " vertices, " << mesh.triangles.size() << " triangles, " << m.volume
            << " cm3 before scaling by " << 100.0 * scale << "\n";
  return out ? 0 : 1;
}
