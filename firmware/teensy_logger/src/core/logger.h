// The logger as a whole: samples in the timer's interrupt, card and cable in the main loop.
#pragma once

#include "request_server.h"

namespace tfsat {
namespace logger {

struct Ports {
  I2cBus& bus_a;  // IMU 1 and 2
  I2cBus& bus_b;  // IMU 3 and 4
  Adc& adc;
  Inputs& inputs;
  SampleTimer& timer;
  BlockSink& card;
  LogArchive& archive;
  NonVolatile& memory;
  protocol::ByteStream& stream;
  Entropy& entropy;
};

class Logger final : private Control {
 public:
  Logger(const Ports& ports, const Identity& identity, Block* ring_blocks, uint32_t ring_capacity);

  // Once, when the hardware is ready: loads the settings and starts sampling.
  void begin();
  // From the timer's interrupt, with the time of the tick.
  void sample(uint64_t t_us);
  // From the main loop, as often as possible.
  void poll(uint64_t t_us);

  protocol::LoggerState state() const { return recorder_.state(); }
  // What the status light shows: steady while recording, fast blinking after a failure, with an IMU
  // missing or with a card that could not record, a short flash every 2 s when all is well and
  // nothing is recorded.
  bool light(uint64_t t_us) const;

 private:
  // Frames of a recording that may go out in one pass of the main loop.
  static constexpr uint8_t kLogFrames = 16;
  // A chattering input leaves room in the queue for what one instant may add: each IMU's fault, a
  // late tick, a high water.
  static constexpr uint32_t kOwnEvents = protocol::kImuCount + 2;
  // All that the board keeps between two instants; noise gets no more of the interrupt's time.
  static constexpr uint32_t kEdgesAnInstant = 64;

  bool apply(const protocol::LoggerSettings& settings) override;
  void set_live(bool enabled) override { live_ = enabled; }
  bool live() const override { return live_; }
  uint32_t new_session() override;
  uint32_t late_ticks() const override { return late_ticks_; }

  void use_settings();
  void collect_events(uint64_t t_us);
  void push_edge(const Edge& edge);
  void send_live();

  // Interrupt.
  Sampler sampler_;
  Instant instant_ = {};
  IntervalStats intervals_;
  uint32_t sample_index_ = 0;
  uint32_t session_ = 0;  // of the recording that the next two belong to
  uint8_t strokes_ = 0;
  uint32_t edges_not_kept_ = 0;  // since the last one that was
  EventQueue events_;

  // Both.
  Recorder recorder_;
  SpscQueue<protocol::LiveSampleStream, 64> live_samples_;
  std::atomic<bool> live_{false};
  std::atomic<uint32_t> late_ticks_{0};
  Inputs& inputs_;

  // Main loop.
  SampleTimer& timer_;
  SettingsStore settings_;
  CardWatch card_watch_;
  LogServer log_server_;
  RequestServer requests_;
  protocol::Link link_;
  protocol::ByteStream& stream_;
  Entropy& entropy_;
};

}  // namespace logger
}  // namespace tfsat
