// Copied from firmware/arduino_sequencer/src/core/release_detector.h by tools/generate_protocol.py.
// Tells a release from a bounce, a knock and a false release: the rule of protocol/tfsat.toml, [release].
//
// A pure function of the stamped edges: when poll() is called decides only how soon it is told.
#ifndef TFSAT_RELEASE_RELEASE_DETECTOR_H
#define TFSAT_RELEASE_RELEASE_DETECTOR_H

#include "../protocol/messages.h"
#include "switch_edge.h"

namespace tfsat {
namespace sequencer {

class ReleaseDetector {
 public:
  enum class Verdict : uint8_t { kNone, kReleased, kFalseRelease };

  // Starts watching; both switches must be closed now. Goes on counting knocks from `knocks`.
  void reset(tick_t now, uint16_t knocks);
  // In order of time. What is certain by the time of this edge.
  Verdict on_edge(const SwitchEdge& edge);
  // Call often, after the edges, with the switches' present levels.
  Verdict poll(tick_t now, uint8_t levels_open);

  // Of the last release: t = 0 of the schedule.
  tick_t released_at() const { return released_at_; }
  // Ticks before and after released_at() between which the robot may have left; 0 where the edges fit
  // one release only, and none was lost that could be it. Both may grow until both switches have been open for release_chatter_us.
  uint32_t earlier_ticks() const { return ambiguous() ? released_at_ - first_ : 0; }
  uint32_t later_ticks() const { return ambiguous() ? last_ - released_at_ : 0; }
  // Edges of both switches from released_at(), its own included, to when it was certain; lost ones
  // are not counted.
  uint16_t bounces() const { return bounces_; }
  uint16_t knocks() const { return knocks_; }

 private:
  static constexpr uint32_t kDebounceTicks = protocol::kReleaseDebounceUs * kTicksPerUs;
  static constexpr uint32_t kBounceTicks = protocol::kReleaseBounceUs * kTicksPerUs;
  static constexpr uint32_t kHungTicks = protocol::kReleaseHungUs * kTicksPerUs;
  static constexpr uint32_t kChatterTicks = protocol::kReleaseChatterUs * kTicksPerUs;
  static constexpr uint32_t kSeatedTicks = protocol::kReleaseSeatedUs * kTicksPerUs;
  // An edge that hardware could not stamp is believed when the level has stood this long and no other
  // edge has come meanwhile.
  static constexpr uint32_t kLevelTicks = 1 * kTicksPerMs;
  static constexpr uint8_t kBoth = 3;

  bool ambiguous() const { return hung_ || last_ - first_ > kBounceTicks; }
  void lose_edges(tick_t until);
  Verdict change(uint8_t open, tick_t at);
  Verdict judge(tick_t until);
  Verdict judge_open(uint32_t stood);
  Verdict judge_closed(uint32_t stood);
  void note_both_open(tick_t at);

  // No initial values: `ReleaseDetector detector{}` is all zeros, by one loop instead of byte for byte.
  tick_t released_at_;
  tick_t first_;  // both open for the first time, at most kChatterTicks before the last
  tick_t last_;   // both open for the last time before settled_
  tick_t last_change_;
  tick_t disagree_since_;
  tick_t lost_since_;
  uint16_t knocks_;
  uint16_t bounces_;
  uint8_t open_;
  bool opening_;   // both have been open, and may have been since the release
  bool hung_;      // the robot may have, between first_ and last_
  bool touched_;   // at least one has been open since both were last closed for long
  bool released_;  // and no false release since
  bool settled_;   // later edges say nothing of the release any more
  bool disagrees_;
  bool lost_;  // edges from lost_since_ on, among which both may have been open first
};

}  // namespace sequencer
}  // namespace tfsat

#endif
