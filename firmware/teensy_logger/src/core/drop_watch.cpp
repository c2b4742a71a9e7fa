#include "drop_watch.h"

namespace tfsat {
namespace logger {

using protocol::DropPhase;
using protocol::EventCode;

namespace {

constexpr float kEndOfRangeCounts = 32767.0f;

// The release rule counts in the sequencer's ticks, which wrap; it only looks at differences.
sequencer::tick_t ticks(uint64_t t_us) {
  return sequencer::ticks_from_us(static_cast<uint32_t>(t_us));
}

}  // namespace

void DropWatch::reset(float counts_per_g) {
  const float shock = counts_per_g * static_cast<float>(protocol::kLandingShockG);
  counts_per_g_ = counts_per_g;
  shock_counts_ = static_cast<uint32_t>(shock < kEndOfRangeCounts ? shock : kEndOfRangeCounts);
  phase_ = DropPhase::kWaiting;
  releases_ = 0;
  hangs_ = false;
  closed_ = false;
  seated_ = false;
  events_.clear();
}

void DropWatch::on_edge(const Edge& edge) {
  if (!seated_ || edge.source != Edge::Source::kSwitch) return;
  const uint8_t bit = static_cast<uint8_t>(1u << edge.index);
  moved_ = static_cast<uint8_t>(moved_ | bit);
  open_by_edges_ = static_cast<uint8_t>(edge.open ? open_by_edges_ | bit : open_by_edges_ & ~bit);
  heed(detector_.on_edge(sequencer::SwitchEdge{ticks(edge.t_us), edge.index, edge.open, false}), edge.t_us);
}

void DropWatch::poll(uint64_t t_us, uint8_t switches_open, uint32_t peak_counts) {
  note_seated(t_us, switches_open);
  if (phase() != DropPhase::kLanded) watch_switches(t_us, switches_open);
  if (phase() == DropPhase::kFalling) note_landing(t_us, peak_counts);
}

// A recording may begin before the robot is seated.
void DropWatch::note_seated(uint64_t t_us, uint8_t switches_open) {
  if (switches_open != 0) {
    closed_ = false;
    hangs_ = false;
    return;
  }
  if (!closed_) {
    closed_ = true;
    closed_since_us_ = t_us;
  }
  const uint64_t closed_us = t_us - closed_since_us_;
  hangs_ = closed_us >= protocol::kReleaseSeatedUs;
  if (seated_ || closed_us < protocol::kReleaseDebounceUs) return;
  detector_.reset(ticks(t_us), 0);
  moved_ = 0;
  seated_ = true;
}

// The pins are read after the edges were taken: a switch that chatters may have moved again, and
// that edge is still to come. Its level tells of a missed edge only at an instant without one.
void DropWatch::watch_switches(uint64_t t_us, uint8_t switches_open) {
  const uint8_t open = static_cast<uint8_t>((switches_open & ~moved_) | (open_by_edges_ & moved_));
  moved_ = 0;
  if (seated_) heed(detector_.poll(ticks(t_us), open), t_us);
}

void DropWatch::heed(sequencer::ReleaseDetector::Verdict verdict, uint64_t t_us) {
  using Verdict = sequencer::ReleaseDetector::Verdict;
  if (verdict == Verdict::kReleased && phase() == DropPhase::kWaiting) {
    const uint32_t ago_ticks = ticks(t_us) - detector_.released_at();
    released_us_ = t_us - sequencer::us_from_ticks(ago_ticks);
    released_low_us_ = static_cast<uint32_t>(released_us_);
    releases_.store(releases() + 1, std::memory_order_release);
    phase_ = DropPhase::kFalling;
    note(released_us_, EventCode::kRelease, 1, 0);
  } else if (verdict == Verdict::kFalseRelease && phase() == DropPhase::kFalling) {
    phase_ = DropPhase::kWaiting;
    note(released_us_, EventCode::kRelease, 0, 0);
  }
}

void DropWatch::note_landing(uint64_t t_us, uint32_t peak_counts) {
  const uint64_t fallen_us = t_us - released_us_;
  const bool shock = peak_counts >= shock_counts_ && fallen_us >= protocol::kLandingEarliestUs;
  if (!shock && fallen_us < protocol::kLandingLatestUs) return;
  phase_ = DropPhase::kLanded;
  const float mg = static_cast<float>(peak_counts) * 1000.0f / counts_per_g_;
  note(t_us, EventCode::kLanding, shock ? 1 : 0, shock ? static_cast<int32_t>(mg) : 0);
}

void DropWatch::note(uint64_t t_us, EventCode code, uint16_t arg, int32_t value) {
  protocol::Event event = {};
  event.time_us = t_us;
  event.code = code;
  event.arg = arg;
  event.value = value;
  events_.push(event);
}

bool DropWatch::take_event(protocol::Event& event) {
  const protocol::Event* oldest = events_.front();
  if (oldest == nullptr) return false;
  event = *oldest;
  events_.pop();
  return true;
}

}  // namespace logger
}  // namespace tfsat
