// What the card is like while nothing is recorded, so that a missing one shows before the drop.
#pragma once

#include "ports.h"

namespace tfsat {
namespace logger {

class CardWatch {
 public:
  static constexpr uint32_t kPeriodUs = 2000000;

  explicit CardWatch(BlockSink& sink) : sink_(sink) {}

  // Main loop, while no file is open: looks at the card when it is time to.
  void poll(uint64_t t_us, uint32_t file_blocks) {
    if (t_us < next_us_) return;
    next_us_ = t_us + kPeriodUs;
    const protocol::ErrorCode error = sink_.inspect(file_blocks);
    if (error == protocol::ErrorCode::kBusy) look_again();
    state_ = state_of(error);
  }
  // The card's contents have changed: look at once.
  void look_again() { next_us_ = 0; }

  protocol::CardState state() const { return state_; }

  static protocol::CardState state_of(protocol::ErrorCode error) {
    using protocol::CardState;
    using protocol::ErrorCode;
    switch (error) {
      case ErrorCode::kNone: return CardState::kReady;
      case ErrorCode::kBusy: return CardState::kUnknown;
      case ErrorCode::kNoCard: return CardState::kMissing;
      case ErrorCode::kCardFull: return CardState::kFull;
      case ErrorCode::kCardUnreadable: return CardState::kUnreadable;
      case ErrorCode::kCardWriteProtected: return CardState::kWriteProtected;
      default: return CardState::kFailing;
    }
  }

 private:
  BlockSink& sink_;
  uint64_t next_us_ = 0;
  protocol::CardState state_ = protocol::CardState::kUnknown;
};

}  // namespace logger
}  // namespace tfsat
