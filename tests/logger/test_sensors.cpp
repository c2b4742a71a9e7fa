// Sensors that fail in every way they do: the others lose nothing, and what comes back is used
// again.
#include <vector>

#include "../../firmware/teensy_logger/src/core/sampler.h"
#include "check.h"
#include "sensors/i2c_bus.h"
#include "sensors/mpu6050.h"

using namespace tfsat;
using logger::I2cResult;
using logger::Instant;
using protocol::ErrorCode;
using protocol::EventCode;

namespace {

// The emulated bus as the core's port; a transfer takes a few polls, and it can hang.
class Port final : public logger::I2cBus {
 public:
  void start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) override {
    begin(address, bus.read(address, reg, data, size));
  }
  void start_write(uint8_t address, uint8_t reg, uint8_t value) override {
    begin(address, bus.write(address, reg, &value, 1));
  }
  I2cResult poll() override {
    if (polls_left_ > 0) {
      --polls_left_;
      return I2cResult::kBusy;
    }
    return result_;
  }
  void recover() override {
    ++recoveries;
    bus.clock_free();
  }

  emulator::I2cBus bus;
  uint8_t hanging_address = 0;
  int transfers = 0, recoveries = 0;

 private:
  void begin(uint8_t address, bool acknowledged) {
    ++transfers;
    polls_left_ = 3;
    result_ = acknowledged ? I2cResult::kDone : I2cResult::kNack;
    if (bus.stuck()) result_ = I2cResult::kStuck;
    if (address == hanging_address) result_ = I2cResult::kTimeout;
  }

  I2cResult result_ = I2cResult::kDone;
  int polls_left_ = 0;
};

class Angles final : public logger::Adc {
 public:
  uint8_t read(uint16_t counts[protocol::kAngleSensorCount]) override {
    for (uint16_t i = 0; i < protocol::kAngleSensorCount; ++i) {
      counts[i] = static_cast<uint16_t>(1000 + i);
    }
    return converted;
  }
  uint8_t converted = 0x3F;
};

class Switches final : public logger::Inputs {
 public:
  bool take_edge(logger::Edge&) override { return false; }
  uint8_t switches_open() override { return open; }
  uint8_t open = 0;
};

struct Bench {
  explicit Bench(int clone = -1) : imus(4) {
    for (size_t i = 0; i < 4; ++i) {
      if (static_cast<int>(i) == clone) {
        emulator::Mpu6050Parameters parameters;
        parameters.who_am_i = 0x70;
        imus[i] = emulator::Mpu6050(parameters);
      }
      (i < 2 ? port_a : port_b).bus.attach(static_cast<uint8_t>(0x68 + i % 2), imus[i]);
    }
  }
  void tick() {
    t_us += 3571;
    for (size_t i = 0; i < imus.size(); ++i) {
      imus[i].sample(t_us, {rate_rad_s, 0.1 * static_cast<double>(i), 0}, {0, 0, force_m_s2}, 25.0);
    }
    sampler.sample(t_us, instant);
    for (uint8_t e = 0; e < instant.event_count; ++e) events.push_back(instant.events[e]);
  }
  void run_ms(uint32_t ms) {
    for (const uint64_t end_us = t_us + 1000u * ms; t_us < end_us;) tick();
  }
  bool valid(int imu) const { return (instant.sample.flags >> imu) & 1; }
  // Runs and counts the instants in which an IMU other than `except` was not valid.
  int lost_by_others(uint32_t ms, int except) {
    int lost = 0;
    for (const uint64_t end_us = t_us + 1000u * ms; t_us < end_us;) {
      tick();
      for (int i = 0; i < 4; ++i) lost += i != except && !valid(i);
    }
    return lost;
  }

  Port port_a, port_b;
  Angles angles;
  Switches switches;
  std::vector<emulator::Mpu6050> imus;
  logger::Sampler sampler{port_a, port_b, angles, switches};
  Instant instant = {};
  std::vector<protocol::Event> events;
  uint64_t t_us = 0;
  double rate_rad_s = 1.0;
  double force_m_s2 = 9.80665;
};

}  // namespace

TEST_CASE(all_sensors_come_up_with_the_paper_s_range) {
  Bench bench;
  bench.run_ms(300);
  CHECK(bench.sampler.imu_present() == 0x0F);
  CHECK((bench.instant.sample.flags & 0xF3FF) == 0x03FF);
  for (int i = 0; i < 4; ++i) {
    const protocol::ImuReading& reading = bench.instant.sample.imu[i];
    CHECK_NEAR(reading.gyro[0] / 65.5, 57.29578, 0.05);
    CHECK_NEAR(reading.gyro[1] / 65.5, 5.729578 * i, 0.05);
    CHECK_NEAR(reading.accel[2] / 2048.0, 1.0, 0.001);
    CHECK_NEAR(reading.temperature / 340.0 + 36.53, 25.0, 0.01);
  }
  for (uint16_t i = 0; i < 6; ++i) CHECK(bench.instant.sample.angle[i] == 1000 + i);
  uint8_t who_am_i[4];
  bench.sampler.copy_who_am_i(who_am_i);
  for (const uint8_t id : who_am_i) CHECK(id == 0x68);
}

TEST_CASE(switches_and_angles_carry_their_flags) {
  Bench bench;
  bench.switches.open = 0x02;
  bench.angles.converted = 0x3E;
  bench.run_ms(10);
  CHECK((bench.instant.sample.flags & 0x0C00) == 0x0800);
  CHECK((bench.instant.sample.flags & 0x03F0) == 0x03E0);
  CHECK(bench.instant.sample.angle[0] == 0 && bench.instant.sample.angle[1] == 1001);
}

TEST_CASE(a_reading_at_the_end_of_its_range_is_flagged) {
  Bench bench;
  bench.run_ms(300);
  CHECK((bench.instant.sample.flags & 0xF000) == 0);
  bench.force_m_s2 = 300.0;
  bench.run_ms(100);
  CHECK((bench.instant.sample.flags & 0xF00F) == 0xF00F);
  CHECK(bench.instant.sample.imu[0].accel[2] == 32767);
}

TEST_CASE(a_dead_sensor_costs_the_others_nothing_and_comes_back) {
  for (int dead = 0; dead < 4; ++dead) {
    Bench bench;
    bench.run_ms(300);
    bench.events.clear();
    bench.imus[static_cast<size_t>(dead)].set_fault(emulator::Mpu6050Fault::kDead);
    CHECK(bench.lost_by_others(1000, dead) == 0);
    CHECK(!bench.valid(dead) && bench.instant.sample.imu[dead].accel[2] == 0);
    CHECK(bench.events.size() == 1 && bench.events[0].code == EventCode::kSensorFault);
    CHECK(bench.events[0].index == dead);
    CHECK(bench.events[0].arg == static_cast<uint16_t>(ErrorCode::kSensorMissing));
    bench.imus[static_cast<size_t>(dead)].set_fault(emulator::Mpu6050Fault::kNone);
    CHECK(bench.lost_by_others(300, dead) == 0);
    CHECK(bench.valid(dead) && bench.sampler.imu_present() == 0x0F);
    CHECK(bench.events.size() == 2 && bench.events[1].code == EventCode::kSensorRecovered);
  }
}

TEST_CASE(a_sensor_that_restarted_is_configured_anew) {
  Bench bench;
  bench.run_ms(300);
  bench.events.clear();
  bench.imus[2].power_up(bench.t_us);
  bench.tick();
  CHECK(!bench.valid(2));
  CHECK(bench.lost_by_others(300, 2) == 0);
  CHECK(bench.valid(2));
  CHECK_NEAR(bench.instant.sample.imu[2].gyro[0] / 65.5, 57.29578, 0.05);
  CHECK(bench.events.size() == 2);
}

TEST_CASE(another_chip_is_not_believed_and_its_id_is_told) {
  Bench bench(1);
  bench.run_ms(300);
  CHECK(bench.sampler.imu_present() == 0x0D && !bench.valid(1));
  uint8_t who_am_i[4];
  bench.sampler.copy_who_am_i(who_am_i);
  CHECK(who_am_i[1] == 0x70 && who_am_i[0] == 0x68);
}

TEST_CASE(a_stuck_bus_is_clocked_free) {
  Bench bench;
  bench.run_ms(300);
  bench.events.clear();
  bench.port_a.bus.set_stuck(true);
  bench.tick();
  CHECK((bench.instant.sample.flags & 0x0F) == 0x0E || (bench.instant.sample.flags & 0x0F) == 0x0C);
  CHECK(bench.port_a.recoveries == 1);
  CHECK(!bench.events.empty());
  CHECK(bench.events[0].arg == static_cast<uint16_t>(ErrorCode::kBusStuck));
  bench.run_ms(300);
  CHECK(bench.sampler.imu_present() == 0x0F);
}

TEST_CASE(a_shorted_bus_costs_the_other_bus_nothing_and_is_not_hammered) {
  Bench bench;
  bench.run_ms(300);
  bench.port_b.bus.set_stuck(true, true);
  bench.tick();
  const int transfers = bench.port_b.transfers;
  for (int i = 0; i < 280; ++i) {
    bench.tick();
    CHECK((bench.instant.sample.flags & 0x0F) == 0x03);
  }
  CHECK(bench.port_b.transfers - transfers <= 22);  // two sensors, ten tries a second
}

TEST_CASE(a_transfer_that_hangs_is_given_up) {
  Bench bench;
  bench.run_ms(300);
  bench.port_a.hanging_address = 0x69;
  bench.tick();
  CHECK(bench.lost_by_others(500, 1) == 0);
  CHECK(!bench.valid(1) && bench.port_a.recoveries > 0);
  bench.port_a.hanging_address = 0;
  bench.run_ms(300);
  CHECK(bench.valid(1));
}
