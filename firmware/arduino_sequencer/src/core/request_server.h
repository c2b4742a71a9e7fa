// What each request of the protocol does to the sequencer.
#pragma once

#include "../protocol/link.h"
#include "sequencer.h"
#include "upload.h"

namespace tfsat {
namespace sequencer {

// What the hardware knows of itself.
struct Identity {
  uint8_t board_serial[8];
  uint32_t image_crc;
  protocol::ResetCause reset_cause;
};

class RequestServer : public protocol::RequestHandler {
 public:
  RequestServer(Sequencer& sequencer, const Identity& identity)
      : sequencer_(sequencer), identity_(identity) {}

  // Time for the requests that follow.
  void set_now(tick_t now) { now_ = now; }

  protocol::Reply handle(uint8_t type, const uint8_t* payload, size_t size, uint8_t* reply) override;

 private:
  protocol::Reply hello(uint8_t* reply);
  protocol::Reply status(uint8_t* reply);
  protocol::Reply maneuver_begin(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply maneuver_stroke(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply maneuver_commit(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply maneuver_info(uint8_t* reply);
  protocol::Reply maneuver_read(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply arm(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply disarm(uint8_t* reply);

  Sequencer& sequencer_;
  const Identity& identity_;
  Upload upload_;
  tick_t now_ = 0;
  bool written_ = false;  // the last commit of this upload changed the store
};

}  // namespace sequencer
}  // namespace tfsat
