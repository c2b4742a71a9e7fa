// The emulated card behind the ports of the logger's core: the file of a recording, and the files
// that are there already. Blocks take the processor's time, as with SdFat's programmed transfers.
#pragma once

#include <algorithm>

#include "../../../../firmware/teensy_logger/src/core/ports.h"
#include "../card/block_device.h"

namespace tfsat {
namespace emulator {

class CardPort final : public logger::BlockSink, public logger::LogArchive {
 public:
  explicit CardPort(BlockDevice& card) : card_(card) {}

  protocol::ErrorCode open(uint32_t n_blocks) override {
    filled_ = 0;
    prepared_ = 0;
    started_ = card_.insertions();
    return error_of(card_.preallocate(n_blocks));
  }
  bool busy(uint64_t t_us) override {
    t_us_ = t_us;
    return lost() ? busy_when_gone_ : card_.busy(world_us());
  }
  protocol::ErrorCode prepare() override {
    if (lost()) return protocol::ErrorCode::kCardWriteFailed;
    const uint32_t count = std::min(kFillBlocks, card_.n_blocks() - filled_);
    const protocol::ErrorCode error = error_of(card_.fill(world_us()));
    if (error != protocol::ErrorCode::kNone) return error;
    take_processor(count);
    filled_ += count;
    const bool whole = filled_ == card_.n_blocks();
    if (whole || filled_ - prepared_ >= kStepBlocks) prepared_ = filled_;
    return error;
  }
  uint32_t prepared_blocks() override { return prepared_; }
  protocol::ErrorCode recover(uint64_t t_us) override {
    t_us_ = t_us;
    if (!card_.present()) return protocol::ErrorCode::kNoCard;
    started_ = card_.insertions();
    filled_ = prepared_;
    return protocol::ErrorCode::kNone;
  }
  protocol::ErrorCode write(uint32_t index, const uint8_t* block) override {
    if (lost()) return protocol::ErrorCode::kCardWriteFailed;
    take_processor(1);
    return error_of(card_.write(world_us(), index, block));
  }
  protocol::ErrorCode sync() override {
    return lost() ? protocol::ErrorCode::kCardWriteFailed : error_of(card_.sync(world_us()));
  }
  protocol::ErrorCode close(uint32_t n_blocks) override {
    return lost() ? protocol::ErrorCode::kCardWriteFailed : error_of(card_.truncate(n_blocks));
  }
  protocol::ErrorCode inspect(uint32_t n_blocks) override {
    return counted() ? error_of(card_.inspect(n_blocks)) : protocol::ErrorCode::kBusy;
  }
  uint32_t free_mib() override { return card_.free_blocks() / 2048; }

  bool find(uint16_t from, uint16_t& number, uint32_t& n_blocks) override {
    return card_.find(from, number, n_blocks);
  }
  protocol::ErrorCode read(uint16_t number, uint32_t index, uint8_t* block) override {
    return log_error_of(card_.read(number, index, block));
  }
  protocol::ErrorCode erase(uint16_t number) override { return log_error_of(card_.erase(number)); }

  // A card without contact refuses transfers, or looks busy, as SdFat has it for one that does not answer.
  void set_busy_when_gone(bool busy) { busy_when_gone_ = busy; }
  void set_powered_at(uint64_t t_us) { powered_us_ = t_us; }
  // The main loop has got so far.
  void set_now(uint64_t t_us) { t_us_ = t_us; }
  // What the processor has spent on blocks since it was asked last, in us.
  uint64_t take_processor_us() {
    const uint64_t us = processor_ns_ / 1000;
    processor_ns_ %= 1000;
    return us;
  }

 private:
  // As drivers/sd_block_sink.cpp has them.
  static constexpr uint32_t kFillBlocks = 16;
  static constexpr uint32_t kStepBlocks = 256;

  // A card that was out of its contacts must be started anew, by opening a file or by recover().
  bool lost() const { return started_ != 0 && (!card_.present() || started_ != card_.insertions()); }
  // A card's free room is counted when the board meets it.
  bool counted() {
    if (!card_.present()) return true;
    if (met_ != card_.insertions()) {
      met_ = card_.insertions();
      counted_us_ = t_us_ + card_.parameters().mount_us;
    }
    return t_us_ >= counted_us_;
  }
  void take_processor(uint32_t blocks) { processor_ns_ += blocks * card_.parameters().transfer_ns; }
  uint64_t world_us() const { return powered_us_ + t_us_; }
  static protocol::ErrorCode error_of(CardResult result) {
    using protocol::ErrorCode;
    switch (result) {
      case CardResult::kOk: return ErrorCode::kNone;
      case CardResult::kAbsent: return ErrorCode::kNoCard;
      case CardResult::kOutOfRange: return ErrorCode::kCardFull;
      case CardResult::kWriteProtected: return ErrorCode::kCardWriteProtected;
      case CardResult::kUnreadable: return ErrorCode::kCardUnreadable;
      case CardResult::kBusy:
      case CardResult::kFailed: break;
    }
    return ErrorCode::kCardWriteFailed;
  }
  static protocol::ErrorCode log_error_of(CardResult result) {
    return result == CardResult::kOutOfRange ? protocol::ErrorCode::kNoSuchLog : error_of(result);
  }

  BlockDevice& card_;
  uint32_t filled_ = 0;    // of the newest file
  uint32_t prepared_ = 0;  // in whole steps
  uint32_t met_ = 0;       // which insertion
  uint32_t started_ = 0;   // and which was started; 0: none yet
  bool busy_when_gone_ = false;
  uint64_t counted_us_ = 0;
  uint64_t processor_ns_ = 0;
  uint64_t powered_us_ = 0;
  uint64_t t_us_ = 0;
};

}  // namespace emulator
}  // namespace tfsat
