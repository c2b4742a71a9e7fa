#include "leg_path.h"

#include <algorithm>

namespace tfsat {
namespace emulator {

LegPath::LegPath(double start_rad, double lead_s, const std::vector<Leg>& legs)
    : start_rad_(start_rad), duration_s_(lead_s) {
  double from_rad = start_rad;
  bool rested = true;
  for (const Leg& leg : legs) {
    const double end_s = duration_s_ + leg.duration_s;
    if (rested) runs_.push_back({duration_s_, end_s});
    runs_.back().end_s = end_s;
    pieces_.push_back({duration_s_, leg.duration_s, from_rad, leg.target_rad - from_rad});
    rested = leg.rest_s > 0.0;
    from_rad = leg.target_rad;
    duration_s_ = end_s + leg.rest_s;
  }
}

Jet LegPath::at(double t_s) const {
  // The last piece that has begun.
  const auto next = std::find_if(pieces_.begin(), pieces_.end(), [&](const Piece& p) { return p.start_s > t_s; });
  if (next == pieces_.begin()) return {start_rad_, 0.0, 0.0};
  const Piece& piece = *(next - 1);
  return Jet{piece.from_rad, 0.0, 0.0} + piece.by_rad * smooth_step(t_s - piece.start_s, piece.duration_s);
}

Jet LegPath::unrest(double t_s) const {
  for (const Run& run : runs_) {
    if (t_s <= run.start_s || t_s >= run.end_s) continue;
    const double fade_s = std::min(kUnrestFade_s, 0.5 * (run.end_s - run.start_s));
    const Jet left = smooth_step(run.end_s - t_s, fade_s);
    return smooth_step(t_s - run.start_s, fade_s) * Jet{left.value, -left.rate, left.acceleration};
  }
  return {};
}

}  // namespace emulator
}  // namespace tfsat
