// The logger as a whole: samples in the timer's interrupt, card and cable in the main loop.
#pragma once

#include "../protocol/link.h"
#include "recorder.h"
#include "sampler.h"

namespace tfsat {
namespace logger {

struct Ports {
  I2cBus& bus_a;  // IMU 1 and 2
  I2cBus& bus_b;  // IMU 3 and 4
  Adc& adc;
  Inputs& inputs;
  BlockSink& card;
  protocol::ByteStream& stream;
  Entropy& entropy;
};

struct Identity {
  uint8_t board_serial[8];
  uint32_t image_crc;  // CRC-32/ISO-HDLC of the flashed image
};

struct Settings {
  uint16_t rate_hz = protocol::kSampleRateHz;  // at which sample() is called
  uint32_t file_blocks = 65536;                // 32 MiB: 23 minutes at 280 Hz
};

class Logger final : private protocol::RequestHandler {
 public:
  // A full turn of an angle sensor spans the 12-bit converter's range.
  static constexpr uint32_t kAngleCountsPerTurn = 4096;

  Logger(const Ports& ports, const Identity& identity, const Settings& settings, Block* ring_blocks,
         uint32_t ring_capacity);

  // From the timer's interrupt, with the time of the tick.
  void sample(uint64_t t_us);
  // From the main loop, as often as possible.
  void poll(uint64_t t_us);

  protocol::LoggerState state() const { return recorder_.state(); }
  // What the status light shows: steady while recording, fast blinking after a failure or with an
  // IMU missing, a short flash every 2 s when all is well and nothing is recorded.
  bool light(uint64_t t_us) const;

 private:
  protocol::Reply handle(uint8_t type, const uint8_t* payload, size_t size,
                         uint8_t* reply) override;
  protocol::Reply hello(uint8_t* reply) const;
  protocol::Reply status(uint8_t* reply);
  protocol::Reply record_start(const uint8_t* payload, size_t size, uint8_t* reply);
  protocol::Reply record_stop(uint8_t* reply);
  protocol::Reply live(const uint8_t* payload, size_t size, uint8_t* reply);

  protocol::LogHeader log_header() const;
  uint32_t new_session();
  void collect_events(const Instant& instant);
  void send_live();

  // Interrupt.
  Sampler sampler_;
  EventQueue events_;
  Instant instant_ = {};
  uint32_t sample_index_ = 0;
  uint8_t strokes_ = 0;  // in this recording

  // Both.
  Recorder recorder_;
  SpscQueue<protocol::LiveSampleStream, 8> live_samples_;
  std::atomic<bool> live_{false};
  Inputs& inputs_;

  // Main loop.
  protocol::Link link_;
  protocol::ByteStream& stream_;
  Entropy& entropy_;
  Identity identity_;
  Settings settings_;
  uint64_t now_us_ = 0;
};

}  // namespace logger
}  // namespace tfsat
