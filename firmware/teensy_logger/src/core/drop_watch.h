// Where in a drop the robot is: released by its switches, landed by its accelerometers or by time.
//
// The release, a false one included, follows the sequencer's own rule, by the sequencer's own code. The
// landing is only looked for after it, so no knock in the lift ends a recording; it is one for the rest
// of the recording, whatever switches the robot lies on.
#pragma once

#include <atomic>

#include "../release/release_detector.h"
#include "ports.h"
#include "spsc_queue.h"

namespace tfsat {
namespace logger {

class DropWatch {
 public:
  // A recording begins. `counts_per_g`: of the accelerometers; at the end of its range a sensor
  // shows a shock, too.
  void reset(float counts_per_g);
  // Interrupt. Edges come in order of time, before the poll() of the instant that took them.
  void on_edge(const Edge& edge);
  // Interrupt, at each instant. `peak_counts`: the greatest specific force on any axis.
  void poll(uint64_t t_us, uint8_t switches_open, uint32_t peak_counts);
  // Interrupt. The log of a fall goes on in another file, which must hold its release, too.
  void tell_release_again() {
    if (phase() == protocol::DropPhase::kFalling) {
      note(released_us_, protocol::EventCode::kRelease, 1, 0);
    }
  }
  // Interrupt. What happened, to be logged.
  bool take_event(protocol::Event& event);

  // Both.
  protocol::DropPhase phase() const { return phase_.load(std::memory_order_acquire); }
  // Both. Releases since reset(), those that were none included.
  uint32_t releases() const { return releases_.load(std::memory_order_acquire); }
  // Both switches have been closed for release_seated_us, at the last instant.
  bool seated() const { return hangs_.load(std::memory_order_relaxed); }
  // Both, after a release: its time, which must lie within 35 minutes of `t_us`.
  uint64_t released_us(uint64_t t_us) const {
    const uint32_t off =
        released_low_us_.load(std::memory_order_relaxed) - static_cast<uint32_t>(t_us);
    return t_us + static_cast<uint64_t>(int64_t{static_cast<int32_t>(off)});
  }

 private:
  void note_seated(uint64_t t_us, uint8_t switches_open);
  void watch_switches(uint64_t t_us, uint8_t switches_open);
  void heed(sequencer::ReleaseDetector::Verdict verdict, uint64_t t_us);
  void note_landing(uint64_t t_us, uint32_t peak_counts);
  void note(uint64_t t_us, protocol::EventCode code, uint16_t arg, int32_t value);

  sequencer::ReleaseDetector detector_{};
  SpscQueue<protocol::Event, 4> events_;
  std::atomic<protocol::DropPhase> phase_{protocol::DropPhase::kWaiting};
  float counts_per_g_ = 1.0f;
  uint32_t shock_counts_ = UINT32_MAX;
  uint64_t released_us_ = 0;
  std::atomic<uint32_t> releases_{0};
  std::atomic<bool> hangs_{false};
  std::atomic<uint32_t> released_low_us_{0};  // of released_us_: 64 bits could be read half-changed
  uint64_t closed_since_us_ = 0;
  uint8_t moved_ = 0;          // switches that had an edge since the last poll()
  uint8_t open_by_edges_ = 0;  // of these, which the last edge left open
  bool closed_ = false;  // both switches, since closed_since_us_
  bool seated_ = false;  // the detector watches
};

}  // namespace logger
}  // namespace tfsat
