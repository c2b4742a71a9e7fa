#include "release_detector.h"

namespace tfsat {
namespace sequencer {

void ReleaseDetector::reset(tick_t now, uint16_t knocks) {
  open_ = 0;
  opening_ = false;
  touched_ = false;
  released_ = false;
  disagrees_ = false;
  lost_ = false;
  last_change_ = now;
  knocks_ = knocks;
}

ReleaseDetector::Verdict ReleaseDetector::on_edge(const SwitchEdge& edge) {
  if (edge.lost) lose_edges(edge.at);
  const uint8_t bit = static_cast<uint8_t>(1 << edge.index);
  return change(static_cast<uint8_t>(edge.open ? open_ | bit : open_ & ~bit), edge.at);
}

// Since the last change the switches may have been anything. Before both were seen open, the robot may
// have left from then on; after it, it may have hung again and left later.
void ReleaseDetector::lose_edges(tick_t until) {
  if (!opening_) {
    if (!lost_) lost_since_ = last_change_;
    lost_ = true;
  } else if (!settled_) {
    if (until - last_change_ >= kHungTicks) hung_ = true;
    last_ = until;
  }
  last_change_ = until;
}

ReleaseDetector::Verdict ReleaseDetector::poll(tick_t now, uint8_t levels_open) {
  if (levels_open == open_) {
    disagrees_ = false;
  } else if (!disagrees_) {
    disagrees_ = true;
    disagree_since_ = now;
  } else if (now - disagree_since_ >= kLevelTicks) {
    return change(levels_open, disagree_since_);
  }
  return judge(now);
}

ReleaseDetector::Verdict ReleaseDetector::change(uint8_t open, tick_t at) {
  if (open == open_) return Verdict::kNone;
  const Verdict verdict = judge(at);
  open_ = open;
  disagrees_ = false;
  last_change_ = at;
  if (open != 0) touched_ = true;
  if (opening_ && !released_) ++bounces_;
  if (open == kBoth) note_both_open(at);
  return verdict;
}

// What the switches are now, they have been since the last change.
ReleaseDetector::Verdict ReleaseDetector::judge(tick_t until) {
  // An edge may be stamped after `until` was read.
  if (tick_before(until, last_change_)) return Verdict::kNone;
  const uint32_t stood = until - last_change_;
  if (open_ == 0 && stood >= kHungTicks && !settled_) hung_ = true;
  if (stood < kDebounceTicks) return Verdict::kNone;
  if (open_ == kBoth) return judge_open(stood);
  if (stood >= kChatterTicks && !released_) opening_ = lost_ = false;
  return open_ == 0 ? judge_closed(stood) : Verdict::kNone;
}

ReleaseDetector::Verdict ReleaseDetector::judge_open(uint32_t stood) {
  if (stood >= kChatterTicks) settled_ = true;
  if (released_) return Verdict::kNone;
  released_ = true;
  return Verdict::kReleased;
}

ReleaseDetector::Verdict ReleaseDetector::judge_closed(uint32_t stood) {
  if (!released_) {
    opening_ = lost_ = false;
    if (touched_ && knocks_ != UINT16_MAX) ++knocks_;
    touched_ = false;
  } else if (stood >= kSeatedTicks) {
    released_ = false;
    opening_ = false;
    touched_ = false;
    return Verdict::kFalseRelease;
  }
  return Verdict::kNone;
}

void ReleaseDetector::note_both_open(tick_t at) {
  if (released_) {
    if (!settled_) last_ = at;
    return;
  }
  const bool anew = !opening_;
  last_ = at;
  settled_ = false;
  opening_ = true;
  if (anew || at - released_at_ > kBounceTicks) {
    released_at_ = at;
    bounces_ = 1;
  }
  if (anew) {
    hung_ = lost_;
    first_ = lost_ ? lost_since_ : at;
    lost_ = false;
  }
  if (at - first_ > kChatterTicks) first_ = at - kChatterTicks;
}

}  // namespace sequencer
}  // namespace tfsat
