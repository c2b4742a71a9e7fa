// Tells a release from a bounce and from a knock.
//
// A release is: both switches open, and both open without interruption for the debounce time, seen
// from a state in which both were closed. Its time is the first edge at which both were open: the
// contacts may chatter after that, but the robot has left at the first. One switch alone never
// starts anything (a knock during the lift, a broken wire); both open for less than the debounce,
// then closed again for as long, is counted as a knock. Contacts that go on chattering for longer
// than any release does start anew, so that a shaken robot's time never begins long before its
// release.
#ifndef TFSAT_RELEASE_RELEASE_DETECTOR_H
#define TFSAT_RELEASE_RELEASE_DETECTOR_H

#include "../protocol/messages.h"
#include "switch_edge.h"

namespace tfsat {
namespace sequencer {

class ReleaseDetector {
 public:
  // Starts watching; both switches must be closed now. Goes on counting knocks from `knocks`.
  void reset(tick_t now, uint16_t knocks);
  void on_edge(const SwitchEdge& edge);
  // Call often, after the edges, with the switches' present levels. True once, when a release is
  // certain.
  bool poll(tick_t now, uint8_t levels_open);
  // Time of the release that poll() told.
  tick_t released_at() const { return both_open_since_first_; }
  uint16_t knocks() const { return knocks_; }
  // Edges of both switches since released_at(), its own included.
  uint16_t bounces() const { return bounces_; }

 private:
  static constexpr uint32_t kDebounceTicks = protocol::kReleaseDebounceUs * kTicksPerUs;
  static constexpr uint32_t kChatterTicks = protocol::kReleaseChatterUs * kTicksPerUs;
  // An edge that hardware could not stamp is believed when the level has stood this long and no other
  // edge has come meanwhile.
  static constexpr uint32_t kLevelTicks = 1 * kTicksPerMs;
  static constexpr uint8_t kBoth = 3;

  void change(uint8_t open, tick_t at);
  void judge();

  tick_t both_open_since_first_ = 0;  // first edge of this opening
  tick_t last_change_ = 0;
  tick_t disagree_since_ = 0;
  uint16_t knocks_ = 0;
  uint16_t bounces_ = 0;
  uint8_t open_ = 0;
  bool opening_ = false;  // both have been open since both were last closed for long
  bool touched_ = false;  // at least one has been open since
  bool disagrees_ = false;
  bool released_ = false;  // certain, and not told yet
};

}  // namespace sequencer
}  // namespace tfsat

#endif
