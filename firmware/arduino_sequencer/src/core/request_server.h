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
  uint8_t brown_out_level;  // see SequencerStatusReply
};

class RequestServer : public protocol::RequestHandler {
 public:
  RequestServer(Sequencer& sequencer, const Identity& identity, Health& health)
      : sequencer_(sequencer),
        identity_(identity),
        health_(health),
        upload_(sequencer.maneuvers()) {}

  // For the requests that follow: the time, and how many frames the link has rejected.
  void update(tick_t now, uint16_t frames_rejected) {
    now_ = now;
    frames_rejected_ = frames_rejected;
  }

  protocol::Reply handle(uint8_t type, const uint8_t* payload, size_t size,
                         uint8_t* reply) override;

 private:
  protocol::Reply hello(uint8_t* reply);
  protocol::Reply status(uint8_t* reply);
  protocol::Reply maneuver_begin(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply maneuver_stroke(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply maneuver_commit(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply maneuver_info(uint8_t* reply);
  protocol::Reply maneuver_read(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply store_staged(SlotPair& store, bool& written, uint8_t* reply);
  protocol::Reply settings_write(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply settings_read(uint8_t* reply);
  protocol::Reply joint_report(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply jog(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply arm(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply disarm(uint8_t* reply);

  Sequencer& sequencer_;
  const Identity& identity_;
  Health& health_;
  Upload upload_;
  tick_t now_;  // both by update()
  uint16_t frames_rejected_;
  bool maneuver_written_ = false;  // a commit of this upload changed the store
  bool settings_written_ = false;  // one of the copies of the last settings_write did
};

}  // namespace sequencer
}  // namespace tfsat
