// One recording after another: capture in the interrupt, card in the main loop, states between
// them.
//
// Whatever the card does, capture goes on: while it is busy or gone the ring fills, when it has
// failed the ring keeps what it holds, and samples that find no room are counted.
#pragma once

#include "block_builder.h"
#include "card_writer.h"
#include "spsc_queue.h"

namespace tfsat {
namespace logger {

// Events on their way into the log.
typedef SpscQueue<protocol::Event, 64> EventQueue;

class Recorder {
 public:
  Recorder(Block* ring_blocks, uint32_t ring_capacity, BlockSink& sink);

  // Main loop. Starts a recording under a number; the number of the present or last recording
  // starts nothing. `session` must not be 0. Errors: kWrongState while another recording runs, and
  // what the card says; then the number is not used up.
  protocol::ErrorCode start(uint32_t number, uint32_t session, const protocol::LogHeader& header,
                            uint32_t file_blocks);
  // The number belongs to the present or last recording.
  bool knows(uint32_t number) const { return session_ != 0 && number == number_; }
  // Main loop. Ends the recording; a second call changes nothing. Error: kNotRecording.
  protocol::ErrorCode stop();
  // Main loop. At most one block to the card.
  void poll(uint64_t t_us);

  // Interrupt. Takes the sample and up to a block of events from the queue.
  void capture(uint64_t t_us, const protocol::Sample& sample, EventQueue& events);
  // Interrupt. Samples go into the log.
  bool capturing() const { return capture_ != Capture::kOff; }
  // Interrupt. A stall of the card to be logged.
  bool take_card_event(protocol::Event& event);

  protocol::LoggerState state() const { return state_; }
  protocol::ErrorCode error() const { return error_; }
  uint32_t session() const { return session_; }
  uint32_t samples() const { return builder_.samples(); }
  uint32_t samples_dropped() const { return builder_.samples_dropped(); }
  uint32_t blocks_written() const { return writer_.blocks_written(); }
  uint32_t ring_blocks() const { return ring_.waiting(); }
  uint32_t ring_peak_blocks() const { return ring_.peak(); }

 private:
  // Who owns the builder: the interrupt, unless capture is off.
  enum class Capture : uint8_t { kOff, kOn, kFinishing };

  void finish(uint64_t t_us);
  void fail(protocol::ErrorCode error);

  BlockRing ring_;
  BlockBuilder builder_;
  CardWriter writer_;
  SpscQueue<protocol::Event, 4> card_events_;
  std::atomic<Capture> capture_{Capture::kOff};
  protocol::LoggerState state_ = protocol::LoggerState::kIdle;
  protocol::ErrorCode error_ = protocol::ErrorCode::kNone;
  uint32_t number_ = 0;
  uint32_t session_ = 0;
  bool footer_added_ = false;
};

}  // namespace logger
}  // namespace tfsat
