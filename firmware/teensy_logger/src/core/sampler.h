// All sensors at one instant, each with its own validity: a dead one costs the others nothing.
#pragma once

#include "mpu6050.h"

namespace tfsat {
namespace logger {

// Bits of Sample::flags.
namespace sample_flags {
constexpr uint16_t imu_valid(uint32_t imu) { return static_cast<uint16_t>(1u << imu); }
constexpr uint16_t angle_valid(uint32_t sensor) {
  return static_cast<uint16_t>(1u << (4 + sensor));
}
constexpr uint16_t switch_open(uint32_t index) { return static_cast<uint16_t>(1u << (10 + index)); }
constexpr uint16_t imu_clipped(uint32_t imu) { return static_cast<uint16_t>(1u << (12 + imu)); }
}  // namespace sample_flags

// What one instant gave.
struct Instant {
  uint64_t t_us;
  protocol::Sample sample;                       // time_offset_us is 0; invalid sensors read 0
  protocol::Event events[protocol::kImuCount];   // sensors that failed or came back
  uint8_t event_count;
};

// Bodies 1 and 2 are on bus A at 0x68 and 0x69, bodies 3 and 4 on bus B. At 400 kHz the bursts of
// bodies 1 and 3 begin about 0.03 ms after the instant's time, those of 2 and 4 about 0.42 ms after
// it.
class Sampler {
 public:
  Sampler(I2cBus& bus_a, I2cBus& bus_b, Adc& adc, Inputs& inputs);

  // Called from the interrupt. Takes at most four transfer deadlines, two a bus.
  void sample(uint64_t t_us, Instant& instant);

  // Bits 0-3: IMU 1-4 answers.
  uint8_t imu_present() const;
  void copy_who_am_i(uint8_t who_am_i[protocol::kImuCount]) const;

 private:
  static constexpr uint8_t kImusPerBus = 2;
  static constexpr uint8_t kBusCount = 2;

  // One bus with its sensors, read one after the other while the other bus does the same.
  class Lane {
   public:
    explicit Lane(I2cBus& bus) : bus_(bus) {}

    void begin() { next_ = 0; }
    // Moves on as far as is possible now; false when all sensors of this instant are through.
    bool advance(uint64_t t_us);
    const Mpu6050& imu(uint8_t i) const { return imus_[i]; }

   private:
    void finish(I2cResult result, uint64_t t_us);

    I2cBus& bus_;
    Mpu6050 imus_[kImusPerBus] = {Mpu6050(0x68), Mpu6050(0x69)};
    uint8_t next_ = 0;
    bool transferring_ = false;
  };

  const Mpu6050& imu(uint8_t i) const { return lanes_[i / kImusPerBus].imu(i % kImusPerBus); }
  void read_imus(Instant& instant);
  void note_change(uint8_t imu_index, bool was_running, Instant& instant) const;

  Lane lanes_[kBusCount];
  Adc& adc_;
  Inputs& inputs_;
};

}  // namespace logger
}  // namespace tfsat
