// A motion from rest to rest, leg by leg, as a hand makes it.
#pragma once

#include <vector>

#include "jet.h"

namespace tfsat {
namespace emulator {

struct Leg {
  double target_rad;
  double duration_s;  // more than 0
  double rest_s;      // at the target, afterwards; 0: the next leg follows at once
};

class LegPath {
 public:
  LegPath() = default;  // stays at 0
  // Rests at `start_rad` for `lead_s`, then goes the legs.
  LegPath(double start_rad, double lead_s, const std::vector<Leg>& legs);

  Jet at(double t_s) const;
  // How much of a hand's unrest shows: 0 while the path rests, 1 on its way.
  Jet unrest(double t_s) const;
  double duration_s() const { return duration_s_; }

 private:
  struct Piece {
    double start_s, duration_s, from_rad, by_rad;
  };
  // Legs without a rest between them.
  struct Run {
    double start_s, end_s;
  };
  double start_rad_ = 0.0, duration_s_ = 0.0;
  std::vector<Piece> pieces_;
  std::vector<Run> runs_;
};

// How long unrest takes to grow and to fade.
constexpr double kUnrestFade_s = 0.4;

}  // namespace emulator
}  // namespace tfsat
