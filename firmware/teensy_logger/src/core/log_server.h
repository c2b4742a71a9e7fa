// Hands recordings over the cable, so that nobody has to pull the card: from its files, and number 0
// from RAM.
//
// The host asks for some blocks at a time. They go out as unasked frames whenever the link has room;
// what the cable loses, the host asks for again, and each block carries its own CRC.
#pragma once

#include "../protocol/link.h"
#include "recorder.h"

namespace tfsat {
namespace logger {

class LogServer {
 public:
  LogServer(LogArchive& archive, Recorder& recorder) : archive_(archive), recorder_(recorder) {}

  // Main loop, while nothing is recorded.
  protocol::LogListReply list(uint16_t from);
  // How many blocks will be sent. Errors: kNoSuchLog, kLogChanged, and what the card says.
  protocol::ErrorCode begin_read(const protocol::LogReadRequest& request, uint16_t& count);
  protocol::ErrorCode erase(const protocol::LogEraseRequest& request);

  // Main loop. Sends one frame; false when there is none, or the link has no room.
  bool poll(protocol::Link& link);
  // Forgets what is still to be sent.
  void end() { left_ = 0; }

 private:
  static constexpr uint16_t kRam = 0;
  // Zero blocks that are looked at in one pass of the main loop.
  static constexpr uint16_t kZeroRun = 16;
  static constexpr uint8_t kParts = protocol::kBlockBytes / protocol::kLogPartBytes;
  static_assert(kParts * protocol::kLogPartBytes == protocol::kBlockBytes, "whole parts");

  bool find(uint16_t number, protocol::LogEntry& entry);
  protocol::LogEntry describe(uint16_t number, uint32_t n_blocks);
  protocol::ErrorCode check(uint16_t number, uint32_t session, protocol::LogEntry& entry);
  protocol::ErrorCode read(uint16_t number, uint32_t index);
  bool head_of(uint16_t number, uint32_t index, protocol::BlockHeader& head);
  bool block_is_zero() const;
  bool send_part(protocol::Link& link);
  bool send_zeros(protocol::Link& link);
  void advance(uint16_t blocks);

  LogArchive& archive_;
  Recorder& recorder_;
  Block block_;
  uint16_t number_ = 0;
  uint32_t block_index_ = 0;  // to be sent next
  uint16_t left_ = 0;         // blocks still to be sent, this one included
  uint8_t part_ = 0;
  bool loaded_ = false;  // block_ holds it
};

}  // namespace logger
}  // namespace tfsat
