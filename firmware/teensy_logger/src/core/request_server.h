// What a host may ask of the logger, and the answers.
#pragma once

#include "../protocol/link.h"
#include "card_watch.h"
#include "file_budget.h"
#include "log_server.h"
#include "recorder.h"
#include "sampler.h"
#include "settings.h"

namespace tfsat {
namespace logger {

struct Identity {
  uint8_t board_serial[8];
  uint32_t image_crc;  // CRC-32/ISO-HDLC of the flashed image
};

// A full turn of an angle sensor spans the 12-bit converter's range.
constexpr uint32_t kAngleCountsPerTurn = 4096;

constexpr uint32_t file_blocks(const protocol::LoggerSettings& settings) {
  return settings.file_mib * kBlocksPerMib;
}

// What a request may change about sampling itself.
class Control {
 public:
  // Stores checked settings and samples by them; false when they were not kept.
  virtual bool apply(const protocol::LoggerSettings& settings) = 0;
  virtual void set_live(bool enabled) = 0;
  virtual bool live() const = 0;
  virtual uint32_t new_session() = 0;
  virtual uint32_t late_ticks() const = 0;

 protected:
  ~Control() = default;
};

struct Parts {
  Sampler& sampler;
  Inputs& inputs;
  Recorder& recorder;
  BlockSink& card;
  CardWatch& card_watch;
  LogServer& log_server;
  SettingsStore& settings;
};

class RequestServer final : public protocol::RequestHandler {
 public:
  RequestServer(Control& control, const Identity& identity, const Parts& parts)
      : control_(control), identity_(identity), parts_(parts) {}

  // The time at which the requests of this pass of the main loop are served.
  void set_now(uint64_t t_us) { now_us_ = t_us; }

  // A recording whose file is full goes on in the next, with the same maneuver in its header.
  void start_next_file();

  protocol::Reply handle(uint8_t type, const uint8_t* payload, size_t size,
                         uint8_t* reply) override;

 private:
  protocol::Reply hello(uint8_t* reply) const;
  protocol::Reply status(uint8_t* reply);
  protocol::Reply settings_read(uint8_t* reply);
  protocol::Reply settings_write(const protocol::LoggerSettingsWriteRequest& request,
                                 uint8_t* reply);
  protocol::Reply record_start(const protocol::RecordStartRequest& request, uint8_t* reply);
  protocol::Reply record_stop(uint8_t* reply);
  protocol::Reply live(const protocol::LiveRequest& request, uint8_t* reply);
  protocol::Reply clock_set(const protocol::ClockSetRequest& request, uint8_t* reply);
  protocol::Reply log_list(const protocol::LogListRequest& request, uint8_t* reply);
  protocol::Reply log_read(const protocol::LogReadRequest& request, uint8_t* reply);
  protocol::Reply log_erase(const protocol::LogEraseRequest& request, uint8_t* reply);

  // Decodes a request and hands it to its function.
  template <typename Request>
  protocol::Reply serve(protocol::Reply (RequestServer::*function)(const Request&, uint8_t*),
                        const uint8_t* payload, size_t size, uint8_t* reply) {
    Request request;
    if (!request.decode(payload, size)) {
      return protocol::Reply::refused(protocol::ErrorCode::kBadLength);
    }
    return (this->*function)(request, reply);
  }

  protocol::ErrorCode why_no_log(uint16_t number, protocol::ErrorCode error);
  bool busy() const { return parts_.recorder.uses_card() || parts_.recorder.capturing(); }
  // What a request for the card's recordings is refused with, or kNone.
  protocol::ErrorCode no_card_access();
  bool card_is_counted() { return parts_.card.inspect(0) != protocol::ErrorCode::kBusy; }
  protocol::CardState card_state() const;
  void set_clock(uint64_t unix_us) { unix_at_zero_us_ = unix_us > now_us_ ? unix_us - now_us_ : 0; }
  Recorder::Plan plan() const;
  protocol::LogHeader log_header() const;

  Control& control_;
  Identity identity_;
  Parts parts_;
  uint64_t now_us_ = 0;
  uint64_t unix_at_zero_us_ = 0;  // 0: nobody has set the clock
};

}  // namespace logger
}  // namespace tfsat
