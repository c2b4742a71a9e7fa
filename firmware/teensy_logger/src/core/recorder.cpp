#include "recorder.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::LoggerState;

Recorder::Recorder(Block* ring_blocks, uint32_t ring_capacity, BlockSink& sink)
    : ring_(ring_blocks, ring_capacity), builder_(ring_), writer_(ring_, sink) {}

ErrorCode Recorder::start(uint32_t number, uint32_t session, const protocol::LogHeader& header,
                          uint32_t file_blocks) {
  if (knows(number)) return ErrorCode::kNone;
  if (state_ == LoggerState::kRecording || state_ == LoggerState::kStopping) {
    return ErrorCode::kWrongState;
  }
  capture_ = Capture::kOff;  // a failed recording may still be capturing
  const ErrorCode error = writer_.open(file_blocks);
  if (error != ErrorCode::kNone) {
    fail(error);
    return error;
  }
  number_ = number;
  session_ = session;
  error_ = ErrorCode::kNone;
  footer_added_ = false;
  builder_.begin(session, header, file_blocks);
  state_ = LoggerState::kRecording;
  capture_ = Capture::kOn;
  return ErrorCode::kNone;
}

ErrorCode Recorder::stop() {
  if (session_ == 0) return ErrorCode::kNotRecording;
  if (state_ == LoggerState::kFailed) capture_ = Capture::kOff;
  if (state_ == LoggerState::kRecording) {
    state_ = LoggerState::kStopping;
    capture_ = Capture::kFinishing;
  }
  return ErrorCode::kNone;
}

void Recorder::poll(uint64_t t_us) {
  if (state_ != LoggerState::kRecording && state_ != LoggerState::kStopping) return;
  const ErrorCode error = writer_.poll(t_us);
  if (error != ErrorCode::kNone) {
    fail(error);
    return;
  }
  protocol::Event stall;
  if (writer_.take_stall(stall)) card_events_.push(stall);
  if (state_ == LoggerState::kRecording && builder_.file_full()) {
    error_ = ErrorCode::kCardFull;
    stop();
  }
  if (state_ == LoggerState::kStopping && capture_ == Capture::kOff) finish(t_us);
}

void Recorder::finish(uint64_t t_us) {
  if (!footer_added_) footer_added_ = builder_.add_footer(t_us);
  if (!footer_added_ || !writer_.drained()) return;
  const ErrorCode error = writer_.close(t_us);
  if (error != ErrorCode::kNone) {
    fail(error);
  } else if (writer_.closed()) {
    state_ = LoggerState::kStopped;
  }
}

void Recorder::fail(ErrorCode error) {
  error_ = error;
  state_ = LoggerState::kFailed;
}

void Recorder::capture(uint64_t t_us, const protocol::Sample& sample, EventQueue& events) {
  const Capture capture = capture_;
  if (capture == Capture::kOff) {
    events.clear();
    return;
  }
  builder_.flush_if_due(t_us);
  builder_.add_sample(t_us, sample);
  // A chattering input must not fill the card: one block of events an instant, the rest waits.
  uint32_t budget = capture == Capture::kOn ? protocol::kEventsPerBlock : UINT32_MAX;
  for (const protocol::Event* event = events.front(); event != nullptr && budget-- > 0;
       event = events.front()) {
    if (!builder_.add_event(*event)) break;
    events.pop();
  }
  if (capture == Capture::kFinishing) {
    builder_.flush();
    capture_ = Capture::kOff;
  }
}

bool Recorder::take_card_event(protocol::Event& event) {
  const protocol::Event* oldest = card_events_.front();
  if (oldest == nullptr) return false;
  event = *oldest;
  card_events_.pop();
  return true;
}

}  // namespace logger
}  // namespace tfsat
