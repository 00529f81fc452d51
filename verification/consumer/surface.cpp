// A user's program on the second library: a surface file read and checked.
#include <cstdio>

#include "core/scene/surface_check.hpp"
#include "core/scene/surface_reader.hpp"

int main(int, char** arguments) {
  const finegauge::CheckedSurface checked =
      finegauge::check_surface(finegauge::read_surface(arguments[1]), arguments[1]);
  std::printf("%d triangles, %d notes\n", int(checked.surface.triangles.size()), int(checked.notes.size()));
}
