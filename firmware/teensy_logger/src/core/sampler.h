// All sensors at one instant, each with its own validity: a dead one costs the others nothing.
#pragma once

#include "mpu6050.h"
#include "timing.h"

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
  protocol::Event events[protocol::kImuCount];   // sensors that missed, failed, or came back
  uint8_t event_count;
};

// Bodies 1 and 2 are on bus A at 0x68 and 0x69, bodies 3 and 4 on bus B. The bursts of bodies 1 and
// 3 begin at the instant's time, those of 2 and 4 one burst later: 0.39 ms at 400 kHz, 1.56 ms at
// 100 kHz; so also where the first is not read. The angles are converted while the first bursts are
// under way.
class Sampler {
 public:
  Sampler(I2cBus& bus_a, I2cBus& bus_b, Adc& adc, Inputs& inputs);

  // Bus clocks, ranges and filters; all IMUs are identified and configured anew. Nothing is read
  // before the first call. Not while sample() can be called.
  void apply(const protocol::LoggerSettings& settings);

  // Called from the interrupt. Two bursts long (0.8 ms at 400 kHz), and whatever fails, shorter
  // than the period of the highest rate that the buses carry (timing.h).
  void sample(uint64_t t_us, Instant& instant);

  // Bits 0-3: IMU 1-4 answers.
  uint8_t imu_present() const;
  void copy_who_am_i(uint8_t who_am_i[protocol::kImuCount]) const;

 private:
  static constexpr uint8_t kImusPerBus = protocol::kImusPerBus;
  static constexpr uint8_t kBusCount = protocol::kImuCount / kImusPerBus;

  // One bus with its sensors, read one after the other while the other bus does the same.
  class Lane {
   public:
    Lane(I2cBus& bus, uint32_t& recovering_us) : bus_(bus), recovering_us_(recovering_us) {}

    void apply(const protocol::LoggerSettings& settings);
    // A new instant: its first transfer goes out.
    void begin(uint64_t t_us);
    // Moves on as far as is possible now; false when all sensors of this instant are through.
    bool advance(uint64_t t_us);
    const Mpu6050& imu(uint8_t i) const { return imus_[i]; }

   private:
    bool start_next(uint64_t t_us);
    bool start_check(uint64_t t_us);
    void finish(I2cResult result, uint64_t t_us);
    uint32_t longest_us(I2cResult result) const;
    bool room_for(uint32_t us) const { return used_us_ + recovering_us_ + us <= period_us_; }
    bool any_doubted() const;
    bool checked_first(const Mpu6050& imu) const { return check_first_ && imu.doubted(); }
    bool room_for_read(uint32_t bytes) const;
    void recover();
    void give_up(I2cResult result, uint64_t t_us);

    I2cBus& bus_;
    uint32_t& recovering_us_;
    Mpu6050 imus_[kImusPerBus] = {Mpu6050(0x68), Mpu6050(0x69)};
    uint32_t period_us_ = 0;
    uint32_t used_us_ = 0;  // for transfers of this instant, at most
    uint16_t khz_ = 0;
    uint8_t next_ = 0;
    uint8_t next_check_ = 0;
    bool check_first_ = false;  // a check finds no room behind two bursts
    bool transferring_ = false;
    bool recovered_ = false;  // at this instant
    // The one before calls for no transfer. So that the next is read when the header says, a burst of
    // its own goes first, which is not looked at; what happens to it is booked to no sensor.
    bool passing_time_ = false;
  };

  const Mpu6050& imu(uint8_t i) const { return lanes_[i / kImusPerBus].imu(i % kImusPerBus); }
  void read_pins(protocol::Sample& sample);
  void finish_transfers(uint64_t t_us);
  void take_readings(Instant& instant);
  void note_change(uint8_t imu_index, Instant& instant);

  uint32_t recovering_us_ = 0;  // at this instant, which nothing else goes on beside
  Lane lanes_[kBusCount];
  // As last told by an event.
  struct Told {
    bool running;
    protocol::ErrorCode error;
  } told_[protocol::kImuCount] = {};
  Adc& adc_;
  Inputs& inputs_;
};

}  // namespace logger
}  // namespace tfsat
