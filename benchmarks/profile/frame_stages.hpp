#pragma once

#include <array>

#include "core/tissue_frame.hpp"

namespace finegauge {

/// The stages of a moving frame, in the order of FrameTimes.
enum class FrameStage { assemble, needle, contact, solve, update, estimate, mark, topology, transfer };
inline constexpr int frame_stage_count = 9;
struct NamedStage {
  const char* name;
  double FrameTimes::*time;
};
inline constexpr std::array<NamedStage, frame_stage_count> frame_stages = {{{"assemble", &FrameTimes::assemble_ms},
                                                                            {"needle", &FrameTimes::needle_ms},
                                                                            {"contact", &FrameTimes::contact_ms},
                                                                            {"solve", &FrameTimes::solve_ms},
                                                                            {"update", &FrameTimes::update_ms},
                                                                            {"estimate", &FrameTimes::estimate_ms},
                                                                            {"mark", &FrameTimes::mark_ms},
                                                                            {"topology", &FrameTimes::topology_ms},
                                                                            {"transfer", &FrameTimes::transfer_ms}}};

}  // namespace finegauge
