#pragma once

#include "core/scene/scene.hpp"
#include "core/scene/section_reader.hpp"

namespace finegauge {

/// Adds an [[attachment]] to the scene; `mesh` is the base mesh with its surfaces and the regions known so far. One
/// that selects nothing is refused with the distance to the nearest candidate.
void read_attachment(const SectionReader& reader, const BaseMesh& mesh, Scene& scene);

/// The keys course and period of a section; none without a course.
std::optional<Course> read_course(const SectionReader& reader);

}  // namespace finegauge
