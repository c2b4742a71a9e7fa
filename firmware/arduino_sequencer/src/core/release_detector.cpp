#include "release_detector.h"

namespace tfsat {
namespace sequencer {

void ReleaseDetector::reset(tick_t now, uint16_t knocks) {
  open_ = 0;
  opening_ = false;
  touched_ = false;
  disagrees_ = false;
  released_ = false;
  last_change_ = now;
  knocks_ = knocks;
}

void ReleaseDetector::on_edge(const SwitchEdge& edge) {
  const uint8_t bit = static_cast<uint8_t>(1 << edge.index);
  change(static_cast<uint8_t>(edge.open ? open_ | bit : open_ & ~bit), edge.at);
}

void ReleaseDetector::change(uint8_t open, tick_t at) {
  if (open == open_) return;
  // The loop may have been away for longer than the debounce.
  if (!tick_before(at, last_change_ + kDebounceTicks)) judge();
  if (released_) return;
  open_ = open;
  disagrees_ = false;
  last_change_ = at;
  if (open != 0) touched_ = true;
  if (opening_) ++bounces_;
  if (opening_ && at - both_open_since_first_ > kChatterTicks) opening_ = false;
  if (open == kBoth && !opening_) {
    opening_ = true;
    both_open_since_first_ = at;
    bounces_ = 1;
  }
}

bool ReleaseDetector::poll(tick_t now, uint8_t levels_open) {
  if (levels_open == open_) {
    disagrees_ = false;
  } else if (!disagrees_) {
    disagrees_ = true;
    disagree_since_ = now;
  } else if (now - disagree_since_ >= kLevelTicks) {
    change(levels_open, disagree_since_);
  }
  // An edge stamped after `now` was read is not old yet.
  if (!tick_before(now, last_change_ + kDebounceTicks)) judge();
  const bool released = released_;
  released_ = false;
  return released;
}

// What the switches are now, they have been for the debounce.
void ReleaseDetector::judge() {
  if (released_) return;
  if (open_ == kBoth && opening_) {
    released_ = true;
    touched_ = false;
  } else if (open_ == 0 && touched_) {
    touched_ = false;
    ++knocks_;
  }
  // Unless it was the release: whatever both did before was chatter of a knock.
  opening_ = false;
}

}  // namespace sequencer
}  // namespace tfsat
