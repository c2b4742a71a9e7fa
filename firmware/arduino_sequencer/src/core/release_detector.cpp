#include "release_detector.h"

namespace tfsat {
namespace sequencer {

void ReleaseDetector::reset(tick_t now) {
  open_ = 0;
  opening_ = false;
  touched_ = false;
  disagrees_ = false;
  last_change_ = now;
  knocks_ = 0;
}

void ReleaseDetector::on_edge(const SwitchEdge& edge) {
  const uint8_t bit = static_cast<uint8_t>(1 << edge.index);
  change(static_cast<uint8_t>(edge.open ? open_ | bit : open_ & ~bit), edge.at);
}

void ReleaseDetector::change(uint8_t open, tick_t at) {
  if (open == open_) return;
  open_ = open;
  last_change_ = at;
  if (open != 0) touched_ = true;
  if (opening_ && at - both_open_since_first_ > kChatterTicks) opening_ = false;
  if (open == kBoth && !opening_) {
    opening_ = true;
    both_open_since_first_ = at;
  }
}

bool ReleaseDetector::poll(tick_t now, uint8_t levels_open) {
  if (levels_open == open_) {
    disagrees_ = false;
  } else if (!disagrees_) {
    disagrees_ = true;
    disagree_since_ = now;
  } else if (now - disagree_since_ >= kLevelTicks) {
    disagrees_ = false;
    change(levels_open, disagree_since_);
  }
  // An edge stamped after `now` was read is not old yet.
  if (tick_before(now, last_change_ + kDebounceTicks)) return false;
  if (open_ == kBoth && opening_) {
    opening_ = false;
    touched_ = false;
    return true;
  }
  if (open_ == 0 && touched_) {
    touched_ = false;
    opening_ = false;
    ++knocks_;
  }
  // One switch stays closed: whatever both did before was chatter of a knock.
  if (open_ != kBoth) opening_ = false;
  return false;
}

}  // namespace sequencer
}  // namespace tfsat
