// One recording after another: capture in the interrupt, card in the main loop, states between
// them.
//
// Whatever the card does, capture goes on. While it is busy or gone the ring fills. When it has
// failed, or there was none from the start, the ring keeps the newest seconds, and stops when the
// robot has landed: the drop stays in RAM until the power goes or a host has fetched it. A recording
// whose card is gone ends when RAM would lose the drop; the card is tried on.
#pragma once

#include "block_builder.h"
#include "card_writer.h"
#include "drop_watch.h"
#include "spsc_queue.h"

namespace tfsat {
namespace logger {

// Events on their way into the log. The worst chatter of a release leaves half of it empty.
typedef SpscQueue<protocol::Event, 256> EventQueue;

class Recorder {
 public:
  Recorder(Block* ring_blocks, uint32_t ring_capacity, BlockSink& sink);

  struct Plan {
    uint32_t session;  // not 0
    protocol::LogHeader header;
    uint64_t unix_at_zero_us;  // 0: nobody has set the clock
    uint32_t file_blocks;
    uint16_t after_landing_s;
  };

  // Main loop. Starts a recording under a number; the number of the present or last recording
  // starts nothing. When the card refuses, the state is failed with its error, and capture goes on
  // in RAM. Errors: kWrongState while another recording runs, kRamHoldsDrop.
  protocol::ErrorCode start(uint32_t number, const Plan& plan);
  // Main loop. A recording goes on in another file, under the same number, when its file is full
  // before a release (a robot may wait for long), and when it closed by itself and the robot hangs
  // in its switches: what looked like a drop was none, or the next one is being prepared.
  bool wants_next_file() const {
    return goes_on_ && state_ == protocol::LoggerState::kStopped;
  }
  void start_next_file(const Plan& plan);
  // Interrupt. This file goes on with what the one before has begun.
  bool continued() const { return continued_; }
  // Interrupt. The switches are followed: while recording, and between two files.
  bool watching() const { return capturing() || goes_on_; }
  // The number belongs to the present or last recording.
  bool knows(uint32_t number) const { return session() != 0 && number == number_; }
  // Main loop. Ends the recording; a second call changes nothing. Error: kNotRecording.
  protocol::ErrorCode stop();
  // Main loop. At most one block to the card.
  void poll(uint64_t t_us);

  // Interrupt. Takes the sample and up to a block of events from the queue.
  void capture(uint64_t t_us, const protocol::Sample& sample, EventQueue& events);
  // Interrupt. Samples go into the log.
  bool capturing() const { return capture_ != Capture::kOff; }
  // Interrupt. What happened to the card or to the drop, to be logged.
  bool take_event(protocol::Event& event) {
    return writer_.take_event(event) || watch_.take_event(event);
  }
  // Interrupt.
  DropWatch& watch() { return watch_; }

  // Main loop, while nothing is captured: what RAM holds, block by block.
  uint32_t ram_blocks() const;
  bool copy_from_ram(uint32_t index, Block& out) const;
  // RAM holds a drop that no card has.
  bool ram_holds_drop() const;
  // Somebody has fetched it, or gives it up.
  void release_ram() { ram_released_ = true; }

  protocol::LoggerState state() const { return state_; }
  protocol::DropPhase phase() const { return watch_.phase(); }
  protocol::ErrorCode error() const { return error_; }
  // Why the card takes nothing now, or kNone.
  protocol::ErrorCode card_trouble() const { return writer_.trouble(); }
  // A file of the card is in use.
  bool uses_card() const {
    return state_ == protocol::LoggerState::kRecording ||
           state_ == protocol::LoggerState::kStopping;
  }
  uint32_t session() const { return plan_.session; }
  // Of the present or last recording.
  const protocol::LogHeader& header() const { return plan_.header; }
  uint32_t samples() const { return builder_.samples(); }
  uint32_t samples_dropped() const { return builder_.samples_dropped(); }
  uint32_t blocks_written() const { return writer_.blocks_written(); }
  uint32_t ring_blocks() const { return ring_.waiting(); }
  uint32_t ring_peak_blocks() const { return ring_.peak(); }

 private:
  // Who owns the builder: the interrupt, unless capture is off. kNewest: RAM only, the oldest block
  // makes room.
  enum class Capture : uint8_t { kOff, kOn, kNewest, kFinishing };
  static constexpr uint8_t kQuarters = 4;
  // One instant begins no more blocks: a header, a data block of samples, one of events, and one to
  // spare.
  static constexpr uint32_t kBlocksAnInstant = 4;
  // Nothing is captured between two files: a card that is gone for longer ends that.
  static constexpr uint32_t kChangeLimitUs = 1000000;
  // The second copy begins no later than with so much room: 0.2 s at 1 kHz for the card to begin.
  static constexpr uint32_t kRewriteSpareBlocks = 32;

  protocol::ErrorCode open(const Plan& plan);
  void end(protocol::StopReason reason);
  void follow_drop(uint64_t t_us);
  void keep_fall(uint64_t t_us);
  bool no_room_behind_drop(uint32_t spare_blocks) const;
  uint32_t block_before(uint64_t t_us) const;
  void write_fall_again();
  void follow_file();
  void finish(uint64_t t_us);
  void fail(protocol::ErrorCode error);
  void note_high_water(uint64_t t_us, EventQueue& events);

  BlockRing ring_;
  BlockBuilder builder_;
  CardWriter writer_;
  DropWatch watch_;
  Plan plan_ = {};
  std::atomic<Capture> capture_{Capture::kOff};
  protocol::LoggerState state_ = protocol::LoggerState::kIdle;
  protocol::ErrorCode error_ = protocol::ErrorCode::kNone;
  protocol::StopReason stop_reason_ = protocol::StopReason::kHost;
  uint32_t number_ = 0;
  uint32_t file_reserve_blocks_ = 0;  // for the second copy
  uint32_t file_spare_blocks_ = 0;    // for a drop: with less, a robot that waits gets another file
  bool footer_added_ = false;
  bool ram_released_ = false;

  // The drop as the main loop has followed it.
  protocol::DropPhase followed_ = protocol::DropPhase::kWaiting;
  uint32_t releases_followed_ = 0;
  uint64_t released_us_ = 0;
  uint64_t landed_us_ = 0;
  bool fall_kept_ = false;

  // Both. The first block of the drop: from a second before the release. While the card may not
  // have it twice and takes nothing, capture ends rather than overwrite it in RAM.
  std::atomic<uint32_t> drop_first_block_{0};
  std::atomic<bool> drop_only_in_ram_{false};

  // Both. Another file follows this one.
  std::atomic<bool> goes_on_{false};
  std::atomic<bool> continued_{false};  // another came before

  // Interrupt.
  uint8_t high_water_quarters_ = 0;
};

}  // namespace logger
}  // namespace tfsat
