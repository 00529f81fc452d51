#include "core/scene/attachment_reader.hpp"

#include <algorithm>
#include <utility>

#include "core/scene/attachments.hpp"
#include "core/scene/plain_number.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

/// The three ways to say where, each by two keys that go together.
struct Pick {
  const char *first, *second;
};
constexpr Pick picks[] = {{"box_min", "box_max"}, {"sphere_centre", "sphere_radius"}, {"patch_point", "patch_radius"}};

Selection read_selection(const SectionReader& reader) {
  int found = -1;
  for (int i = 0; i < 3; ++i) {
    const bool first = reader.has(picks[i].first), second = reader.has(picks[i].second);
    if (!first && !second) continue;
    const char *given = first ? picks[i].first : picks[i].second, *lacking = first ? picks[i].second : picks[i].first;
    if (found >= 0)
      reader.refuse(given, std::string("found beside ") + picks[found].first +
                               ", allowed one of a box, a sphere and a patch of the surface");
    if (first != second)
      reader.refuse_missing(lacking, std::string(picks[i].first) + " and " + picks[i].second + " go together");
    found = i;
  }
  if (found < 0)
    reader.refuse_missing("box_min",
                          "exactly one of box_min with box_max, sphere_centre with sphere_radius, and patch_point with "
                          "patch_radius");
  if (found == 1) return SphereSelection{reader.vector("sphere_centre"), reader.number("sphere_radius")};
  if (found == 2) return PatchSelection{reader.vector("patch_point"), reader.number("patch_radius")};
  const BoxSelection box{reader.vector("box_min"), reader.vector("box_max")};
  for (int axis = 0; axis < 3; ++axis)
    if (!(box.min[axis] <= box.max[axis]))
      reader.refuse(
          "box_max",
          "found " + plain_number(box.max[axis]) + ", allowed at least that of box_min, " + plain_number(box.min[axis]),
          axis);
  return box;
}

std::optional<Course> read_motion(const SectionReader& reader, const Eigen::Vector3d& displacement) {
  if (!reader.has("breathing_period")) {
    for (const char* key : {"breathing_waveform", "breathing_ramp"})
      if (reader.has(key)) reader.refuse(key, "found without breathing_period, allowed only with it");
    return read_course(reader);
  }
  for (const char* key : {"course", "period"})
    if (reader.has(key)) reader.refuse(key, "found beside breathing_period, allowed one of the two");
  if (displacement.isZero(0.0))
    reader.refuse("breathing_period", "found without a displacement, its amplitude; allowed only with one");
  BreathingCourse breathing;
  breathing.waveform = reader.text("breathing_waveform") == "sine" ? BreathingWaveform::sine : BreathingWaveform::cos4;
  breathing.period = reader.number("breathing_period");
  breathing.ramp = reader.has("breathing_ramp") ? reader.number("breathing_ramp") : breathing.period;
  return breathing;
}

/// The key that says how far the selection reaches: the one to change when it is empty.
const char* reach_key(const Selection& where) {
  constexpr const char* keys[] = {"box_max", "sphere_radius", "patch_radius"};
  return keys[where.index()];
}

}  // namespace

void read_attachment(const SectionReader& reader, const BaseMesh& mesh, Scene& scene) {
  SceneAttachment attachment;
  attachment.name = reader.text("name");
  const auto is_taken = [&](const SceneAttachment& other) { return other.name == attachment.name; };
  if (mesh.surfaces.contains(attachment.name) || std::ranges::any_of(scene.attachments, is_taken))
    reader.refuse("name", "found \"" + quoted_excerpt(attachment.name) +
                              "\", allowed a name that no other attachment and no surface has");
  attachment.where = read_selection(reader);
  const bool springs = reader.text("hold") == "springs";
  if (springs && !reader.has("stiffness")) reader.refuse_missing("stiffness", "needed with hold = \"springs\"");
  if (!springs && reader.has("stiffness"))
    reader.refuse("stiffness", "found without hold = \"springs\", allowed only with it");
  if (springs) attachment.stiffness = reader.number("stiffness");
  attachment.displacement = reader.vector("displacement");
  attachment.course = read_motion(reader, attachment.displacement);

  const Selected selected = select(mesh, attachment);
  if (selected.numbers.empty())
    reader.refuse(reach_key(attachment.where),
                  std::string("found no ") +
                      (springs || attachment.where.index() == 2 ? "centre of a piece of the "
                                                                  "surface"
                                                                : "node of the base mesh") +
                      " there, the nearest one is " + plain_number(selected.nearest_outside) +
                      " outside of it; allowed a region with at least one");
  scene.attachments.push_back(std::move(attachment));
}

std::optional<Course> read_course(const SectionReader& reader) {
  if (!reader.has("course")) {
    if (reader.has("period")) reader.refuse("period", "found without course, allowed only with it");
    return {};
  }
  LinearCourse course;
  course.points = reader.course("course");
  if (reader.has("period")) {
    course.period = reader.number("period");
    const double length = course.points.back()[0] - course.points.front()[0];
    if (!(course.period >= length))
      reader.refuse("period", "found " + plain_number(course.period) +
                                  ", allowed at least the time from the first to the "
                                  "last point of the course, " +
                                  plain_number(length));
  }
  const bool still =
      reader.vector("displacement").isZero(0.0) && (!reader.knows("gradient") || reader.matrix("gradient").isZero(0.0));
  if (still)
    reader.refuse("course", reader.knows("gradient")
                                ? "found without a displacement or gradient to multiply, allowed only with one of them"
                                : "found without a displacement to multiply, allowed only with one");
  return course;
}

}  // namespace finegauge
